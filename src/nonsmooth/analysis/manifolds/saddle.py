"""The orbit as a fixed point of a map: its points, multipliers and directions."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.manifolds.local_map import Coordinates, LocalMap
from nonsmooth.analysis.orbit_search.options import period_of, system_of_one
from nonsmooth.engine.lanes import ANY
from nonsmooth.errors import OptionError, RunWarning, quote, unknown_name
from nonsmooth.leading_entry import leading_entry
from nonsmooth.runs.maps import Map
from nonsmooth.runs.options import finite_number
from nonsmooth.runs.poincare_map import PoincareMap
from nonsmooth.runs.whole_turns import periods_of_states, whole_turns
from nonsmooth.system.system import System

__all__ = [
    "Saddle", "SaddlePoint", "check_orbit", "check_plane", "find_saddle", "with_sides_of",
]  # fmt: skip

Floats = npt.NDArray[np.float64]
Complexes = npt.NDArray[np.complex128]

_LONGEST = 256  # iterates in which an orbit without a period comes back
_SAME = 1e-6  # beside the states: points that an orbit comes back to
_STEPS = 20  # of Newton's method
_CLOSED = 1e-9  # beside the states: what a point of the orbit may leave open
_NEUTRAL = 1e-9  # distance from the unit circle that rounding may make
_REAL = 1e-9  # beside a multiplier: imaginary part that rounding may make
_TIED = 1e-6  # beside the largest entry of a direction: more than an unstable orbit's rounding
_FLAT = 1e-8  # beside the size: how far images may lie off the plane of the directions


class SaddlePoint(NamedTuple):
    """One point of the orbit with its directions, in scaled coordinates."""

    here: LocalMap  # with the point as its origin
    direction: Floats  # (d,) unit vector along the manifold
    dual: Floats  # (d,) left eigenvector, whose product with the direction is one
    leaving: Floats  # (d,) the left eigenvector of the unstable direction


@dataclass(frozen=True)
class Saddle:
    """A periodic orbit of saddle type, as fixed points of a power of a map."""

    chosen: Map  # the power of the map that fixes each point, applied twice where sides change
    period: int  # iterates of the map that was given, after which a point comes back
    turns: Floats  # (n,) what angles grow by meanwhile, zero of other states
    flips: bool  # whether that turns the sides over, so that the map is applied twice
    multipliers: Complexes  # over one period, the largest first
    multiplier: float  # of the manifold, under ``chosen``
    others: float  # the multiplier of other directions that counts, under ``chosen``
    points: tuple[SaddlePoint, ...]
    residual: float  # what the points leave open, beside their states


def check_orbit(system: System, orbit: Any) -> None:
    """Refuse what is no orbit, or one of another system or of other parameters."""
    there = system_of_one(orbit)
    if there.states != system.states or there.mode_names != system.mode_names:
        raise OptionError(
            f"orbit: it belongs to {there.name!r} with the states {', '.join(there.states)}, and"
            f" the map to {system.name!r} with {', '.join(system.states)}; find the orbit in the"
            " system of the map"
        )
    if not np.isfinite([float(orbit[name]) for name in system.states]).all():
        raise OptionError(
            f"orbit: there is no orbit in this dataset, whose message is:"
            f" {orbit.attrs.get('message', '')}"
        )
    mine, theirs = system.parameter_values, there.parameter_values
    for name in mine:
        if name in theirs and mine[name] != theirs[name]:
            raise OptionError(
                f"orbit: it was found at {name} = {theirs[name]:.10g}, and the map has {name} ="
                f" {mine[name]:.10g}; find it with find_orbit(system, orbit) at the parameters of"
                " the map"
            )
    if "admissible" in orbit and not bool(orbit["admissible"]):
        raise OptionError("orbit: it is inadmissible, so no motion follows it; see its message")


def read_scales(system: System, active: npt.NDArray[np.int64], scales: Any) -> Floats:
    """Sizes of the states by which distances are measured, one without a word."""
    names = [system.states[i] for i in active]
    given = {} if scales is None else scales
    if not isinstance(given, Mapping):
        raise OptionError(
            f"scales = {quote(scales)}: give a mapping of states to sizes, such as"
            f" {{{names[0]!r}: 2.0}}"
        )
    found = np.ones(len(names))
    for name, value in given.items():
        if name not in names:
            raise OptionError(f"scales: {unknown_name('state', name, names)}")
        number = finite_number(f"scales[{name!r}]", value)
        if not number > 0.0:
            raise OptionError(f"scales[{name!r}] = {number:g} must be positive")
        found[names.index(name)] = number
    return found


def find_saddle(
    chosen: Map, orbit: Any, which: str, scales: Mapping[str, float] | None, tolerance: float
) -> Saddle:
    """The saddle that an orbit is under a map."""
    system = chosen.system
    check_orbit(system, orbit)
    active = np.array([i for i, s in enumerate(system.states) if s not in system.drift_states])
    state, mode = _first_point(chosen, orbit, tolerance)
    whole = np.eye(active.size)
    frame = Coordinates(state, active, read_scales(system, active, scales), whole)
    near = LocalMap(chosen, tolerance, frame, mode)
    angles = periods_of_states(system)
    period, turns = _period(near, _longest(chosen, orbit), angles)
    power = chosen**period
    turn = LocalMap(power, tolerance, frame, mode, turns)
    origin, jacobian, residual = _fixed_point(turn)
    values, vectors = np.linalg.eig(jacobian)
    order = np.argsort(-np.abs(values), kind="stable")
    values, vectors = values[order].astype(complex), vectors[:, order]
    number = _number_of(values, which, system.name, planar=_is_planar(chosen, active.size))
    flips = bool(values[number].real < 0.0)
    if which == "stable":
        flips |= bool(values[0].real < 0.0)
    if flips:
        turn = LocalMap(power**2, tolerance, frame, mode, 2.0 * turns)
    double = 2 if flips else 1
    origins = [origin]
    for _ in range(period - 1):
        after = near.states_after(origins[-1][None], 1)[0]
        origins.append(after - whole_turns(after - origin, angles))
    points = []
    for i, each in enumerate(origins):
        if i:
            one = LocalMap(power, tolerance, frame, mode, turns).at(each)
            each, jacobian, left = _fixed_point(one)
            residual = max(residual, left)
        points.append(_directed(turn.at(each), jacobian, which))
    rest = np.delete(np.abs(values), number) ** double
    others = rest.max(initial=0.0) if which == "unstable" else np.abs(values[0]) ** double
    return Saddle(
        turn.chosen, period, turns, flips, values, float(values[number].real) ** double,
        float(others), tuple(points), residual,
    )  # fmt: skip


def _is_planar(chosen: Map, count: int) -> bool:
    """Whether points of the map lie in a plane."""
    return count == (3 if isinstance(chosen, PoincareMap) else 2)


def _longest(chosen: Map, orbit: Any) -> int:
    """Iterates in which the orbit is back for certain, or ought to be."""
    driven = chosen.system.period_value is not None and not isinstance(chosen, PoincareMap)
    return max(1, period_of(orbit)) if driven else _LONGEST


def _first_point(chosen: Map, orbit: Any, tolerance: float) -> tuple[Floats, int]:
    """A point of the orbit at the strobe or on the section, and its mode.

    Of the points that are whole turns apart it is the one nearest to where the orbit is given.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)  # what is missing is told below
        point = chosen.iterate(orbit, 1, tolerance=tolerance)
    if point.sizes["point"] < 1:
        raise OptionError(
            f"orbit: it never comes to a point of the map: {point.attrs['message']}; take a"
            " section that the orbit passes"
        )
    state = np.array([float(point[name][0]) for name in chosen.system.states])
    given = np.array([float(orbit[name]) for name in chosen.system.states])
    state -= whole_turns(state - given, periods_of_states(chosen.system))
    mode = int(point["mode"][0])
    return state, mode if mode >= 0 else ANY


