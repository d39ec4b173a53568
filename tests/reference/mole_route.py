"""From mode to mode: the transition logic of the ground mole, written out by hand."""

from typing import NamedTuple

from mpmath import mp, mpf

from .mole_modes import MODES, Mole, State
from .roots import TINY, Undecidable

# How far p - q - g may be from zero in a start given in doubles and still mean contact.
START_TOLERANCE = mpf(10) ** -14


class Here(NamedTuple):
    """State, mode, and how many leading derivatives of a guard (by target) vanish exactly."""

    mode: str
    state: State
    known_zeros: dict[str, int]


class Transition(NamedTuple):
    time: mpf
    mode_from: str
    mode_to: str
    state: State
    rate: mpf  # of the guard that fired, in the mode that is left


def begin(mole: Mole, state: State, theta: mpf) -> Here:
    """The mode in which a start continues. Starting is no event."""
    gap = mole.gap(state)
    if gap < -START_TOLERANCE:
        raise ValueError(f"inadmissible start: p - q - g = {mp.nstr(-gap, 8)} is positive")
    if gap > START_TOLERANCE:
        return Here("no_contact", state, {})
    return touch(mole, state._replace(p=state.q + mole.g), theta)


def touch(mole: Mole, state: State, theta: mpf) -> Here:
    """The mode on the contact surface, decided by F, and by its rates where F is 0 or 1."""
    force, rate = mole.force(state), mole.force_rate(state, theta)
    if abs(force) < TINY:
        return _touch_without_force(mole, state, theta)
    if abs(force - 1) < TINY:
        if abs(rate) < TINY:
            raise Undecidable("F = 1 with F' = 0")
        if rate > 0:
            return Here("progression", state, {"contact": 1})
        return Here("contact", state, {"progression": 1})
    if force < 0:
        return Here("no_contact", state, {"contact": 1})
    return Here("progression" if force > 1 else "contact", state, {})


def _touch_without_force(mole: Mole, state: State, theta: mpf) -> Here:
    rate = mole.force_rate(state, theta)
    order = 1
    if abs(rate) < TINY:
        # F = F' = 0 leaves F'' = 2 xi f' + f. In flight, h' is proportional to F throughout.
        rate = 2 * mole.xi * mole.load_rate(theta) + mole.load(theta)
        order = 2
    if abs(rate) < TINY:
        raise Undecidable("F = F' = F'' = 0")
    if rate > 0:
        return Here("contact", state, {"no_contact": order})
    return Here("no_contact", state, {"contact": order + 1})


def enter(mole: Mole, mode: str, to: str, state: State, theta: mpf) -> Here:
    """Where a crossing of the guard from ``mode`` towards ``to`` leads, in one instant."""
    if mode == "no_contact":
        state = state._replace(p=state.q + mole.g)
        if mole.force(state) < TINY:
            raise Undecidable("an impact without approach")
        return touch(mole, state, theta)
    if abs(mole.force_rate(state, theta)) < TINY:
        raise Undecidable(f"{mode} -> {to} with a force that is at rest")
    if to == "no_contact":
        # F = 0: h = h' = 0 and h'' = F'/(2 xi) < 0, so the gap opens from a double zero.
        return Here(to, state, {"contact": 2})
    # Only F crossed 1; the guard of the new mode is that same zero, left in its own direction.
    return Here(to, state, {mode: 1})


def advance(
    mole: Mole, here: Here, phase: mpf, duration: mpf
) -> tuple[Here, list[Transition], mpf]:
    """Run from forcing phase ``phase`` for ``duration``: where it ends, transitions, nearest miss.

    The times of the transitions count from the start of this stretch.
    """
    time, transitions, nearest = mpf(0), [], mp.inf
    while True:
        theta0 = phase + mole.omega * time
        flow = MODES[here.mode](mole, here.state, theta0)
        end, to = duration - time, None
        for guard in flow.guards():
            found, miss = guard.first_crossing(end, here.known_zeros.get(guard.to, 0))
            nearest = min(nearest, miss)
            if found is not None:
                end, to = found, guard.to
        state = flow.at(end)
        if to is None:
            return Here(here.mode, state, {}), transitions, nearest
        time += end
        theta = theta0 + mole.omega * end
        rate = flow.rate(to, state, theta)
        mode_before, here = here.mode, enter(mole, here.mode, to, state, theta)
        transitions.append(Transition(time, mode_before, here.mode, here.state, rate))
