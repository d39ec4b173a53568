"""`criticality`: normal forms of the special points of a branch, and what follows from them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.normal_forms.directional import Narrow
from nonsmooth.analysis.normal_forms.grazing import form_of_grazing
from nonsmooth.analysis.normal_forms.normal_form import UNDECIDED, NormalForm
from nonsmooth.analysis.normal_forms.smooth_points import KINDS as OF_SMOOTH
from nonsmooth.analysis.normal_forms.smooth_points import form_of_smooth
from nonsmooth.analysis.options import result_attributes
from nonsmooth.errors import ModelError, OptionError, is_known, quote, unknown_name
from nonsmooth.periodic_orbits.equations import OrbitEquations
from nonsmooth.periodic_orbits.legs import LegError, Legs
from nonsmooth.periodic_orbits.restart import guess_of_dataset
from nonsmooth.periodic_orbits.word_map import WordMap
from nonsmooth.runs.options import finite_number
from nonsmooth.runs.runner import build_tables
from nonsmooth.runs.strobe_times import is_driven
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["criticality"]

KINDS = (*OF_SMOOTH, "grazing")


def criticality(branch: xr.Dataset, special: int | str | None = None) -> xr.Dataset:
    r"""Tell what begins at the special points of a branch: normal forms and their coefficients.

    Parameters
    ----------
    branch : xarray.Dataset
        Result of `continue_orbit`.
    special : int or str, optional
        Number of one of its special points, or a kind: ``fold``, ``flip``, ``torus``,
        ``symmetry_breaking``, ``branch_point`` or ``grazing``. All points of these kinds without
        it.

    Returns
    -------
    xarray.Dataset
        Over ``special``, with the number of each point in the branch as coordinate:

        ``criticality``
            ``nondegenerate`` at a fold; ``supercritical`` or ``subcritical`` at a flip, a torus and
            a pitchfork; ``transcritical`` where two branches cross; at a graze ``continuous``,
            ``nonsmooth fold``, ``jump``, ``period adding``, ``period adding and chaos`` or
            ``chaos``, see the Notes; or ``not decided``.
        ``criticality_detail``
            What follows in words, or the reason why nothing does.
        ``coefficient``, ``coefficient_error``
            Of the normal form, and how far it may be wrong. A sign within the error decides
            nothing. At a graze the product of ``adjoint`` and the jump.
        ``parameter_coefficient``, ``parameter_coefficient_error``
            At a fold by how much the parameter pushes along the eigenvector; at a graze the rate
            of the depth to which the orbit would reach behind the guard; else the rate of the
            multiplier by the parameter along the branch, of its modulus at a torus.
        ``side``
            Where the orbits that meet or begin at the point exist: ``above`` or ``below`` its value
            of the parameter, or on ``both`` sides.
        ``amplitude_factor``, ``amplitude_power``
            These orbits lie ``amplitude_factor * distance**amplitude_power`` away from the orbit of
            the point, along ``eigenvector``, where the distance is that of the parameter. At a
            graze it is the depth, and the vector is the jump by which motions differ a turn later.
        ``reach``
            Displacement along the eigenvector for which the itinerary was found to be the same. It
            is a tenth of the size of the orbit, or less where an event is close.
        ``unstable_directions``
            Number of other multipliers outside the unit circle.
        ``rotation_angle``, ``resonance``
            Of a torus: the angle of the multiplier, and the strong resonance close to it.
        ``eigenvector``, ``adjoint``
            The right eigenvector q and the left one p of the return map. At a graze the direction
            of the jump, and the gradient of the depth by the section point.

    Raises
    ------
    OptionError
        When the branch has no such point.

    See Also
    --------
    continue_orbit : what gives the branch, and follows the orbits that begin at a special point.
    continue_special : the points over a second parameter.

    Notes
    -----
    Let A be the derivative of the return map of the itinerary at the special point, B and C its
    second and third derivatives, :math:`A q = \lambda q`, :math:`A^T p = \bar\lambda p`,
    :math:`\langle q, q\rangle = 1` and :math:`\langle p, q\rangle = 1`. The coefficients are

    .. math::

        \text{fold:} && & \tfrac12 \langle p, B(q, q)\rangle, \\
        \text{flip:} && & \tfrac16 \langle p, C(q, q, q) + 3 B(q, (I - A)^{-1} B(q, q))\rangle, \\
        \text{torus:} && & \tfrac12 \operatorname{Re} e^{-i\theta} \langle p, C(q, q, \bar q)
        + 2 B(q, (I - A)^{-1} B(q, \bar q)) + B(\bar q, (e^{2i\theta} I - A)^{-1} B(q, q))\rangle.

    A flip is supercritical where its coefficient is positive, a torus where it is negative. At a
    pitchfork the formula is that of the flip, with the inverse taken beside q, and a negative
    coefficient is supercritical. States count in their own units, and those that drift do not
    count. So a coefficient has the unit of a state to the power of -1 or -2, and its sign does not
    depend on units.

    The first derivative is exact, through all events. Second and third derivatives are central
    differences of it, extrapolated to no step. The displaced points have the itinerary of the
    orbit: steps begin where that is so, and fall. ``coefficient_error`` is four times the
    disagreement of neighbouring extrapolations, with what rounding does.

    At a graze the guard H has no rate and the curvature :math:`c = d^2 H/dt^2`. A motion that
    reaches the depth d behind it differs a turn later by :math:`E d^s` from one without the guard:

    .. math::

        \text{rigid wall:} && s &= 1/2, & E &= -\sqrt{2/c}\, \Phi (R' f - f), \\
        \text{force that jumps:} && s &= 1/2, & E &= 2 (c/c') \sqrt{2/c}\, \Phi (f' - f), \\
        \text{force that grows:} && s &= 3/2, & E &= -\tfrac43 \sqrt{2/c}\, \Phi w, \\
        \text{plate without mass:} && s &= 1, & E &= (2/c)\, \Phi
        (\rho^2 \dot u'/2 - \rho \dot u).

    Here f are the rates before the guard, f' and c' those and the curvature behind it, R' is the
    derivative of the reset, and :math:`f' - f = w H` at first; :math:`\Phi` is the derivative of
    the section point by the state at the touch. In the last row a relation sets a state, as that of
    a plate without mass, until a force is zero. There :math:`u = f' - f` vanishes at the touch; it
    changes by :math:`\dot u` before and :math:`\dot u'` within a contact, which lasts the part
    :math:`\rho` of the time to the lowest point. With the gradient n of the depth by the section
    point, a multiplier grows as :math:`s \, (n E) \, d^{s - 1}`.

    With the power 3/2 multipliers are continuous. With the power 1 they jump, from those of A to
    those of :math:`A + E n^T`. The orbit goes on with the contact (``continuous``), or it turns
    back (``nonsmooth fold``) where :math:`n (I - A)^{-1} E > 1`. A is without impacts.

    With 1/2 what begins follows from the signs of :math:`n A^k E`, if the orbit is stable before.
    Where one is positive a deeper impact follows, and no attractor stays close (``jump``). Where
    none is, the largest multiplier m is real, and there is a small attractor. For m < 1/4 it is a
    sequence of stable orbits, one for each period from some on (``period adding``), for m < 2/3 the
    same with chaos between them, for larger m ``chaos``. These limits belong to the map close to
    the graze. A touch behind which contacts last, or a stop has a damper, is not decided, nor is
    one of an orbit that touches at two places at once, as symmetric ones do.

    Where a multiplier is 1 because cycles of all sizes exist at that value of the parameter, as in
    a linear mode whose rest neither grows nor decays, the largest one of these touches. Its graze
    is told for the power 3/2: with the right and left eigenvectors v and w of this multiplier and
    the derivative P of the map by the parameter, :math:`w v = 1`, orbits with contacts exist where
    the distance p of the parameter has the sign for which
    :math:`p \, w P + r^{3/2} \sum w E (n v)^{3/2} = 0`, the sum being over all places that are
    touched. ``amplitude_factor`` times the distance to the power ``amplitude_power`` of 2/3 is the
    largest depth then, and there are no vectors.

    A supercritical point gives stable orbits where ``unstable_directions`` is 0. At a torus within
    0.01 of a strong resonance (rotation number 0, 1/2, 1/3 or 1/4) the coefficient decides nothing.
    A result holds for the itinerary of the orbit. Where an event is close, ``reach`` is small, and
    it holds for small amplitudes only.

    References
    ----------
    Yu. A. Kuznetsov, Elements of Applied Bifurcation Theory, 3rd edition, Springer (2004),
    sections 4.5 to 4.7 and 5.4.

    A. B. Nordmark, Non-periodic motion caused by grazing incidence in an impact oscillator, Journal
    of Sound and Vibration 145 (1991).

    W. Chin, E. Ott, H. E. Nusse and C. Grebogi, Grazing bifurcations in impact oscillators,
    Physical Review E 50 (1994).

    M. H. Fredriksson and A. B. Nordmark, Bifurcations caused by grazing incidence in many degrees
    of freedom impact oscillators, Proceedings of the Royal Society A 453 (1997).

    M. di Bernardo, C. J. Budd, A. R. Champneys and P. Kowalczyk, Piecewise-smooth Dynamical
    Systems, Springer (2008).

    Examples
    --------
    The mole doubles its period, and a stable orbit of twice the period begins:

    >>> import nonsmooth as ns
    >>> branch = ns.continue_orbit(ns.models.moling(), "b", (0.1, 0.17))
    >>> found = ns.criticality(branch, "flip")
    >>> print(found["criticality"].values[0], found["side"].values[0])
    supercritical below
    """
    numbers = _chosen(branch, special)
    system = _system_of(branch)
    forms = [_form(branch, system, number) for number in numbers]
    return _dataset(branch, system, numbers, forms)


def _chosen(branch: Any, special: Any) -> list[int]:
    """Numbers of the special points that are meant."""
    if not hasattr(branch, "data_vars") or "special_test" not in branch:
        raise OptionError("branch: give a result of continue_orbit")
    if "special_kind" in branch.attrs:
        raise OptionError(
            "branch: this is a curve of continue_special, on which all points are special; give a"
            " branch of continue_orbit"
        )
    kinds = [str(kind) for kind in branch["special_kind"].values]
    if special is None:
        return [number for number, kind in enumerate(kinds) if kind in KINDS]
    if isinstance(special, str):
        if not is_known(special, KINDS):
            raise OptionError(unknown_name("special kind", special, KINDS))
        found = [number for number, kind in enumerate(kinds) if kind == special]
        if not found:
            raise OptionError(
                f"special = {special!r}: the branch has no such point; its kinds are"
                f" {', '.join(dict.fromkeys(kinds)) or 'none'}"
            )
        return found
    number = finite_number("special", special)
    if number != int(number) or not 0 <= number < len(kinds):
        raise OptionError(
            f"special = {quote(special)}: the branch has {len(kinds)} special points, numbered from"
            " 0; or give a kind, such as 'flip'"
        )
    if kinds[int(number)] not in KINDS:
        raise OptionError(
            f"special = {int(number)} is a {kinds[int(number)]} point; normal forms are known of"
            f" the kinds {', '.join(KINDS)}"
        )
    return [int(number)]


def _system_of(branch: xr.Dataset) -> System:
    """The system of a branch, as its attributes tell."""
    try:
        system = System.from_toml(branch.attrs["system"])
        name = branch.attrs["parameter"]
        return system.with_parameters(**{name: system.parameter_values[name]})
    except (KeyError, ModelError) as fault:
        raise OptionError(f"branch: its attributes do not give its system: {fault}") from None


def _form(branch: xr.Dataset, system: System, number: int) -> NormalForm:
    """The normal form of one special point."""
    name, kind = str(branch.attrs["parameter"]), str(branch["special_kind"].values[number])
    point = branch.isel(point=int(branch["special_point"].values[number]))
    there = system.with_parameters(**{name: float(point[name])})
    guess = guess_of_dataset(there, point)
    low, high = (float(text) for text in str(branch.attrs["between"]).split())
    try:
        legs = Legs(there, (name,))
        legs.set_values(there.parameter_values)
        equations = OrbitEquations(
            legs, guess.word, period=int(branch.attrs["period"]),
            phase=float(branch.attrs["phase_of_period"]),
            autonomous=not is_driven(build_tables(there)), origin=guess.turn.states[0],
            reference=guess.turn.states[0].copy(),
        )  # fmt: skip
        unknowns = equations.pack(guess.turn)
        equations.evaluate(unknowns)  # a cycle without events gets its plane here
        near, width = WordMap(equations, unknowns), high - low
        if kind == "grazing":
            test = str(branch["special_test"].values[number])
            return form_of_grazing(near, test, width, name)
        return form_of_smooth(near, kind, width, name)
    except (LegError, Narrow, np.linalg.LinAlgError) as fault:
        return NormalForm(detail=str(fault))


def _dataset(
    branch: xr.Dataset, system: System, numbers: Sequence[int], forms: Sequence[NormalForm]
) -> xr.Dataset:
    """Dataset of normal forms over ``special``."""
    import xarray as xr

    name = str(branch.attrs["parameter"])
    of_parameter = system.describe.get(name, name)

    def each(values: Any, kind: Any, text: str, **words: str) -> Any:
        return "special", np.array(list(values), kind), {"long_name": text, **words}

    chosen = branch.isel(special=list(numbers))
    variables = {key: chosen[key].variable for key in ("special_kind", "special_value")}
    variables |= {
        "criticality": each((f.criticality for f in forms), str, "what the normal form tells"),
        "criticality_detail": each((f.detail for f in forms), str, "in words"),
        "coefficient": each((f.coefficient for f in forms), float, "of the normal form"),
        "coefficient_error": each((f.error for f in forms), float, "how far it may be wrong"),
        "parameter_coefficient": each(
            (f.rate for f in forms), float, f"of the normal form, by {of_parameter}"
        ),
        "parameter_coefficient_error": each(
            (f.rate_error for f in forms), float, "how far it may be wrong"
        ),
        "side": each((f.side for f in forms), str, f"of {of_parameter}, where orbits begin"),
        "amplitude_factor": each(
            (f.amplitude for f in forms), float, "distance of these orbits, per power of that"
            f" of {of_parameter}",
        ),
        "amplitude_power": each((f.power for f in forms), float, "that power"),
        "reach": each(
            (f.reach for f in forms), float, "displacement for which the itinerary is the same"
        ),
        "unstable_directions": each(
            (f.outside for f in forms), int, "other multipliers outside the unit circle"
        ),
        "rotation_angle": each(
            (f.angle for f in forms), float, "angle of the multiplier", units="rad"
        ),
        "resonance": each((f.resonance for f in forms), str, "strong resonance close by"),
        "eigenvector": _vectors(system, [f.right for f in forms], "right eigenvector, of length 1"),
        "adjoint": _vectors(system, [f.left for f in forms], "left eigenvector, of product 1"),
    }  # fmt: skip
    coords = {
        "special": each(numbers, int, "number of the special point in the branch"),
        "state": ("state", np.array(system.states), {"long_name": "state"}),
    }
    attrs = {"parameter": name, "period": int(branch.attrs["period"])}
    return xr.Dataset(
        variables, coords, result_attributes(system, "completed", _message(forms), attrs)
    )


def _vectors(system: System, vectors: Sequence[npt.NDArray[np.complex128]], text: str) -> Any:
    """Vectors of the states that do not drift, as rows over all states."""
    moving = [i for i, state in enumerate(system.states) if state not in system.drift_states]
    rows = np.zeros((len(vectors), len(system.states)), complex)
    for row, vector in zip(rows, vectors, strict=True):
        row[moving] = vector if vector.size else np.nan
    return ("special", "state"), rows, {"long_name": text}


def _message(forms: Sequence[NormalForm]) -> str:
    """How many points were decided."""
    open_ones = sum(form.criticality == UNDECIDED for form in forms)
    if not forms:
        return "the branch has no special point whose normal form is known"
    return f"{open_ones} of {len(forms)} points are not decided" if open_ones else "completed"
