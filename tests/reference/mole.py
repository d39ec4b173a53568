"""The ground mole to 50 digits: its events, its strobed states, and how errors grow along it.

Every parameter and initial value is the exact value of the double given; text is read to 50
digits. The one exception is the forcing period, 2 pi / omega with pi to 50 digits: phi is
whatever number was given, so ``math.pi / 2`` stands for that double and not for pi/2.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from mpmath import mp, mpf

from .mole_modes import Mole, State
from .mole_route import Here, Transition, advance, begin
from .roots import Undecidable

DIGITS = 50
DEFAULTS = {"g": 0.02, "phi": math.pi / 2}
# The forward difference: its curvature error is of this size, its rounding DIGITS below it.
PERTURBATION = mpf(10) ** -20


class Strobe(NamedTuple):
    p: mpf
    y: mpf
    q: mpf
    v: mpf
    mode: str


@dataclass(frozen=True)
class MoleRun:
    """One run. Times count from its start.

    ``events`` holds (t, mode left, mode entered): an instant that passes through contact at zero
    duration is one event. ``event_states`` and ``guard_rates`` go with it: the state there, and
    the rate (negative) of the guard that fired, in the mode left. ``nearest_miss`` is the least
    |guard| at an extremum (see roots.first_crossing): below about 1e-13, doubles cannot follow.
    """

    events: list[tuple[mpf, str, str]]
    event_states: list[State]
    guard_rates: list[mpf]
    strobes: list[Strobe]
    final: Strobe
    nearest_miss: mpf


class TangentGrowth(NamedTuple):
    """Largest singular values of the tangent map: of the run, and of its worst part.

    ``worst`` takes any period end (or the start) as the beginning and any later one as the end:
    an error made half-way may grow although those made at the start have died out.
    """

    total: float
    worst: float


@mp.workdps(DIGITS)
def mole_events(
    parameters: Mapping[str, Any],
    initial: Mapping[str, Any],
    n_periods: int,
    *,
    start_phase: Any = 0,
) -> MoleRun:
    """The run over ``n_periods`` forcing periods from ``initial`` (p, y, q, v; default 0).

    ``start_phase`` is omega t at the start, in radians; phi comes on top of it.
    """
    mole, here, phase = _setup(parameters, initial, start_phase)
    transitions: list[Transition] = []
    strobes, nearest = [], mp.inf
    for n in range(n_periods):
        # The phase is the same in every period, so nothing grows with the number of them.
        here, found, miss = advance(mole, here, phase, mole.period)
        transitions += [each._replace(time=n * mole.period + each.time) for each in found]
        strobes.append(Strobe(*here.state, here.mode))
        nearest = min(nearest, miss)
    return MoleRun(
        events=[(each.time, each.mode_from, each.mode_to) for each in transitions],
        event_states=[each.state for each in transitions],
        guard_rates=[each.rate for each in transitions],
        strobes=strobes,
        final=Strobe(*here.state, here.mode),
        nearest_miss=nearest,
    )


@mp.workdps(DIGITS)
def mole_tangent_growth(
    parameters: Mapping[str, Any],
    initial: Mapping[str, Any],
    n_periods: int,
    *,
    start_phase: Any = 0,
) -> TangentGrowth:
    """How much errors in (p, y, q, v) grow along a run, to scale a tolerance with.

    Differences of the same route, period by period. In contact p is slaved to q, so only errors
    on that surface are counted there. Nothing depends on v, but v depends on everything.
    """
    mole, here, phase = _setup(parameters, initial, start_phase)
    products: list[mp.matrix] = []  # from the start of each period to the present one
    worst = mpf(0)
    for _ in range(n_periods):
        jacobian, here = _period_jacobian(mole, here, phase)
        products = [jacobian * each for each in products] + [jacobian]
        worst = max([worst, *map(_norm, products)])
    return TangentGrowth(float(_norm(products[0])), float(worst))


def _setup(
    parameters: Mapping[str, Any], initial: Mapping[str, Any], start_phase: Any
) -> tuple[Mole, Here, mpf]:
    mole = Mole(**{name: mpf(value) for name, value in {**DEFAULTS, **parameters}.items()})
    unknown = set(initial) - set(State._fields)
    if unknown:
        raise ValueError(f"unknown states {sorted(unknown)}; there are {State._fields}")
    state = State(*(mpf(initial.get(name, 0)) for name in State._fields))
    phase = mole.phi + mpf(start_phase)
    return mole, begin(mole, state, phase), phase


def _period_jacobian(mole: Mole, here: Here, phase: mpf) -> tuple[mp.matrix, Here]:
    """The tangent map of one period as a 4 x 4 matrix, and where the period ends."""
    if here.known_zeros:
        raise ValueError("no derivative: the start lies on a switching surface")
    after, events, _ = advance(mole, here, phase, mole.period)
    jacobian = mp.zeros(4)
    for direction in _tangent_directions(here.mode):
        moved = State(*(x + PERTURBATION * d for x, d in zip(here.state, direction, strict=True)))
        end, its_events, _ = advance(mole, here._replace(state=moved), phase, mole.period)
        if [e[1:3] for e in its_events] != [e[1:3] for e in events]:
            raise Undecidable("a graze so close that the perturbation changes the events")
        change = [(x - x0) / PERTURBATION for x, x0 in zip(end.state, after.state, strict=True)]
        jacobian += mp.matrix(change) * mp.matrix(direction).T
    return jacobian, after


def _tangent_directions(mode: str) -> list[tuple[mpf, ...]]:
    """Orthonormal directions in (p, y, q, v) that keep the mode's own surface."""
    diagonal = 1 / mp.sqrt(2)
    if mode == "no_contact":
        return [(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)]
    return [(diagonal, 0, diagonal, 0), (0, 1, 0, 0), (0, 0, 0, 1)]


def _norm(matrix: mp.matrix) -> mpf:
    return max(mp.svd_r(matrix, compute_uv=False))
