"""Normal forms of folds, flips, tori and crossings of branches, and what follows from them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.normal_forms.directional import (
    ROUNDING,
    Differences,
    Estimate,
    differences,
    extrapolate,
)
from nonsmooth.analysis.normal_forms.map_forms import (
    Critical,
    critical,
    cubic_of_crossing,
    cubic_of_flip,
    cubic_of_torus,
    quadratic,
    solve_beside,
)
from nonsmooth.analysis.normal_forms.normal_form import NormalForm, side_of
from nonsmooth.periodic_orbits.word_map import Image, WordMap

__all__ = ["KINDS", "cubic_of", "form_of_smooth"]

Floats = npt.NDArray[np.float64]

KINDS = ("fold", "flip", "torus", "symmetry_breaking", "branch_point")

_TARGETS = {
    "fold": 1.0, "flip": -1.0, "torus": None, "symmetry_breaking": 1.0, "branch_point": 1.0,
}  # fmt: skip
# distance of the multiplier from its place; a fold is known to half the digits only
_CRITICAL = {"fold": 1e-3, "symmetry_breaking": 1e-3, "branch_point": 1e-3}
_CRITICAL_ELSE = 1e-5
_SECOND = 1e-6  # distance of another multiplier from the unit circle: two things at once
_HALF_DIGITS = 1e-6  # of the sizes of the states: how far from a crossing its point may lie
_RESONANT = 0.01  # distance of the rotation number from 1/4, 1/3, 1/2 and 1, in turns
_RESONANCES = {"1:1": 0.0, "1:2": 1 / 2, "1:3": 1 / 3, "1:4": 1 / 4}


class _CriticalPoint(NamedTuple):
    """A special point with what its normal form is made of."""

    near: WordMap
    image: Image
    here: Critical
    width: float  # what counts as large for the parameter
    name: str  # of the parameter
    distance: float  # of the multiplier from its place

    @property
    def jacobian(self) -> Floats:
        return self.image.by_start

    @property
    def slope(self) -> Floats:
        """What the section point changes by with the parameter, where no multiplier is 1."""
        unit = np.eye(self.jacobian.shape[0])
        return np.asarray(np.linalg.solve(unit - self.jacobian, self.image.by_parameter))

    def along(self, direction: Floats, by_parameter: float = 0.0, **levels: int) -> Differences:
        return differences(self.near, direction, by_parameter, self.width, **levels)

    def blurred(self, found: Estimate) -> Estimate:
        """With the error that a point has which is located to so many digits only."""
        return Estimate(found.value, found.error + self.distance * abs(found.value))


def form_of_smooth(near: WordMap, kind: str, width: float, name: str) -> NormalForm:
    """Normal form of a special point of one of `KINDS`; ``width`` and ``name`` of the parameter."""
    image = near.image(near.start, near.value)
    if image is None or not np.all(np.isfinite(image.by_start)):
        return NormalForm(detail="the return map has no derivative at this point")
    target = _TARGETS[kind]
    here = critical(image.by_start, near.sizes, target)
    distance = abs(abs(here.multiplier) - 1.0) if target is None else abs(here.multiplier - target)
    form = NormalForm(
        outside=int(np.count_nonzero(np.abs(here.others) > 1.0 + _SECOND)),
        right=here.right * near.sizes, left=here.left / near.sizes,
    )  # fmt: skip
    if not distance <= _CRITICAL.get(kind, _CRITICAL_ELSE):
        form.detail = (
            f"the multiplier {here.multiplier:.6g} is not where a {kind.replace('_', ' ')} has it"
        )
        return form
    if np.any(np.abs(np.abs(here.others) - 1.0) <= _SECOND):
        form.detail = "another multiplier lies on the unit circle too: two things happen at once"
        return form
    if near.vanishing:
        form.detail = "the itinerary changes at this point too: two things happen at once"
        return form
    point = _CriticalPoint(near, image, here, width, name, distance)
    lines = point.along(here.right.real)
    form.reach, form.narrow = lines.reach, lines.narrow
    _FORMS[kind](point, form, lines)
    if form.narrow and form.power > 0.0:
        part = (form.reach / form.amplitude) ** (1.0 / form.power)
        form.detail += f"; its itinerary was found the same for {part:.2g} of {name}"
    return form


def cubic_of(near: WordMap, kind: str, levels: int) -> tuple[Critical, Estimate] | None:
    """The cubic coefficient of a flip or a torus with its multipliers; None where it has none.

    levels: steps of differences; fewer than usual take less time and tell fewer digits
    """
    image = near.image(near.start, near.value)
    if image is None or not np.all(np.isfinite(image.by_start)) or near.vanishing:
        return None
    here = critical(image.by_start, near.sizes, _TARGETS[kind])
    point = _CriticalPoint(near, image, here, 1.0, "", 0.0)
    lines = point.along(here.right.real, levels=levels)
    if kind == "flip":
        return here, _flip_coefficient(point, lines)
    if here.multiplier.imag == 0.0:  # beyond a strong resonance
        return None
    return here, _torus_coefficient(point, lines, point.along(here.right.imag, levels=levels))


def _fold(point: _CriticalPoint, form: NormalForm, lines: Differences) -> None:
    found = point.blurred(extrapolate(lambda d: quadratic(point.here, d[0][:, :-1]), [lines.first]))
    rate = float(point.here.left.real @ point.image.by_parameter)
    size = float(np.abs(point.here.left.real * point.image.by_parameter).max(initial=0.0))
    _fill(form, found, point.blurred(Estimate(rate, ROUNDING * size)))
    if not found.decided:
        form.detail = (
            f"the quadratic coefficient {_told(found)} may be zero: a cusp, or close to one"
        )
        return
    form.criticality = "nondegenerate"
    _root_law(form)
    form.detail = (
        f"two orbits exist {_beyond(form, point)}, and none on the other side"
        if form.side
        else "the parameter's coefficient may be zero: the side is not decided"
    )


def _flip(point: _CriticalPoint, form: NormalForm, lines: Differences) -> None:
    _fill(form, point.blurred(_flip_coefficient(point, lines)), _rate(point, point.slope))
    _judge(form, point, form.coefficient, "orbit of twice the period")


def _flip_coefficient(point: _CriticalPoint, lines: Differences) -> Estimate:
    return extrapolate(
        lambda d: cubic_of_flip(point.here, point.jacobian, d[0][:, :-1], d[1][:, :-1]),
        [lines.first, lines.second],
    )


def _torus(point: _CriticalPoint, form: NormalForm, lines: Differences) -> None:
    other = point.along(point.here.right.imag)
    form.reach, form.narrow = min(form.reach, other.reach), form.narrow or other.narrow
    form.angle = float(np.angle(point.here.multiplier))
    turns = form.angle / (2.0 * np.pi)
    found = point.blurred(_torus_coefficient(point, lines, other))
    _fill(form, found, _rate(point, point.slope))
    form.resonance = next(
        (name for name, at in _RESONANCES.items() if abs(turns - at) <= _RESONANT), ""
    )
    if form.resonance:
        form.detail = (
            f"the rotation number {turns:.6g} is within {_RESONANT:g} of the strong resonance"
            f" {form.resonance}, where the coefficient alone decides nothing"
        )
        return
    _judge(form, point, -form.coefficient, "closed curve of section points")


def _torus_coefficient(point: _CriticalPoint, lines: Differences, other: Differences) -> Estimate:
    """By differences along the real and along the imaginary part of the eigenvector."""
    return extrapolate(
        lambda d: cubic_of_torus(
            point.here, point.jacobian, (d[0][:, :-1], d[1][:, :-1]), (d[2][:, :-1], d[3][:, :-1])
        ),
        [lines.first, other.first, lines.second, other.second],
    )


def _symmetry_breaking(point: _CriticalPoint, form: NormalForm, lines: Differences) -> None:
    slope = solve_beside(point.here, point.jacobian, point.image.by_parameter)
    _fill(form, _cubic(point, lines), _rate(point, slope))
    _judge(form, point, -form.coefficient, "pair of orbits")


def _branch_point(point: _CriticalPoint, form: NormalForm, lines: Differences) -> None:
    """A transcritical crossing, or a pitchfork where its quadratic coefficient vanishes.

    Branches along s q + h solve a s^2 + d s + e = 0, h being the part of their slope beside q. A
    crossing is located to half the digits along q, which leaves a part of the cubic coefficient in
    the quadratic one.
    """
    q, p = point.here.right.real, point.here.left.real
    found = extrapolate(lambda d: quadratic(point.here, d[0][:, :-1]), [lines.first])
    cubic = _cubic(point, lines)
    off = _HALF_DIGITS / max(float(np.abs(q).max()), 1e-300)
    found = Estimate(found.value, found.error + 3.0 * off * (abs(cubic.value) + cubic.error))
    by_parameter = point.image.by_parameter
    slope = solve_beside(point.here, point.jacobian, by_parameter - (p @ by_parameter) * q)
    mixed = _rate(point, slope)
    if not found.decided:
        _fill(form, cubic, mixed)
        _judge(form, point, -form.coefficient, "pair of orbits")
        return
    beside, whole = point.along(slope, 1.0), np.append(slope, 1.0)
    bend = extrapolate(lambda d: p * (d[0] @ whole) / 2.0, [beside.first])
    square = mixed.value**2 - 4.0 * found.value * bend.value
    doubt = 2.0 * abs(mixed.value) * mixed.error + 4.0 * (
        abs(found.value) * bend.error + abs(bend.value) * found.error
    )
    if not square > doubt:
        form.detail = "whether two branches cross here is within the error of their slopes"
        return
    _fill(form, found, Estimate(float(np.sqrt(square)), doubt / (2.0 * float(np.sqrt(square)))))
    form.criticality, form.side = "transcritical", "both"
    form.amplitude, form.power = form.rate / abs(found.value), 1.0
    form.detail = (
        "two branches cross and exchange their stability: on either side of"
        f" {point.name} = {point.near.value:.10g} there are both orbits"
    )


def _cubic(point: _CriticalPoint, lines: Differences) -> Estimate:
    return point.blurred(
        extrapolate(
            lambda d: cubic_of_crossing(point.here, point.jacobian, d[0][:, :-1], d[1][:, :-1]),
            [lines.first, lines.second],
        )
    )


def _rate(point: _CriticalPoint, slope: Floats) -> Estimate:
    """Rate of the modulus of the critical multiplier by the parameter, along the branch.

    That of the multiplier itself where it is real.
    """
    here = point.here
    lines = point.along(slope, 1.0)
    turn = here.multiplier / abs(here.multiplier) if here.multiplier.imag else 1.0
    return extrapolate(
        lambda d: (np.conj(turn * here.left) * (d[0][:, :-1] @ here.right)).real,
        [lines.first],
    )


def _fill(form: NormalForm, found: Estimate, rate: Estimate) -> None:
    form.coefficient, form.error = found
    form.rate, form.rate_error = rate


def _root_law(form: NormalForm) -> None:
    """Orbits whose distance squared is minus the rate over the coefficient, times the parameter."""
    if abs(form.rate) > form.rate_error:
        square = -form.rate / form.coefficient
        form.side, form.power, form.amplitude = side_of(square), 0.5, float(np.sqrt(abs(square)))


def _judge(form: NormalForm, point: _CriticalPoint, sign: float, what: str) -> None:
    """Supercritical where ``sign`` is positive."""
    found = Estimate(form.coefficient, form.error)
    if not found.decided:
        form.detail = f"the cubic coefficient {_told(found)} may have either sign"
        return
    form.criticality = "supercritical" if sign > 0.0 else "subcritical"
    _root_law(form)
    nature = "a stable" if sign > 0.0 and form.outside == 0 else "an unstable"
    where = f"exists {_beyond(form, point)}" if form.side else (
        "begins, on which side is not decided: the multiplier may not pass the unit circle"
    )  # fmt: skip
    form.detail = f"{nature} {what} {where}"


def _told(found: Estimate) -> str:
    return f"{found.value:.3g} +- {found.error:.1g}"


def _beyond(form: NormalForm, point: _CriticalPoint) -> str:
    return f"{form.side} {point.name} = {point.near.value:.10g}"


_FORMS = {
    "fold": _fold, "flip": _flip, "torus": _torus, "symmetry_breaking": _symmetry_breaking,
    "branch_point": _branch_point,
}  # fmt: skip
