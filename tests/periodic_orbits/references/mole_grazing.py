"""Where a flight of a periodic mole touches the slider without an impact, in 40 digits."""

from collections.abc import Callable
from itertools import pairwise

from mpmath import mp, mpf

from reference.mole_modes import MODES, Mole, NoContact
from reference.mole_modes import State as Full

from .mole import mole_course, mole_of
from .turn import Orbit, close

PARTS = 200
TOUCHING = ("0.1516", "0.1512")  # values of b between which the secants begin


def least_gap(orbit: Orbit, b: mpf) -> mpf:
    """The lowest minimum of the gap inside the flights, their beginnings left out."""
    mole, least, time = mole_of({"b": b}), mp.inf, mpf(0)
    for leg, start, lasts in zip(
        orbit.course.legs, orbit.turn.states, orbit.turn.durations, strict=True
    ):
        if leg.mode == "no_contact":
            flow = MODES[leg.mode](mole, Full(*start), mole.omega * time + mole.phi)
            gap, rate = _gap_and_rate(mole, flow)
            least = min(least, _lowest(gap, rate, lasts))
        time += lasts
    return least


def _gap_and_rate(mole: Mole, flow: NoContact) -> tuple[Callable, Callable]:
    return (
        lambda s: mole.gap(flow.at(s)),
        lambda s: -mole.k * flow.at(s).q - flow.at(s).y,
    )


def _lowest(gap: Callable, rate: Callable, lasts: mpf) -> mpf:
    """Least value where the rate rises through zero; a release begins with gap and rate zero."""
    times = [lasts * k / PARTS for k in range(1, PARTS + 1)]
    least, before = mp.inf, rate(times[0])
    for t0, t1 in pairwise(times):
        after = rate(t1)
        if before < 0 <= after:
            least = min(least, gap(mp.findroot(rate, (t0, t1), solver="anderson", tol=1e-45)))
        before = after
    return least


def touching_b(word: str, free, durations, near=TOUCHING) -> tuple[mpf, Orbit]:
    """The static force at which the orbit of this word, guessed near the first value, touches."""
    b0, b1 = map(mpf, near)
    orbit = close(mole_course(word, b=b0), free, durations)
    f0 = least_gap(orbit, b0)
    for _ in range(40):
        orbit = close(mole_course(word, b=b1), orbit.free, orbit.turn.durations)
        f1 = least_gap(orbit, b1)
        b0, b1, f0 = b1, b1 - f1 * (b1 - b0) / (f1 - f0), f1
        if abs(b1 - b0) < mpf(10) ** -30:
            return b1, orbit
    raise ArithmeticError("the secants do not converge")