def _period(near: LocalMap, longest: int, angles: Floats) -> tuple[int, Floats]:
    """After how many iterates the first point comes back, and after which whole turns."""
    states = first = near.coordinates.origin[None]
    size = 1.0 + np.abs(near.coordinates.points(first * 0.0)).max()
    for count in range(1, longest + 1):
        states = near.states_after(states, 1)
        if not np.isfinite(states).all():
            break
        turns = whole_turns(states - first, angles)
        if np.abs(near.coordinates.points(states - turns)).max() <= _SAME * size:
            return count, turns[0]
    raise OptionError(
        f"orbit: under this map its first point does not come back within {longest} iterates; give"
        " an orbit of the same system and parameters, found with find_orbit"
    )


def _fixed_point(turn: LocalMap) -> tuple[Floats, Floats, float]:
    """Newton's method from the origin: states, scaled derivative, what is left beside the states.

    Points near a very unstable orbit are known to rounding times its multiplier; the step takes
    that away, and the best of all steps counts.
    """
    frame = turn.coordinates
    active, scales = frame.active, frame.scales
    state, best = frame.origin.copy(), None
    for _ in range(_STEPS):
        found = turn.derivative(state)
        if found is None:
            break
        image, whole = found
        left = (image - state)[active] / scales
        jacobian = whole[np.ix_(active, active)] * scales / scales[:, None]
        size = float(np.abs(left).max()) / (1.0 + float(np.abs(state[active] / scales).max()))
        if best is not None and size >= best[2]:
            break
        best = state.copy(), jacobian, size
        try:
            step = np.linalg.solve(jacobian - np.eye(active.size), -left)
        except np.linalg.LinAlgError:
            break
        state[active] += step * scales
    if best is None or best[2] > _CLOSED:
        raise OptionError(
            "orbit: it is no periodic orbit of this map; give one of the same system and"
            " parameters, found with find_orbit"
        )
    return best


