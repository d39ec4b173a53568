"""Which motions of the rotor coexist: long runs from many starts inside the ring."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from nonsmooth import System, ensemble, lyapunov_spectrum
from nonsmooth_chapter.judgement import Evidence

__all__ = ["DROPPED", "STARTS", "coexisting", "random_starts"]

STARTS, DROPPED = 32, 600  # random starts, beside the one at zero; periods left out at most

_LONGEST, _REPEATS = 32, 1e-6
_EARLY = 1e-10  # likewise of motions that are not run on: slow ones seem to have other periods
_SAME = 1e-4  # between points of one cycle
_SPAN = 600  # periods over which an exponent is taken
_STATES = ("x", "y", "vx", "vy")


def random_starts(count: int, seed: int = 0) -> dict[str, np.ndarray]:
    """Random states of the free rotor: positions within the gap, velocities up to one.

    Parameters
    ----------
    count : int
        How many.
    seed : int, optional
        Of the random numbers.

    Returns
    -------
    dict of str to numpy.ndarray
        ``x``, ``y``, ``vx``, ``vy``.

    Examples
    --------
    >>> starts = random_starts(100)
    >>> float(np.hypot(starts["x"], starts["y"]).max()) < 1.0
    True
    """
    random = np.random.default_rng(seed)
    radius, angle = 0.98 * np.sqrt(random.uniform(0, 1, count)), random.uniform(0, 2 * np.pi, count)
    velocity = random.uniform(-1.0, 1.0, (2, count))
    return {
        "x": radius * np.cos(angle), "y": radius * np.sin(angle),
        "vx": velocity[0], "vy": velocity[1],
    }  # fmt: skip


@lru_cache(maxsize=128)
def coexisting(
    system: System, starts: int = STARTS, transient: int = DROPPED, seed: int = 0
) -> tuple[Evidence, ...]:
    """Motions that random starts, and the start at zero, lead to.

    Parameters
    ----------
    system : System
        The rotor.
    starts : int, optional
        Random starts inside the ring.
    transient : int, optional
        Periods left out.
    seed : int, optional
        Of the starts.

    Returns
    -------
    tuple of dict
        The most frequent first: ``period`` (0: none), ``share`` of the starts, ``from_zero``,
        ``point`` (x, y, vx, vy at a strobe), ``state`` (all states there), and for motions
        without a period, which count as one, the largest ``exponent`` per period and its
        ``error``.

    Examples
    --------
    >>> from nonsmooth_chapter.rotor.data import set_a
    >>> [row["period"] for row in coexisting(set_a(0.0, 3.0), starts=6, transient=300)]
    [2]
    """
    initial = {
        name: np.concatenate([[0.0], values])
        for name, values in random_starts(starts, seed).items()
    }
    states = _settled(system, initial, transient)
    points = states[..., [system.states.index(name) for name in _STATES]]
    found: list[Evidence] = []
    for lane, orbit in enumerate(points):
        period = _period(orbit)
        for row in found:
            if row["period"] == period and (not period or _on(row["orbit"], orbit[-1])):
                row["count"] += 1
                break
        else:
            found.append(
                {
                    "period": period,
                    "count": 1,
                    "from_zero": lane == 0,
                    "orbit": orbit[-max(period, 1) :],
                    "point": orbit[-1].tolist(),
                    "state": dict(zip(system.states, states[lane, -1].tolist(), strict=True)),
                }
            )
    rows = []
    for row in sorted(found, key=lambda one: -one["count"]):
        kept = {name: row[name] for name in ("period", "from_zero", "point", "state")}
        kept["share"] = row["count"] / len(points)
        if not row["period"]:
            kept |= _exponent(system, row["state"])
        rows.append(kept)
    return tuple(rows)


def _settled(system: System, initial: dict[str, np.ndarray], transient: int) -> np.ndarray:
    """Strobes behind a transient, (starts, periods, states); what repeats early is not run on."""
    record = 4 * _LONGEST
    early = transient // 3
    states = _strobes(system, initial, early, record)
    free = [system.states.index(name) for name in _STATES]
    left = [lane for lane, orbit in enumerate(states) if not _period(orbit[:, free], _EARLY)]
    if left:
        last = dict(zip(system.states, states[left, -1].T, strict=True))
        states[left] = _strobes(system, last, max(0, transient - early - record), record)
    return states


def _strobes(
    system: System, initial: dict[str, np.ndarray], transient: int, record: int
) -> np.ndarray:
    runs = ensemble(system, initial, transient=transient, record=record)
    return np.stack([runs[name].values for name in system.states], axis=-1)


def _period(orbit: np.ndarray, repeats: float = _REPEATS) -> int:
    for n in range(1, _LONGEST + 1):
        if np.abs(orbit[n:] - orbit[:-n]).max() <= repeats:
            return n
    return 0


def _on(orbit: np.ndarray, point: np.ndarray) -> bool:
    return bool(np.abs(orbit - point).max(axis=1).min() < _SAME)


def _exponent(system: System, state: Evidence) -> Evidence:
    spectrum = lyapunov_spectrum(system, state, transient=10, record=_SPAN, exponents=1)
    turn = float(system.period_value or 0.0)
    value = turn * float(spectrum["lyapunov_exponent"][0])
    error = turn * float(spectrum["standard_error"][0])
    return {"exponent": value, "error": error, "chaotic": bool(value > 3.0 * max(error, 1 / _SPAN))}
