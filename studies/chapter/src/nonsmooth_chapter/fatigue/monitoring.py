"""Telling chaos from strobes with noise: two detectors, and how often they are wrong."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import xarray as xr

from nonsmooth import ensemble, zero_one_test
from nonsmooth_chapter.fatigue.beam_data import beam
from nonsmooth_chapter.fatigue.crack_motions import largest_exponent, period_of
from nonsmooth_chapter.fatigue.onset import crack_grid
from nonsmooth_chapter.judgement import Evidence

__all__ = ["NOISE", "STROBES", "THRESHOLD", "alarm_rates", "scatter", "strobed_motions"]

NOISE = (0.0, 0.001, 0.01, 0.05)  # standard deviation beside the amplitude of u
STROBES = 300  # of a record
THRESHOLD = 0.05  # of the amplitude: scatter above it is an alarm
_LONGEST = 8
_K = 0.5  # 0-1 test above it is an alarm


def scatter(strobes: np.ndarray, longest: int = _LONGEST) -> float:
    """What no period explains in strobes: least root mean square about the points of a cycle.

    Parameters
    ----------
    strobes : numpy.ndarray
        One value per period of the forcing.
    longest : int, optional
        Longest period that is tried.

    Returns
    -------
    float

    Examples
    --------
    >>> scatter(np.tile([1.0, 0.0, 2.0], 20))
    0.0
    """
    least = np.inf
    for n in range(1, longest + 1):
        whole = strobes[: len(strobes) // n * n].reshape(-1, n)
        left = whole - whole.mean(axis=0)
        # each mean takes one degree of freedom
        least = min(least, float(np.sqrt(np.sum(left**2) / max(left.size - n, 1))))
    return least


@lru_cache(maxsize=2)
def strobed_motions(
    step: float = 0.05, fine: float = 0.01, transient: int = 1000
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Strobes of settled motions from rest over the crack length, and what they are.

    Parameters
    ----------
    step : float, optional
        Between lengths [mm].
    fine : float, optional
        The same from 14.2 to 15, where chaos begins.
    transient : int, optional
        Periods left out.

    Returns
    -------
    cracks, strobes, amplitudes, labels : numpy.ndarray
        Lengths; deflections at strobes; half of the range of u at 16 phases; period, 0 for chaos,
        -1 for neither.
    """
    cracks = np.unique(np.append(crack_grid(step=step), crack_grid(14.2, 15.0, fine)))
    system, values = beam(5.0), {"crack": cracks.tolist()}
    runs = ensemble(system, parameters=values, transient=transient, record=STROBES)
    points = np.stack([runs["u"].values, runs["v"].values], axis=-1)
    labels = np.array([period_of(orbit) for orbit in points])
    for lane in np.flatnonzero(labels == 0):
        there = beam(float(cracks[lane]))
        known = largest_exponent(there, runs.isel(lane=lane, point=-1), record=600)
        labels[lane] = 0 if known["chaotic"] else -1
    return cracks, points[:, :, 0], _amplitudes(runs, cracks), labels


def _amplitudes(runs: xr.Dataset, cracks: np.ndarray) -> np.ndarray:
    """Half of the range of u over 8 periods behind the strobes."""
    last = runs.isel(point=-1)
    turn = float(beam(5.0).period_value or 0.0)
    behind = ensemble(
        beam(5.0), {name: last[name].values.tolist() for name in ("u", "v")},
        parameters={"crack": cracks.tolist()}, combine="pairs",
        times=np.linspace(0.0, 8.0 * turn, 129),
    )  # fmt: skip
    found: np.ndarray = np.ptp(behind["u"].values, axis=1) / 2.0
    return found


@lru_cache(maxsize=2)
def alarm_rates(seed: int = 0) -> tuple[Evidence, ...]:
    """How often two detectors are wrong, over levels of noise.

    Parameters
    ----------
    seed : int, optional
        Of the noise.

    Returns
    -------
    tuple of dict
        For each level ``noise``; the numbers of ``periodic`` and ``chaotic`` records; for each of
        the detectors ``amplitude``, ``scatter`` and ``zero_one`` the shares of ``false`` alarms
        among the former and ``missed`` ones among the latter.

    Notes
    -----
    The amplitude is what a monitor without any theory of chaos would watch. Its limit is the one
    that errs least in these very records, which favours it.
    """
    _, strobes, amplitudes, labels = strobed_motions()
    random = np.random.default_rng(seed)
    rows = []
    for level in NOISE:
        drawn = random.standard_normal(strobes.shape) * level * amplitudes[:, None]
        seen = strobes + drawn
        felt = amplitudes * (1.0 + level * random.standard_normal(amplitudes.size))
        alarms = {
            "amplitude": felt > _dividing(felt, labels),
            "scatter": np.array([scatter(row) for row in seen]) > THRESHOLD * amplitudes,
            "zero_one": np.array([float(zero_one_test(row)["K"]) > _K for row in seen]),
        }
        row: Evidence = {
            "noise": level,
            "periodic": int(np.sum(labels > 0)),
            "chaotic": int(np.sum(labels == 0)),
        }
        for name, alarm in alarms.items():
            row[name] = {
                "false": float(alarm[labels > 0].mean()),
                "missed": float(1.0 - alarm[labels == 0].mean()),
            }
        rows.append(row)
    return tuple(rows)


def _dividing(values: np.ndarray, labels: np.ndarray) -> float:
    """Limit above which values mean chaos with the least sum of false and missed alarms."""
    known = labels >= 0
    limits = np.sort(values[known])
    errors = [
        (values[labels > 0] > limit).mean() + (values[labels == 0] <= limit).mean()
        for limit in limits
    ]
    return float(limits[int(np.argmin(errors))])
