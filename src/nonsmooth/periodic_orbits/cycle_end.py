"""Where a cycle shrinks to a point: when it is next to nothing, and the point.

A cycle of spread a around a state c is known to rounding of c, which is eps c/a of it, while the
parameter is a**2 away from its end: so where a**3 comes down to rounding of c, the parameter of a
cycle is noise. The branch leaves its cycles before that. The end itself is found from the rest in
the middle of them, as the parameter at which perturbations of the rest neither grow nor decay.

A cycle with events shrinks in proportion to the distance from its end, where a rest of one of its
modes meets the surface at which that mode ends: a boundary equilibrium (M. di Bernardo et al.,
Piecewise-smooth Dynamical Systems, 2008, section 5.1). The parameter there makes the guard of the
rest zero.

Another cycle with events shrinks together with its period, onto a point of the surface at which the
fields on its two sides are opposite: a pseudo-Hopf point. It turns round the point in ever shorter
flights, so few digits of its states tell its equations apart, and no step succeeds soon before the
end. The parameter and the middle are smooth functions of the period there, which lead to the end.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from nonsmooth.continuation.point import Point
from nonsmooth.periodic_orbits.cycle_plane import spread_of, states_of_cycle
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.legs import LegError
from nonsmooth.periodic_orbits.word import Word

__all__ = [
    "NEARLY",
    "NOTHING",
    "boundary_of_cycles",
    "end_of_cycles",
    "end_of_short_cycles",
    "is_nothing",
    "smaller_cycles",
]

Floats = npt.NDArray[np.float64]

NOTHING = 1e-5  # of the spread of the first orbit
NEARLY = 1e-2  # the same where steps fail, as where rounding moves a cycle by much of its size
_ROUNDINGS = 1e3 * float(np.finfo(float).eps)  # of a cycle, beside the states along it
_DIGITS = 1e-7  # of a cycle with events, to which it is known at least
_SMALLER = (0.5, 0.1, 1e-2, 1e-3)  # sizes of cycles that are looked at beside one
_ALIKE = 1e-9  # of the size of a cycle, by which it may fail to close
_PLACES = 32  # along a cycle with events, at which it is looked at
_PART = 0.25  # of a turn, over which perturbations of the rest are followed
_NEWTON = 20
_SETTLED = 1e-14  # step beside the rest, or the range of the parameter: no further ones
_ASIDE = 1e-6  # of the range of the parameter, to begin with
_FAR = 1e-3  # of the range of the parameter: farther away it is not the end of these cycles
# times the last period are those that lead to the end of cycles that become short: of shorter ones
# much is rounding
_SHORT = (4.0, 20.0)
_DEGREE = 4  # of the polynomials in the period
_ENOUGH = 10  # cycles for one of them
_VANISHES = 1e-2  # of the largest spread among them, and of the way to the end: as good as zero


def is_nothing(
    equations: OrbitEquations, unknowns: Floats, first: Floats, below: float = NOTHING
) -> bool:
    """Whether a cycle has shrunk to next to nothing beside the first orbit.

    ``first`` is the spread of each state of that, (n,).
    """
    if not equations.autonomous:
        return False
    smooth = equations.is_smooth_cycle
    states = (states_of_cycle if smooth else _states_with_events)(equations, unknowns)
    share = float((np.ptp(states, axis=0) / first).max())
    rounding = _ROUNDINGS * float((np.abs(states).max(axis=0) / first).max())
    return share <= below or (share**3 if smooth else _DIGITS * share) <= rounding


def smaller_cycles(equations: OrbitEquations, unknowns: Floats) -> list[Floats]:
    """A cycle without events scaled down about its middle, if all of these are cycles; else none.

    So it is in a linear mode, for the parameter at which the motion about the rest neither grows
    nor decays.
    """
    stays, n = ~equations.drifting, equations.legs.n
    states = states_of_cycle(equations, unknowns)
    middle, spread = states.mean(axis=0), spread_of(states)
    rounding, found = _ROUNDINGS * np.abs(states).max(axis=0) / spread, []
    for share in _SMALLER:
        scaled = unknowns.copy()
        scaled[:n][stays] = (middle + share * (unknowns[:n] - middle))[stays]
        gaps = np.abs(equations.evaluate(scaled)[0][:n]) / spread
        if np.any((gaps > share * _ALIKE + rounding)[stays]):
            return []
        found.append(scaled)
    return found


def end_of_cycles(
    equations: OrbitEquations, last: Point, set_parameter: Callable[[float], None],
    bounds: tuple[float, float],
) -> Point | None:  # fmt: skip
    """The rest to which cycles shrink, as an orbit, from the last one of them; None if not found.

    Newton's method gives the rest for each parameter, and the secant method the parameter at which
    the multipliers of the flow from it have the modulus one.
    """
    n, width = equations.legs.n, bounds[1] - bounds[0]
    stays = ~equations.drifting
    set_parameter(last.p)
    state = states_of_cycle(equations, last.u).mean(axis=0)
    state[~stays] = last.u[:n][~stays]
    span = _PART * float(last.u[n])
    angle = 2.0 * np.pi * _PART

    def growth(p: float) -> tuple[float, float, Floats]:
        """Growth and turn of perturbations over the span, and the rest."""
        set_parameter(p)
        rest, flow = _rest(equations, state, span)
        values = np.linalg.eigvals(flow[np.ix_(stays, stays)])
        logs = np.log(values[values != 0.0].astype(complex))
        one = logs[np.argmin(np.abs(logs - 1j * angle))]
        return float(one.real), float(one.imag), rest

    try:
        before, p = last.p, last.p + _ASIDE * width
        old = growth(before)[0]
        for _ in range(_NEWTON):
            new, turned, rest = growth(p)
            if new == old:
                break
            step = -new * (p - before) / (new - old)
            if not abs(p + step - last.p) <= _FAR * width:
                return None
            before, old, p = p, new, p + step
            if abs(step) <= _SETTLED * width:
                break
        else:
            return None
        turned, rest = growth(p)[1:]
        length = span * 2.0 * np.pi / turned
    except (LegError, np.linalg.LinAlgError, ValueError, ZeroDivisionError):
        return None
    if not abs(length - last.u[n]) <= _FAR * last.u[n]:
        return None
    return replace(last, u=np.append(rest, length), p=p)


def _states_with_events(equations: OrbitEquations, unknowns: Floats) -> Floats:
    """States along a cycle with events, drifts left out."""
    turn = equations.unpack(unknowns)
    times = turn.instants[0] + np.arange(_PLACES) / _PLACES * (turn.instants[-1] - turn.instants[0])
    return np.where(equations.drifting, 0.0, equations.states_along(turn, times))


def boundary_of_cycles(
    equations: OrbitEquations, last: Point, set_parameter: Callable[[float], None],
    bounds: tuple[float, float],
) -> tuple[float, Floats, int] | None:  # fmt: skip
    """Parameter and state of the boundary equilibrium to which cycles with events shrink.

    With the number of the leg in whose mode it rests, on the guard of the exit at the end of that.
    Newton's method gives the rest for each parameter, and the secant method the parameter; None
    where no mode of the cycle has one nearby.
    """
    width, turn = bounds[1] - bounds[0], equations.unpack(last.u)
    middle = _states_with_events(equations, last.u).mean(axis=0)
    middle[equations.drifting] = turn.states[0][equations.drifting]
    span = _PART * float(turn.instants[-1] - turn.instants[0])
    for leg, path in enumerate(equations.word.paths):
        mode = equations.word.modes[leg]

        def guard(p: float, mode: int = mode, path: tuple[int, ...] = path) -> tuple[float, Floats]:
            set_parameter(p)
            rest, _ = _rest(equations, middle, span, mode)
            return _guard_of(equations, rest, mode, path[0]), rest

        try:
            p, rest = _root(guard, last.p, _ASIDE * width, _SETTLED * width)
        except (LegError, np.linalg.LinAlgError, ZeroDivisionError):
            continue
        if abs(p - last.p) <= _FAR * width:
            return p, rest, leg
    return None


def end_of_short_cycles(
    cycles: Sequence[tuple[float, Turn]],
    drifting: npt.NDArray[np.bool_],
    bounds: tuple[float, float],
) -> tuple[float, Floats] | None:
    """Parameter and state of the point to which cycles with events shrink with their periods.

    ``cycles`` are the last ones, with their parameters. None where spread and period do not vanish
    together, or the polynomials through them do not agree on the parameter.
    """
    lengths = np.array([float(turn.instants[-1] - turn.instants[0]) for _, turn in cycles])
    shortest, longest = np.array(_SHORT) * lengths[-1]
    chosen = np.flatnonzero((lengths >= shortest) & (lengths <= longest)).tolist()
    periods, turns = lengths[chosen], [cycles[k][1] for k in chosen]
    alike = len({len(turn.states) for turn in turns}) == 1
    if len(turns) < _ENOUGH or not alike or np.any(np.diff(periods) >= 0.0):
        return None
    p = np.array([cycles[k][0] for k in chosen])
    states = np.array([np.where(drifting, turn.states[0], turn.states) for turn in turns])
    spread, share = np.ptp(states, axis=1), periods / periods[0]

    def at_zero(values: Floats, degree: int = _DEGREE) -> Floats:
        return np.asarray(np.polynomial.polynomial.polyfit(share, values, degree)[0])

    if np.any(np.abs(at_zero(spread)) > _VANISHES * spread.max(axis=0)):
        return None
    end, rough = float(at_zero(p)), float(at_zero(p, _DEGREE - 1))
    way, low, high = end - p[-1], *bounds
    ahead = way * (p[-1] - p[0]) > 0.0 and abs(way) <= _FAR * (high - low)
    if not ahead or abs(end - rough) > _VANISHES * abs(way):
        return None
    return end, np.where(drifting, states[-1, 0], at_zero(states.mean(axis=1)))


def _guard_of(equations: OrbitEquations, state: Floats, mode: int, exit_number: int) -> float:
    """Guard of an exit of a mode at a state."""
    at = np.zeros(1)
    found = equations.legs.follow_each(Word((mode,), ((),)), state[None], at, at)
    return float(found.others[0, exit_number])


def _root(
    function: Callable[[float], tuple[float, Floats]], p: float, aside: float, settled: float
) -> tuple[float, Floats]:
    """Where a function is zero, by the secant method, and what it gives there beside its value."""
    before, (old, _) = p, function(p)
    p += aside
    for _ in range(_NEWTON):
        new, _ = function(p)
        step = -new * (p - before) / (new - old) if new != 0.0 else 0.0
        before, old, p = p, new, p + step
        if abs(step) <= settled:
            return p, function(p)[1]
    raise LegError("no rest lies on the surface")


def _rest(
    equations: OrbitEquations, state: Floats, span: float, mode: int | None = None
) -> tuple[Floats, Floats]:
    """The state that rests in a mode, and derivatives of the state a span later by it, (n, n).

    Without a mode in that of the first leg.
    """
    legs, n, stays = equations.legs, equations.legs.n, ~equations.drifting
    word = Word(equations.word.modes[:1] if mode is None else (mode,), ((),))
    size = float(np.abs(state[stays]).max(initial=0.0))
    for _ in range(_NEWTON):
        found = legs.follow_each(word, state[None], np.zeros(1), np.array([span]))
        flow = found.flow[0, :n].T.copy()
        gap = (found.ends[0] - state)[stays]
        move = np.linalg.solve(flow[np.ix_(stays, stays)] - np.eye(len(gap)), -gap)
        if not np.abs(move).max() > _SETTLED * size:
            return state, flow
        state = state.copy()
        state[stays] += move
    raise LegError("no state rests there")
