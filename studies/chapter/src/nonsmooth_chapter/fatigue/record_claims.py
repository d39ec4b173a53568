"""Claims on the measured records: broken symmetry (Fig. 16), likeness to the shaking (Fig. 17)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth.excitation import Excitation
from nonsmooth_chapter.fatigue.chaotic_loads import wave
from nonsmooth_chapter.fatigue.loaded_rig import (
    FREQUENCY,
    RIGS,
    base_amplitude,
    chaotic,
    harmonic,
)
from nonsmooth_chapter.fatigue.rig_data import stays
from nonsmooth_chapter.judgement import Check, Evidence, Finding

__all__ = ["CHECKS", "chaotic_shaking"]

_CRACKS = (6.4, 8.0, 10.0, 12.0, 14.0, 16.0)
_BROKEN = 0.01  # even harmonics beside the first
_ALIKE = 0.9
_DROP = 4.0  # s


def _asymmetry(cracks: Sequence[float] = _CRACKS, mean: float = 100.0) -> Evidence:
    rows = []
    for name in RIGS:
        for crack in cracks:
            run = harmonic(name, crack, mean)
            row = {
                "rig": name,
                "crack": crack,
                "phases": sorted({stay[0] for stay in stays(run)}),
                "least_load": float(run["load"].min()),
                "largest_load": float(run["load"].max()),
                "deflection": float(run["deflection"].values[:-1].mean()),
                "swing": 0.5 * float(np.ptp(run["deflection"].values)),
            }
            for what in ("absolute1", "X3"):
                lines = np.abs(np.fft.rfft(run[what].values[:-1])) / (run.sizes["time"] - 1)
                first = 2.0 * lines[1]
                row[f"{what}_even"] = float(2.0 * np.sqrt(np.sum(lines[2:20:2] ** 2)) / first)
                row[f"{what}_mean"] = float(np.mean(run[what].values[:-1]) / first)
            rows.append(row)
    return {
        "rows": rows,
        "mean_load": mean,
        "base_amplitude": {name: base_amplitude(name, mean) for name in RIGS},
    }


def _judge_asymmetry(evidence: Evidence) -> Finding:
    parts, broken = [], []
    for name in RIGS:
        rows = [row for row in evidence["rows"] if row["rig"] == name]
        both = [min(row["absolute1_even"], row["X3_even"]) for row in rows]
        broken.append(max(both) > _BROKEN and both[-1] > both[0])
        listed = ", ".join(
            f"{row['crack']:g} mm {row['X3_even']:.1%} and {row['absolute1_even']:.1%}"
            for row in rows
        )
        parts.append(
            f"{name} rig, even harmonics of displacement and acceleration: {listed} (least load"
            f" {rows[0]['least_load']:.1f} N at {rows[0]['crack']:g} mm,"
            f" {rows[-1]['least_load']:.1f} N at {rows[-1]['crack']:g} mm); mean deflection from"
            f" {rows[0]['deflection']:.3f} to {rows[-1]['deflection']:.3f} mm, amplitude from"
            f" {rows[0]['swing']:.3f} to {rows[-1]['swing']:.3f} mm"
        )
    return Finding(
        all(broken) if len(set(broken)) == 1 else None,
        "; ".join(parts) + "; the crack breathes, and breaks the symmetry, only where its growth"
        " drives the load below zero, which hangs on the rig",
    )


def chaotic_shaking(name: str, mean: float) -> Excitation:
    """The stated Duffing wave with the power of the harmonic shaking of a test.

    Parameters
    ----------
    name : str
        One of the rigs of `loaded_rig`.
    mean : float
        Mean load in N.

    Returns
    -------
    Excitation
    """
    omega = 2.0 * np.pi * FREQUENCY
    amplitude = 1e-3 * base_amplitude(name, mean) * omega**2
    return wave().scaled(amplitude / np.sqrt(2.0 * wave().power()))


def _likeness(cracks: Sequence[float] = (6.4, 10.0, 14.0), mean: float = 0.0) -> Evidence:
    rows = []
    for name in RIGS:
        record = chaotic_shaking(name, mean)
        for crack in cracks:
            run = chaotic(name, crack, mean, record, _DROP)
            step = float(run["time"][1] - run["time"][0])
            row = {"rig": name, "crack": crack, "phases": run.attrs["phases"]}
            for what in ("absolute1", "X3", "pneumatic1"):
                best, lag = _best_lag(run["base"].values, run[what].values)
                row[what] = best
                row[f"{what}_lag"] = 1e3 * lag * step
            rows.append(row)
    return {"rows": rows, "mean_load": mean}


def _best_lag(first: np.ndarray, second: np.ndarray) -> tuple[float, int]:
    """Correlation of largest size of a record with an earlier or later one, and the lag."""
    most = int(1.0 / FREQUENCY / 2.0 * 640.0)  # half a period of 20 Hz
    found = []
    for lag in range(-most, most + 1):
        a = first[most : first.size - most]
        b = second[most + lag : second.size - most + lag]
        found.append(float(np.corrcoef(a, b)[0, 1]))
    best = int(np.argmax(np.abs(found)))
    return found[best], best - most


def _judge_likeness(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    listed = "; ".join(
        f"{row['rig']} rig, crack {row['crack']:g} mm (phases {row['phases']}): acceleration of"
        f" mass 1 {row['absolute1']:+.3f} at {row['absolute1_lag']:.1f} ms, displacement"
        f" {row['X3']:+.3f}, force of cylinder 1 {row['pneumatic1']:+.3f}"
        for row in rows
    )
    return Finding(
        all(abs(row["absolute1"]) >= _ALIKE for row in rows),
        f"correlation with the base acceleration at the best lag, {listed}",
    )


_RIG = (
    "two-mass rigs with the parameters of Figs. 25 and 24 in SI, cylinders pressed to keep contact,"
    " base amplitude set for 100 N at 6.4 mm and kept"
)
CHECKS = (
    Check("F18", f"{_RIG}; mean 100 N, 20 Hz, steady motion after 400 periods; harmonics 2, 4 to 18"
          f" over the first; broken: above {_BROKEN:.0%} in both records and growing",
          _asymmetry, _judge_asymmetry),
    Check("F19", f"{_RIG}; mean 0, Ueda's wave of equal mean square, {_DROP:g} s of 12 dropped;"
          f" very similar: {_ALIKE:g} at least for the acceleration of mass 1, lags up to"
          " half a period",
          _likeness, _judge_likeness),
)  # fmt: skip
