"""A branch followed in both directions from its first orbit, or from a point where it begins."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from nonsmooth.analysis.orbit_search.branch_options import Beginning
from nonsmooth.continuation.branch_directions import branch_directions
from nonsmooth.errors import NonsmoothError, OptionError
from nonsmooth.periodic_orbits.branch_part import BranchPart, Followed
from nonsmooth.periodic_orbits.branch_run import follow_orbits
from nonsmooth.periodic_orbits.branch_start import doubled_start, tangent_at
from nonsmooth.periodic_orbits.legs import Legs
from nonsmooth.periodic_orbits.newton import scale_of
from nonsmooth.periodic_orbits.orbit import OrbitRequest
from nonsmooth.periodic_orbits.restart import guess_of_dataset
from nonsmooth.periodic_orbits.search import search_orbit, solve_guess
from nonsmooth.periodic_orbits.stretch import BranchOptions, BranchStart, BranchStretch
from nonsmooth.runs.progress import HeldInterrupts, Progress

__all__ = ["both_ways"]

_CROSSINGS = ("branch_point", "symmetry_breaking", "halving")
_SAME, _BESIDE = 1e-7, 1e-3  # in the parameter and in arclength


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
    start = _first(options, wanted, legs, value, beginning)
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

            du, dp = start.direction
            begin = BranchStart(start.equations, start.unknowns, value, (way * du, way * dp))
            legs.set_values(options.system.parameter_values)
            parts: list[BranchPart] = []
            found[way] = parts, Followed(ended="interrupted", message="interrupted by the user")
            try:
                for each in follow_orbits(options, legs, begin, report):
                    if isinstance(each, Followed):
                        found[way] = parts, each
                    else:
                        parts.append(each)
            except KeyboardInterrupt:
                interrupted = True
                break
            if found[way][1].ended == "closed":
                break
    parts, said = _joined(found, interrupted)
    return options, parts, said


def _primitive(
    options: BranchOptions, wanted: OrbitRequest, legs: Legs, beginning: Beginning
) -> tuple[BranchOptions, OrbitRequest]:
    """The period of the shorter orbit, where the first turn passes it several times."""
    if beginning.kind != "orbit" or options.autonomous or options.period == 1:
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


def _first(
    options: BranchOptions, wanted: OrbitRequest, legs: Legs, value: float, beginning: Beginning
) -> BranchStart:
    """Where the branch begins, heading for larger values of the parameter."""
    if beginning.kind == "flip":
        start = doubled_start(
            options, legs, guess_of_dataset(options.system, wanted.initial), value
        )
    elif beginning.kind == "crossing":
        start = _crossing(options, wanted, legs, value, beginning.neighbour)
    else:
        found = search_orbit(wanted, legs)
        if found.orbit is None or found.equations is None:
            raise OptionError(f"there is no orbit to begin with: {found.message}")
        if found.status == "inadmissible" and not options.inadmissible:
            raise OptionError(
                f"the orbit to begin with is no motion: {found.orbit.admissibility.reason};"
                " inadmissible=True follows the equations of its word all the same"
            )
        equations = found.equations
        unknowns = equations.pack(found.orbit.turn)
        legs.set_values(options.system.parameter_values)
        start = BranchStart(equations, unknowns, value, tangent_at(equations, unknowns))
    if start.direction[1] < 0.0:
        start.direction = (-start.direction[0], -start.direction[1])
    return start


def _crossing(
    options: BranchOptions, wanted: OrbitRequest, legs: Legs, value: float, neighbour: Any
) -> BranchStart:
    """The other branch at a point where two of them cross.

    At the point itself both branches are tangent to solutions of the same equations, so only
    another point of the known branch tells which of the two directions is its own.
    """
    found = solve_guess(wanted, legs, guess_of_dataset(options.system, wanted.initial))
    assert found.equations is not None
    equations = found.equations
    unknowns = equations.pack(guess_of_dataset(options.system, wanted.initial).turn)
    stretch = BranchStretch(options, legs, equations)
    if neighbour is None:
        known = tangent_at(equations, unknowns)
    else:
        there = equations.pack(guess_of_dataset(options.system, neighbour).turn)
        known = there - unknowns, float(neighbour[options.parameter]) - value
    low, high = options.bounds
    try:
        crossing = branch_directions(
            stretch.residual, unknowns, value, along=known, scale=scale_of(equations, unknowns),
            parameter_scale=high - low,
        )  # fmt: skip
    except NonsmoothError as fault:
        raise OptionError(f"no other branch was found at this point: {fault}") from None
    legs.set_values(options.system.parameter_values)
    du, dp = crossing.directions[1]
    return BranchStart(equations, np.asarray(crossing.u), float(crossing.p), (du, dp))
