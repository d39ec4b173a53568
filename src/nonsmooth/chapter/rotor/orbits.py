"""Periodic orbits of the rotor: found by Newton's method, followed, their bifurcations located.

An orbit is taken at a phase at which the rotor moves freely, halfway between two contacts: there
the ring is at rest, and the state is the rotor's alone.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from nonsmooth import StroboscopicMap, System, simulate
from nonsmooth.chapter.judgement import Evidence
from nonsmooth.errors import NonsmoothError, RunError, RunWarning

__all__ = ["Orbit", "follow_orbit", "orbit_near"]

_STATES = ("x", "y", "vx", "vy")
_SAMPLES = 128  # per period, among which a free phase is sought
_NEWTON, _CLOSED = 12, 1e-11
_SMALLEST = 1e-7  # step of eta, below which a branch has come to its end
_SHARP = 1e-9  # width to which a bifurcation is bisected
_FAR = 0.05  # from the predicted point: another orbit
_NEAR_ONE = 0.95  # a multiplier that was about to leave when the branch ended
_JUMP = 0.02  # of a multiplier across that width: no smooth bifurcation but a jump of the slope


@dataclass(frozen=True)
class Orbit:
    """A periodic orbit of the rotor.

    Parameters
    ----------
    eta : float
        Ratio of frequencies.
    period : int
        In periods of the forcing.
    phase : float
        Part of the forcing period at which it is taken.
    point : numpy.ndarray
        States x, y, vx, vy there.
    multipliers : numpy.ndarray
        The largest first.
    residual : float
        Distance from the image.

    Examples
    --------
    >>> import numpy as np
    >>> Orbit(2.0, 1, 0.5, np.zeros(4), np.array([-0.5 + 0j]), 0.0).largest
    0.5
    """

    eta: float
    period: int
    phase: float
    point: np.ndarray
    multipliers: np.ndarray
    residual: float

    @property
    def largest(self) -> float:
        """Modulus of the largest multiplier."""
        return float(np.abs(self.multipliers[0]))

    @property
    def start(self) -> dict[str, float]:
        """Its point by names of states."""
        return dict(zip(_STATES, self.point.tolist(), strict=True))


def orbit_near(system: System, strobe: Mapping[str, float], period: int) -> Orbit | None:
    """Periodic orbit near a state at phase 0, such as the strobe of a settled motion.

    Parameters
    ----------
    system : System
        The rotor.
    strobe : mapping of str to float
        State at phase 0.
    period : int
        Period to look for, in periods of the forcing.

    Returns
    -------
    Orbit or None
        None where Newton's method finds none of this period.

    Examples
    --------
    >>> from nonsmooth.chapter.rotor.data import set_a
    >>> from nonsmooth.chapter.rotor.speed_sweeps import last_strobe
    >>> system = set_a(0.0, eta=2.05)
    >>> found = orbit_near(system, last_strobe(system, transient=300), 1)
    >>> found.period, found.largest < 1.0
    (1, True)
    """
    run = simulate(system, strobe, periods=period, samples_per_period=_SAMPLES)
    phase, guess = _free_phase(run)
    if guess is None:
        return None
    return _refined(system, guess, period, phase)


def _free_phase(run: xr.Dataset) -> tuple[float, np.ndarray | None]:
    """Middle of the longest stretch of a run without contact: its phase and state."""
    free = run["gap"].values[:-1] > 0.0
    best, begin = (0, 0), None
    for k, each in enumerate([*free.tolist(), False]):
        if each and begin is None:
            begin = k
        elif not each and begin is not None:
            best = max(best, (k - begin, begin))
            begin = None
    length, begin = best
    if length == 0:
        return 0.0, None
    middle = begin + length // 2
    states = np.array([float(run[name][middle]) for name in _STATES])
    return (middle % _SAMPLES) / _SAMPLES, states


def _refined(system: System, guess: np.ndarray, period: int, phase: float) -> Orbit | None:
    turn = StroboscopicMap(system, phase=phase, every=period)
    point = guess.copy()
    try:
        for _ in range(_NEWTON):
            start = dict(zip(_STATES, point.tolist(), strict=True))
            image = _image(turn, start)
            slope = turn.tangent(start).values[:4, :4]
            residual = float(np.abs(image - point).max())
            if residual <= _CLOSED:
                break
            step = np.linalg.solve(slope - np.eye(4), image - point)
            if not np.all(np.abs(step) < 1.0):
                return None
            point = point - step
        else:
            return None
    except (NonsmoothError, np.linalg.LinAlgError):
        return None
    for part in range(1, period):
        if period % part == 0 and _repeats(system, point, part, phase):
            return None  # an orbit of a lower period
    values = np.linalg.eigvals(slope)
    order = np.argsort(-np.abs(values), kind="stable")
    eta = float(system.parameter_values["eta"])
    return Orbit(eta, period, phase, point, values[order].astype(complex), residual)


def _repeats(system: System, point: np.ndarray, part: int, phase: float) -> bool:
    start = dict(zip(_STATES, point.tolist(), strict=True))
    image = _image(StroboscopicMap(system, phase=phase, every=part), start)
    return bool(np.abs(image - point).max() < 1e-7)


def _image(turn: StroboscopicMap, start: Mapping[str, float]) -> np.ndarray:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)  # Newton's steps may lead anywhere
        image = turn.iterate(start, 1)
    if image.attrs["status"] != "completed":
        raise RunError(f"the run ended early: {image.attrs['status']}")
    return np.array([float(image[name][-1]) for name in _STATES])


def follow_orbit(system: System, orbit: Orbit, to: float, *, step: float = 0.005) -> Evidence:
    """Follow a stable orbit over eta until it bifurcates, ends, or reaches a value.

    Parameters
    ----------
    system : System
        The rotor.
    orbit : Orbit
        Where to begin.
    to : float
        Last value of eta.
    step : float, optional
        Largest step of eta.

    Returns
    -------
    dict
        ``eta`` where the branch stops being stable (or ``to``), ``kind``: ``"flip"``, ``"fold"``,
        ``"torus"``, ``"jump"`` (multipliers jump across the unit circle, as at grazing),
        ``"halving"`` (it merges with the orbit of half its period, which flips there),
        ``"lost"`` (Newton's method finds no continuation), ``"none"`` (stable up to ``to``), and
        the ``multiplier`` there as real and imaginary part; ``steps``; ``start`` and ``phase`` of
        its point.

    Examples
    --------
    >>> from nonsmooth.chapter.rotor.data import set_a
    >>> from nonsmooth.chapter.rotor.speed_sweeps import last_strobe
    >>> system = set_a(0.0, eta=2.05)
    >>> found = orbit_near(system, last_strobe(system, transient=300), 1)
    >>> follow_orbit(system, found, 2.1)["kind"]
    'none'
    """
    way = 1.0 if to > orbit.eta else -1.0
    branch, length = [orbit], step
    while abs(branch[-1].eta - to) > _SMALLEST:
        eta = branch[-1].eta + way * min(length, abs(to - branch[-1].eta))
        new = _continued(system, branch, eta)
        if new is None:
            length *= 0.5
            if length < _SMALLEST:
                return _ended(branch, _kind_of_end(system, branch[-1]))
            continue
        if new.largest >= 1.0:
            return _bisected(system, branch, new)
        branch.append(new)
        length = min(step, 1.5 * length)
    return _ended(branch, "none")


def _continued(system: System, branch: list[Orbit], eta: float) -> Orbit | None:
    """The orbit at another eta, from the line through the last two."""
    last = branch[-1]
    guess = last.point
    if len(branch) > 1 and branch[-2].phase == last.phase:
        share = (eta - last.eta) / (last.eta - branch[-2].eta)
        guess = last.point + share * (last.point - branch[-2].point)
    there = system.with_parameters(eta=eta)
    new = _refined(there, guess, last.period, last.phase)
    if new is None:  # contacts may have moved to this phase
        moved = _at_free_phase(system, last)
        if moved is None or moved.phase == last.phase:
            return None
        branch[-1], guess = moved, moved.point
        new = _refined(there, guess, last.period, moved.phase)
    if new is not None and np.abs(new.point - guess).max() > _FAR:
        return None  # another branch
    return new


def _at_free_phase(system: System, orbit: Orbit) -> Orbit | None:
    """The same orbit at the phase that is furthest from its contacts."""
    here = system.with_parameters(eta=orbit.eta)
    turn = float(here.period_value or 0.0)
    run = simulate(
        here, orbit.start, periods=orbit.period, samples_per_period=_SAMPLES,
        t_start=orbit.phase * turn,
    )  # fmt: skip
    phase, guess = _free_phase(run)
    if guess is None:
        return None
    return _refined(here, guess, orbit.period, (phase + orbit.phase) % 1.0)


def _bisected(system: System, branch: list[Orbit], beyond: Orbit) -> Evidence:
    """The value of eta between a stable orbit and an unstable one."""
    inside = branch[-1]
    while abs(beyond.eta - inside.eta) > _SHARP:
        middle = 0.5 * (beyond.eta + inside.eta)
        new = _continued(system, [inside], middle)
        if new is None:
            return _ended([*branch, inside], _kind_of_end(system, inside))
        if new.largest >= 1.0:
            beyond = new
        else:
            inside = new
    kind = "jump"
    if beyond.largest - inside.largest < _JUMP:
        value = beyond.multipliers[0]
        kind = "torus" if abs(value.imag) > 1e-6 else "flip" if value.real < 0.0 else "fold"
    return _ended([*branch, beyond], kind)


def _kind_of_end(system: System, last: Orbit) -> str:
    value = last.multipliers[0]
    if abs(value.imag) > 1e-6 or value.real < _NEAR_ONE:
        return "lost"
    if last.period % 2 == 0:
        here = system.with_parameters(eta=last.eta)
        half = _image(StroboscopicMap(here, phase=last.phase, every=last.period // 2), last.start)
        if np.abs(half - last.point).max() < _FAR:
            return "halving"
    return "fold"


def _ended(branch: list[Orbit], kind: str) -> Evidence:
    last = branch[-1]
    value = last.multipliers[0]
    return {
        "eta": last.eta,
        "kind": kind,
        "multiplier": [float(value.real), float(value.imag)],
        "steps": len(branch) - 1,
        "start": last.start,
        "phase": last.phase,
    }