def _number_of(values: Complexes, which: str, name: str, *, planar: bool) -> int:
    """Which of the multipliers, the largest first, is that of the manifold."""
    sizes = np.abs(values)
    outside = np.flatnonzero(sizes > 1.0 + _NEUTRAL)
    told = ", ".join(_text(value) for value in values)
    if np.any(np.abs(sizes - 1.0) <= _NEUTRAL):
        raise OptionError(
            f"orbit: a multiplier of {name!r} lies on the unit circle ({told}), so it is no saddle"
        )
    if not outside.size:
        cure = "its stable manifold is its basin" if which == "stable" else "nothing leaves it"
        raise OptionError(
            f"orbit: it is stable, with the multipliers {told}, and {cure}; give a saddle, such as"
            " an unstable orbit of ns.orbits or of a branch"
        )
    if np.any(np.abs(values[outside].imag) > _REAL * sizes[outside]):
        raise OptionError(
            f"orbit: its multipliers {told} are complex outside the unit circle, so motions spiral"
            " away from it on a surface; curves need exactly one real multiplier there"
        )
    if outside.size > 1:
        raise OptionError(
            f"orbit: {outside.size} of its multipliers ({told}) are outside the unit circle, so"
            " its unstable manifold is no curve; give an orbit with exactly one"
        )
    if which == "unstable":
        return 0
    if not planar:
        raise OptionError(
            "which = 'stable': the search needs a map of the plane: the strobes of a system with"
            " two states beside drifts, or a section of one with three; the map has more, so take"
            " which='unstable', or bisect starts between two basins"
        )
    if sizes[1] == 0.0:
        raise OptionError(
            f"which = 'stable': the multiplier of the stable direction is 0 ({told}), so the map"
            " wipes that direction out and its manifold is no curve that a search follows"
        )
    return 1


def _text(value: complex) -> str:
    return f"{value:.6g}" if abs(value.imag) > _REAL * abs(value) else f"{value.real:.6g}"


def _directed(here: LocalMap, jacobian: Floats, which: str) -> SaddlePoint:
    """Directions of a point, in the plane that they span where the stable one is wanted."""
    values, right = np.linalg.eig(jacobian)
    order = np.argsort(-np.abs(values), kind="stable")
    unstable, stable = order[0], order[1] if order.size > 1 else order[0]
    if which == "unstable":
        direction = _oriented(right[:, unstable].real)
        by_left, left = np.linalg.eig(jacobian.T)
        dual = left[:, np.argmin(np.abs(by_left - values[unstable]))].real
        dual = dual / (dual @ direction)
        return SaddlePoint(here, direction, dual, dual)
    along, across = _oriented(right[:, stable].real), _oriented(right[:, unstable].real)
    basis = np.eye(2)
    if along.size > 2:
        basis = np.linalg.qr(np.column_stack([along, across]))[0]
        here = here.at(here.coordinates.origin, basis)
    both = np.linalg.inv(np.column_stack([basis.T @ along, basis.T @ across]))
    return SaddlePoint(here, basis.T @ along, both[0], both[1])


def _oriented(vector: Floats) -> Floats:
    """The unit vector whose largest entry is positive; of equal ones, the first."""
    vector = vector / np.linalg.norm(vector)
    found: Floats = vector * np.sign(vector[leading_entry(vector, _TIED)])
    return found


def with_sides_of(saddle: Saddle, near: Saddle) -> Saddle:
    """The saddle with the sides that one at parameters nearby has.

    The largest entry of a direction may be another one there, and its sign says nothing then.
    """
    if len(saddle.points) != len(near.points):
        raise OptionError(
            f"orbit: it comes back after {len(saddle.points)} iterates, and after"
            f" {len(near.points)} at parameters nearby; follow one orbit with continue_orbit"
        )
    pairs = zip(saddle.points, near.points, strict=True)
    return replace(saddle, points=tuple(_like(*pair) for pair in pairs))


def _like(point: SaddlePoint, near: SaddlePoint) -> SaddlePoint:
    basis, other = point.here.coordinates.basis, near.here.coordinates.basis
    along = np.copysign(1.0, (basis @ point.direction) @ (other @ near.direction))
    across = np.copysign(1.0, (basis @ point.leaving) @ (other @ near.leaving))
    return point._replace(
        direction=along * point.direction, dual=along * point.dual, leaving=across * point.leaving
    )


def check_plane(point: SaddlePoint, size: float) -> None:
    """Refuse a section whose points do not lie in the plane of the directions."""
    here = point.here
    frame = here.coordinates
    if frame.basis.shape[0] == frame.basis.shape[1]:
        return
    probes = size * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [1.0, 1.0]])
    images = here.states_after(frame.states(probes), 1)
    images = images[np.isfinite(images).all(axis=1)]
    away = (images[:, frame.active] - frame.origin[frame.active]) / frame.scales
    off = away - away @ frame.basis @ frame.basis.T
    if np.any(np.abs(off).max(axis=1) > _FLAT * (size + np.abs(away).max(axis=1))):
        raise OptionError(
            "which = 'stable': the section is curved, and the search needs a plane; take a section"
            " by a linear expression of the states, such as 'x = 0.5'"
        )
