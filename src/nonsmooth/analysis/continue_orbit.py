"""`continue_orbit`: a branch of periodic orbits over a parameter, through grazing."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nonsmooth.analysis.options import SharedOptions
from nonsmooth.analysis.orbit_search.branches import (
    branch_dataset,
    check_way,
    read_bounds,
    read_steps,
)
from nonsmooth.analysis.orbit_search.options import period_of, read_wanted, said_of_options
from nonsmooth.errors import NonsmoothError, OptionError, is_known, quote, unknown_name
from nonsmooth.periodic_orbits.branch_crossing import (
    BranchCrossing,
    arm,
    crossing_at,
    crossing_at_flip,
)
from nonsmooth.periodic_orbits.branch_part import BranchPart, Followed
from nonsmooth.periodic_orbits.branch_run import follow_orbits
from nonsmooth.periodic_orbits.branch_start import doubled_start, tangent_at
from nonsmooth.periodic_orbits.legs import Legs
from nonsmooth.periodic_orbits.orbit import OrbitRequest
from nonsmooth.periodic_orbits.restart import guess_of_dataset, is_orbit
from nonsmooth.periodic_orbits.search import equations_for, other_ways, search_orbit, solve_guess
from nonsmooth.periodic_orbits.stretch import BranchOptions, BranchStart
from nonsmooth.progress import HeldInterrupts, Progress
from nonsmooth.runs.options import check_flag, finite_number, whole_number
from nonsmooth.runs.part_names import OF_BRANCHES, check_part_names
from nonsmooth.runs.runner import build_tables
from nonsmooth.runs.start import carried_parameters
from nonsmooth.runs.strobe_times import is_driven
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["continue_orbit"]

_NO_OTHER = {  # why no other branch begins at a crossing, by the status of the search
    "no_branch_point": "its equations are not those of two branches that cross. Where several"
    " multipliers are 1 or -1 at once, as of three equal machines in step, more branches begin"
    " there; begin with an orbit of one of them: find_orbit from a start beside this orbit on which"
    " the machines differ, or on a branch of a model in which those that stay in step are one",
    "imperfect": "branches pass each other there without meeting, as where a symmetry is not exact;"
    " begin with an orbit of the other one, from find_orbit",
    "isolated": "the point is isolated, as where a closed branch appears; begin with an orbit"
    " beyond it, from find_orbit",
    "tangent": "branches touch there instead of crossing; begin with an orbit of the other one,"
    " from find_orbit",
}
_CROSSINGS = ("branch_point", "symmetry_breaking", "halving")
_SAME, _BESIDE = 1e-7, 1e-3  # in the parameter and in arclength


def continue_orbit(
    system: System | StroboscopicMap,
    parameter: str,
    between: tuple[float, float],
    *,
    initial: Any = None,
    period: int = 1,
    word: Any = None,
    special: int | None = None,
    direction: str = "both",
    steps: int = 500,
    step: float = 0.01,
    largest_step: float = 0.05,
    smallest_step: float = 1e-9,
    inadmissible: bool = False,
    transient: int | None = None,
    parameters: Mapping[str, float] | None = None,
    phase: float = 0.0,
    mode: str | None = None,
    tolerance: float = 1e-12,
) -> xr.Dataset:
    """Follow a periodic orbit over a parameter, stable or not, and through changes of its word.

    Parameters
    ----------
    system : System or StroboscopicMap
        The system; its value of the parameter, which lies within the bounds, is where the branch
        begins, unless ``initial`` is an orbit found with other ``parameters``.
    parameter : str
        Name of the parameter.
    between : (float, float)
        Lowest and highest value.
    initial : mapping, dataset or run, optional
        As in `find_orbit`: where the first orbit is guessed from. The branch of an orbit that was
        found with other ``parameters`` has these, and begins where they are; ``parameters={}``
        takes those of the system. With ``special``, a branch.
    period : int, optional
        Periods of the forcing in one turn, as in `find_orbit`; that of an orbit or a branch given
        as ``initial``, where it has one.
    word : str or sequence of str, optional
        Modes of the first orbit, as in `find_orbit`.
    special : int, optional
        Number of a special point of the branch ``initial``, at which another branch begins: the
        doubled orbit at a flip, the unsymmetric one at a branch point.

    Other Parameters
    ----------------
    direction : {"both", "up", "down"}, optional
        Whether the parameter grows or falls at first.
    steps : int, optional
        Steps to take at most, either way.
    step : float, optional
        First step in arclength. The width of ``between`` counts as one in it, as do the sizes of
        the states together. Where nothing drives the system, so does the place of a cycle; its
        shape counts as one by how much the states vary along it.
    largest_step : float, optional
        Largest step in arclength.
    smallest_step : float, optional
        Smallest step in arclength, at which the branch ends.
    inadmissible : bool, optional
        Go on with the same word where no motion follows its orbit; without it the word is changed
        there. ``admissible`` tells these points apart.
    transient, phase : optional
        As in `find_orbit`.
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.
    mode : str, optional
        Mode to start in, where several would fit; a cell, or a mode for any of its cells.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.

    Returns
    -------
    xarray.Dataset
        Over ``point``, in order along the branch, the variables of `find_orbit`, the parameter
        under its own name and ``arclength``, which is 0 where the branch began. Over ``special``:
        ``special_kind``, ``special_value`` (of the parameter), ``special_point`` (its number among
        the points), ``special_multiplier`` and ``special_detail``. At a graze of a rigid wall
        ``special_multiplier`` is infinite where a multiplier has no bound. Attributes
        ``end_first`` and ``end_last`` say why the branch ended where the points begin and end. An
        orbit at which an event is just at a strobe is two points: with the states before the event
        at that strobe, and behind it.

    Raises
    ------
    OptionError
        When there is no orbit to begin with, and for options out of their range.

    See Also
    --------
    find_orbit : one orbit.
    bifurcation_diagram : what motions settle to.
    continuation.follow : branches of any equations.

    Notes
    -----
    Pseudo-arclength continuation of the equations in `find_orbit`. Kinds of special points:

    ``fold``, ``flip``, ``torus``
        A multiplier 1, where the parameter turns back; -1, where the period doubles; a pair on the
        unit circle.
    ``symmetry_breaking``, ``branch_point``
        A multiplier 1 where branches cross: on an orbit that is its own mirror image, along a
        direction that the symmetry reverses (one of ``half_multipliers`` is -1 there, and 1 at a
        fold); on any other. A system without a declared symmetry is asked whether all states have
        the other sign half a turn later.
    ``grazing``
        A guard touches zero within a leg. The orbit beyond has one excursion more or less; where
        the impact has a reset, one impact more or less. The detail tells whether the branch goes
        on in the parameter or turns back (a nonsmooth fold).
    ``corner``
        Two guards are zero at one instant.
    ``border_collision``
        A state that only resets change comes to the border of two formulas, as in a map that is
        defined piece by piece. The branch goes on with the other formula or turns back.
    ``gained``, ``lost``
        A leg appears between two exits that were passed at one instant, or vanishes.
    ``crossing_sliding``
        Where an orbit crosses a surface, the field behind it is tangent to it: beyond, motion
        slides for a while before it leaves.
    ``grazing_sliding``
        An orbit touches a surface on which motion slides: beyond, it slides for a while.
    ``switching_sliding``
        An orbit comes onto a surface just where the part on which motion slides begins: beyond,
        it crosses first and comes back onto it.
    ``adding_sliding``
        While an orbit slides, what holds it there comes to its bound and turns back: beyond, it
        leaves the surface for a while.
    ``sliding``
        A surface begins to hold the motion, or does not any more, in another way than these.
    ``hopf``
        Where the branch ends: a cycle without events shrinks to a point. That is the rest whose
        perturbations neither grow nor decay, and stands as the last orbit.
    ``boundary_equilibrium``
        An equilibrium of a system whose forcing has no amplitude meets a surface: the branch goes
        on with that of the mode beyond, or turns back there. Or the branch ends: a cycle with
        events shrinks to a point, where a rest of one of its modes meets the surface at which that
        mode ends. It stands as the last orbit, with the multipliers of the last cycle.
    ``pseudo_hopf``
        Where the branch ends: a cycle with events shrinks to a point together with its period, as
        under a relay, where the fields on both sides of a surface are opposite. It stands as the
        last orbit, with the multipliers and the duration of the last cycle; the parameter is found
        by polynomials through the last cycles.
    ``word_change``
        The engine finds another motion, although none of these happens.
    ``bound``, ``closed``
        The parameter reaches an end of ``between``; the branch comes back to its beginning.

    Each is located to rounding by the sign of a smooth function: products of multipliers, lowest
    values of guards within legs, durations, values of guards at events. A branch that ends says
    why: ``bound``, ``closed``, ``steps``, ``smallest_step``, ``singular``, ``domain``,
    ``fault`` (an error within the library, with all points until then), or the kind of a special
    point behind which no orbit is found that is a motion. Every orbit is checked by
    the engine, as in `find_orbit`, and every step by whether its orbits are motions and its special
    points explain what multipliers and the parameter do; a step that fails is halved.

    A slow impact on a rigid wall, of speed v, kicks perturbations by k (h y)/v, h being the
    derivative of the gap by the state and k the jump of the flow (its saltation matrix). If M is
    what happens until the next impact, a multiplier grows like h M k/v. At a graze it has a limit
    where h M k is zero: where k is along the flow, as for cycles in the plane that nothing drives,
    and where sticking leaves only the flow.

    A cycle without events begins on a plane across its flow. Where the flow passes the plane at a
    flat angle, it is laid anew through the first state and the middle of the cycle.

    Of rebounds that end in rest there are infinitely many, of which the engine follows some. Their
    number changes along a branch although nothing happens, so it is no special point. Where the
    section lies between them, a step of the branch may lead over the rest of them at once. What
    sticks for ever may do so at many places; the branch then keeps the one that it came to.

    References
    ----------
    H. B. Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems, in:
    Applications of Bifurcation Theory, Academic Press (1977).

    M. di Bernardo, C. J. Budd, A. R. Champneys and P. Kowalczyk, Piecewise-smooth Dynamical
    Systems, Springer (2008): kinds of sliding.

    Examples
    --------
    The mole doubles its period where the static force falls; where it grows, its orbit of period
    one meets a fold and comes back unstable:

    >>> import nonsmooth as ns
    >>> mole = ns.models.moling(a=0.3, b=0.15, xi=0.05, omega=0.1)
    >>> branch = ns.continue_orbit(mole, "b", (0.1, 0.2))
    >>> for kind, b in zip(branch["special_kind"].values, branch["special_value"].values):
    ...     print(kind, round(float(b), 9))
    bound 0.1
    flip 0.110011731
    fold 0.167150499
    grazing 0.150977503
    flip 0.15097798
    flip 0.184207204
    fold 0.190280174
    grazing 0.176817414
    flip 0.176818058
    bound 0.2

    At each grazing the branch turns back with one impact more.
    """
    shared = SharedOptions(parameters, tolerance, mode)
    options, wanted, names, beginning = read_branch_options(
        system, parameter, between, shared, initial=initial, period=period, word=word,
        special=special, direction=direction, steps=steps, step=step, largest_step=largest_step,
        smallest_step=smallest_step, inadmissible=inadmissible, transient=transient, phase=phase,
    )  # fmt: skip
    options, parts, said = both_ways(options, wanted, beginning, direction)
    attrs = {"period": options.period, "between": f"{options.bounds[0]:g} {options.bounds[1]:g}"}
    attrs |= said | said_of_options(wanted, shared, names)
    return branch_dataset(options, parts, attrs)


class Beginning(NamedTuple):
    """Where a branch begins: with an orbit, or at a special point of another branch."""

    kind: str = "orbit"  # or "flip", "crossing"
    neighbour: Any = None  # of a crossing: the next point of the known branch with the same word


def read_branch_options(
    system: Any,
    parameter: Any,
    between: Any,
    shared: SharedOptions,
    *,
    initial: Any,
    period: Any,
    word: Any,
    special: Any,
    direction: Any,
    steps: Any,
    step: Any,
    largest_step: Any,
    smallest_step: Any,
    inadmissible: Any,
    transient: Any,
    phase: Any,
) -> tuple[BranchOptions, OrbitRequest, tuple[str, ...], Beginning]:
    """Options of a branch, its first orbit, the word given, and where it begins."""
    base = getattr(system, "system", system)
    if isinstance(base, System) and not is_known(parameter, base.parameters):
        raise OptionError(unknown_name("parameter", parameter, base.parameters))
    beginning = Beginning()
    if special is not None:
        initial, beginning = _at_special(initial, special, parameter)
    if shared.parameters is None and is_orbit(initial) and isinstance(base, System):
        shared = replace(shared, parameters=carried_parameters(base, initial) or None)
    if is_orbit(initial) and parameter in initial and initial[parameter].ndim == 0:
        shared = _at_value(shared, parameter, float(initial[parameter]))
    if is_orbit(initial) and whole_number("period", period) == 1:
        period = period_of(initial) * (2 if beginning.kind == "flip" else 1)
    wanted, names = read_wanted(
        system, initial, shared, period=period, word=word, transient=transient, phase=phase,
        verb="continue_orbit",
    )  # fmt: skip
    check_part_names(wanted.system, OF_BRANCHES, parameters=(parameter,))
    low, high = read_bounds(between)
    value = float(wanted.system.parameter_values[parameter])
    if not low <= value <= high:
        raise OptionError(
            f"between = ({low:g}, {high:g}): the branch begins at {parameter} = {value:g}, which"
            " lies outside; give the system, or parameters=, a value within"
        )
    check_way(direction)
    smallest, first, largest = read_steps(smallest_step, step, largest_step)
    options = BranchOptions(
        wanted.system, parameter, (low, high), wanted.period, wanted.phase,
        not is_driven(build_tables(wanted.system)), whole_number("steps", steps), first, largest,
        smallest, wanted.tolerance, check_flag("inadmissible", inadmissible),
    )  # fmt: skip
    return options, wanted, names, beginning


def _at_value(shared: SharedOptions, parameter: str, value: float) -> SharedOptions:
    """The options with one parameter at a value."""
    return replace(shared, parameters={**(shared.parameters or {}), parameter: value})


def _at_special(branch: Any, special: Any, parameter: str) -> tuple[Any, Beginning]:
    """The orbit at a special point of a branch, and what begins there."""
    if not hasattr(branch, "data_vars") or "special_point" not in branch:
        raise OptionError("special= needs initial=, a branch that continue_orbit has given")
    count = branch.sizes["special"]
    number = finite_number("special", special)
    if number != int(number) or not 0 <= number < count:
        raise OptionError(
            f"special = {quote(special)}: the branch has {count} special points, numbered from 0"
        )
    if branch.attrs.get("parameter") != parameter:
        raise OptionError(
            f"special: the branch is one over {branch.attrs.get('parameter')!r}; follow it over"
            " the same parameter"
        )
    kind = str(branch["special_kind"].values[int(number)])
    if kind not in ("flip", "branch_point", "symmetry_breaking"):
        raise OptionError(
            f"special = {int(number)}: no other branch begins at a {kind} point; take one of the"
            " kinds flip, branch_point and symmetry_breaking"
        )
    place = int(branch["special_point"].values[int(number)])
    point = branch.isel(point=place)
    if kind == "flip":
        return point, Beginning("flip")
    return point, Beginning("crossing", _neighbour(branch, place))


def _neighbour(branch: Any, place: int) -> Any:
    """The next point of a branch, or the one before, with the same word; None where neither has."""
    here = branch.isel(point=place)
    for other in (place + 1, place - 1):
        if 0 <= other < branch.sizes["point"]:
            there = branch.isel(point=other)
            if all(np.array_equal(here[name], there[name]) for name in ("leg_mode", "leg_path")):
                return there
    return None


def both_ways(
    options: BranchOptions, wanted: OrbitRequest, beginning: Beginning, direction: str
) -> tuple[BranchOptions, list[BranchPart], dict[str, Any]]:
    """Points of a branch in order, and attributes that say how it ended.

    The options come back with the period of the orbit that is followed.
    """
    legs = Legs(options.system, (options.parameter,))
    legs.set_values(options.system.parameter_values)
    options, wanted = _primitive(options, wanted, legs, beginning)
    value = float(options.system.parameter_values[options.parameter])
    start = _beginning(options, wanted, legs, value, beginning)
    if beginning.kind == "flip":  # both ways lead to the same orbits, a strobe apart
        direction = "up"
    ways = {"both": (1.0, -1.0), "up": (1.0,), "down": (-1.0,)}[direction]
    found: dict[float, tuple[list[BranchPart], Followed]] = {}
    interrupted = False
    with HeldInterrupts() as held, Progress("following", len(ways) * options.steps) as progress:
        for number, way in enumerate(ways):

            def report(done: int, number: int = number) -> None:
                progress.update(number * options.steps + done)
                held.check()

            legs.set_values(options.system.parameter_values)
            begin = start(way)
            parts: list[BranchPart] = []
            found[way] = parts, Followed(ended="interrupted", message="interrupted by the user")
            try:
                for each in follow_orbits(options, legs, begin, report):
                    if isinstance(each, Followed):
                        found[way] = parts, each
                    elif beginning.kind == "orbit" or not _is_turn_at_start(each):
                        parts.append(each)
            except KeyboardInterrupt:
                interrupted = True
                break
            if found[way][1].ended == "closed":
                _end_at_start(parts)
                break
    parts, said = _joined(found, interrupted)
    if interrupted and not parts:
        raise KeyboardInterrupt  # there is not even the first point to keep
    return options, parts, said


def _end_at_start(parts: list[BranchPart]) -> None:
    """Leave out what a closed branch passes for a second time.

    It is known to be closed where it begins a stretch of one word as it did before; the first
    stretch, in the middle of which it may have begun, is passed again until there.
    """
    start = parts[0]
    after = next((k for k, part in enumerate(parts) if part.word != start.word), None)
    if after is None or parts[-1].special == "closed":
        return
    alike = [k for k, part in enumerate(parts) if part.word == start.word]
    places = np.array([[*parts[k].looked.turn.states[0], parts[k].value] for k in alike])
    size = np.ptp(places, axis=0)
    places = (places - places[0]) / np.where(size > 0.0, size, 1.0)
    again = [i for i, k in enumerate(alike) if k > after]
    if not again or len(alike) < 2:
        return
    nearest = min(again, key=lambda i: float(np.abs(places[i]).max()))
    beyond = float(places[nearest] @ places[1]) > 0.0  # the way that the branch has begun
    del parts[alike[nearest] + (not beyond) :]
    parts.append(replace(start, special="closed", arclength=parts[-1].arclength))


def _primitive(
    options: BranchOptions, wanted: OrbitRequest, legs: Legs, beginning: Beginning
) -> tuple[BranchOptions, OrbitRequest]:
    """The period of the shorter orbit, where the first turn passes it several times."""
    if beginning.kind != "orbit" or options.period == 1:
        return options, wanted
    found = search_orbit(wanted, legs)
    legs.set_values(options.system.parameter_values)
    if found.orbit is None or found.orbit.primitive == 1:
        return options, wanted
    period = options.period // found.orbit.primitive
    states = found.orbit.turn.states[0].tolist()
    start = dict(zip(options.system.states, states, strict=True))
    wanted = replace(wanted, period=period, initial=start, words=(), transient=0)
    return replace(options, period=period), wanted


def _joined(
    found: dict[float, tuple[list[BranchPart], Followed]], interrupted: bool
) -> tuple[list[BranchPart], dict[str, Any]]:
    """The way down backwards, then the way up."""
    down, first = found.get(-1.0, ([], None))
    up, last = found.get(1.0, ([], None))
    for part in down:
        part.arclength = -part.arclength
    parts = [*reversed(down), *(up[1:] if down else up)]
    _drop_folds_at_crossings(parts)
    ends = {"end_first": first, "end_last": last}
    said: dict[str, Any] = {"status": "interrupted" if interrupted else "completed"}
    messages = []
    for name, end in ends.items():
        said[name] = end.ended if end is not None else "start"
        if end is not None and end.message:
            messages.append(f"{'first' if name == 'end_first' else 'last'} end: {end.message}")
    said["message"] = "; ".join(messages)
    return parts, said


def _is_turn_at_start(part: BranchPart) -> bool:
    """Whether a fold is that of a branch which turns where it leaves another one.

    Where both cross the equations are singular, and rounding decides on which side it is found.
    """
    return part.special == "fold" and 0.0 < part.arclength <= _BESIDE


def _drop_folds_at_crossings(parts: list[BranchPart]) -> None:
    """Where a branch crosses another one at its turn, the turn is no special point of its own."""
    crossings = [part for part in parts if part.special in _CROSSINGS]
    for part in parts:
        if part.special == "fold" and any(
            abs(part.value - other.value) <= _SAME * (1.0 + abs(other.value))
            and abs(part.arclength - other.arclength) <= _BESIDE
            for other in crossings
        ):
            part.special = part.test = ""


def _beginning(
    options: BranchOptions, wanted: OrbitRequest, legs: Legs, value: float, beginning: Beginning
) -> Callable[[float], BranchStart]:
    """Where the branch begins, towards larger values of the parameter (1) or smaller ones (-1)."""
    if beginning.kind == "crossing":
        return _crossing(options, wanted, legs, value, beginning.neighbour)
    if beginning.kind == "flip":
        guess = guess_of_dataset(options.system, wanted.initial)
        start = doubled_start(options, legs, guess, value)
        once = equations_for(replace(wanted, period=options.period // 2), legs, guess)
        crossing = crossing_at_flip(options, once, guess, start)
        if crossing is not None:
            return partial(_arm, options, crossing)
    else:
        found = search_orbit(wanted, legs)
        if found.orbit is None or found.equations is None:
            raise OptionError(f"there is no orbit to begin with: {found.message}")
        if found.status == "inadmissible" and not options.inadmissible:
            raise OptionError(
                f"the orbit to begin with is no motion: {found.orbit.admissibility.reason};"
                f" {other_ways(wanted)}; inadmissible=True follows the equations of its word all"
                " the same"
            )
        unknowns = found.equations.pack(found.orbit.turn)
        legs.set_values(options.system.parameter_values)
        start = BranchStart(found.equations, unknowns, value, tangent_at(found.equations, unknowns))
    du, dp = start.direction
    up = 1.0 if dp >= 0.0 else -1.0
    return lambda way: replace(start, direction=(up * way * du, up * way * dp))


def _crossing(
    options: BranchOptions, wanted: OrbitRequest, legs: Legs, value: float, neighbour: Any
) -> Callable[[float], BranchStart]:
    """The same of the other branch at a point where two of them cross."""
    guess = guess_of_dataset(options.system, wanted.initial)
    found = solve_guess(wanted, legs, guess)
    assert found.equations is not None
    beside = None
    if neighbour is not None:
        there = guess_of_dataset(options.system, neighbour)
        beside = there, float(neighbour[options.parameter])
    crossing = crossing_at(options, found.equations, guess, value, beside)
    return partial(_arm, options, crossing)


def _arm(options: BranchOptions, crossing: BranchCrossing, way: float) -> BranchStart:
    try:
        return arm(options, crossing, way)
    except NonsmoothError as fault:
        why = _NO_OTHER.get(getattr(fault, "status", ""), str(fault))
        raise OptionError(f"no other branch was found at this point: {why}") from None
