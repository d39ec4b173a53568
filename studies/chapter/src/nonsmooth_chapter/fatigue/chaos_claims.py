"""Claims on lives under chaotic shaking: ratios, their spread, and what does the damage."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth.excitation import equal_power
from nonsmooth.fatigue import (
    Specimen,
    count_cycles,
    growth_by_frequency,
    published_laws,
)
from nonsmooth_chapter.fatigue.chaotic_loads import (
    CRACKS,
    DAMPINGS,
    FREQUENCY,
    MEASURES,
    RIGS,
    STATED,
    TRANSIENT,
    WAVES,
    scaled_records,
    shaken,
    spread,
    stated_lives,
    wave,
)
from nonsmooth_chapter.judgement import Check, Evidence, Finding, agrees

__all__ = ["CHECKS"]

_FEW = 10.0
_HIGH = 1.5 * FREQUENCY  # Hz, above which an oscillation counts as of high frequency
_ABOUT = 0.02
_BAND = 0.1  # to either side of the dominant frequency


def _ratio(mean: float, printed: str) -> Evidence:
    stated = stated_lives(mean)
    rows = []
    for name in RIGS:
        data = spread(name)["ratio"].sel(mean_load=mean)
        for law in data["law"].values:
            values = data.sel(law=law).values.ravel()
            rows.append(
                {
                    "rig": name,
                    "law": str(law),
                    "least": float(values.min()),
                    "median": float(np.median(values)),
                    "most": float(values.max()),
                    "cases": int(values.size),
                    "near": int(np.sum(np.abs(values / float(printed) - 1.0) <= 0.1)),
                }
            )
    loads = [float(spread(name)["ratio"].sel(mean_load=mean, measure="load").max())
             for name in RIGS]  # fmt: skip
    return {
        "mean": mean,
        "printed": printed,
        "stated": float(stated["ratio"]),
        "power_ratio": float(stated["power_ratio"]),
        "cycles_per_second": float(stated["cycles_per_second"][0]),
        "rows": rows,
        "most_at_equal_load": max(loads),
    }


def _judge_ratio(evidence: Evidence) -> Finding:
    listed = "; ".join(
        f"{row['rig']} rig, {row['law']} law: {row['least']:.2g} to {row['most']:.2g}, median"
        f" {row['median']:.2g} ({row['near']} of {row['cases']} within 10 % of the printed ratio)"
        for row in evidence["rows"]
    )
    return Finding(
        agrees(evidence["stated"], evidence["printed"], about=_ABOUT),
        f"stated wave: {evidence['stated']:.2f} (printed {evidence['printed']}); over the unknowns,"
        f" {listed}; at equal mean square of the load {evidence['most_at_equal_load']:.2g} at most",
    )


def _few_times(printed: Sequence[float] = (4.0, 56.0)) -> Evidence:
    return {"printed": list(printed), "few": _FEW}


def _judge_few_times(evidence: Evidence) -> Finding:
    values = evidence["printed"]
    listed = " and ".join(f"{value:g}" for value in values)
    many = [value for value in values if value >= evidence["few"]]
    return Finding(
        not many,
        f"the chapter prints {listed} times; not few: {', '.join(f'{v:g}' for v in many) or 'none'}"
        f"; the two differ by a factor of {max(values) / min(values):g}",
    )


def _by_frequency(cracks: Sequence[float] = (CRACKS[0], CRACKS[2])) -> Evidence:
    """Cycles and growth below and above the limit, of the stated wave and of others."""
    s, law = Specimen(), published_laws()["walker 2024-T3"]
    rows = []
    for rig in RIGS:
        for damping in DAMPINGS:
            own = shaken(rig, damping=damping)
            for name in WAVES:
                for crack in cracks:
                    record = equal_power(wave(name), scaled_records(0.0)[0])
                    cycles = count_cycles(own.load(record, crack, TRANSIENT), refine=True)
                    found = growth_by_frequency(
                        cycles, s.stress_intensity, law, crack=crack, edges=[_HIGH]
                    )
                    rows.append(
                        {
                            "rig": rig, "damping": damping, "wave": name, "crack": crack,
                            "cycles": [float(x) for x in found["cycles_per_second"]],
                            "growth": [float(x) for x in found["growth"]],
                            "share": float(found["share"][1]),
                        }
                    )  # fmt: skip
    harmonic = stated_lives(0.0)["reference_growth"].interp(crack=list(cracks)).values.tolist()
    return {"rows": rows, "harmonic_growth": harmonic, "cracks": list(cracks)}


def _stated_row(row: Evidence) -> bool:
    return bool(row["rig"] == RIGS[0] and row["damping"] == DAMPINGS[1] and row["wave"] == STATED)


def _judge_by_frequency(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    shares = [row["share"] for row in rows]
    parts = []
    for row, harmonic in zip(
        [r for r in rows if _stated_row(r)], evidence["harmonic_growth"], strict=True
    ):
        low, high = row["cycles"]
        parts.append(
            f"crack {row['crack']:g} mm: {low:.1f} cycles a second below {_HIGH:g} Hz and"
            f" {high:.1f} above, which do {row['share']:.1%} of the damage; those below alone do"
            f" {row['growth'][0] / harmonic:.1f} times that of the harmonic load"
        )
    most = sum(share > 0.5 for share in shares)
    return Finding(
        all(row["share"] > 0.5 for row in rows if _stated_row(row)),
        f"stated wave, {'; '.join(parts)}; over rigs, dampings and waves the share is"
        f" {min(shares):.1%} to {max(shares):.1%}, above a half in {most} of {len(shares)} cases",
    )


def _spectra() -> Evidence:
    rows = []
    for name in WAVES:
        record = wave(name)
        frequency, lines = record.spectrum()
        near = np.abs(frequency / FREQUENCY - 1.0) <= _BAND
        force = record.details["omega"] * record.details["time_scale"] / (2.0 * np.pi)
        rows.append(
            {
                "wave": name,
                "dominant": record.dominant_frequency,
                "force": float(force),
                "near": float(lines[near].sum() / lines.sum()),
                "above": float(lines[frequency > _HIGH].sum() / lines.sum()),
                "exponent": record.details["exponent"],
                "error": record.details["exponent_error"],
            }
        )
    return {"rows": rows, "harmonic": FREQUENCY}


def _judge_spectra(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    listed = "; ".join(
        f"{row['wave']}: strongest line {row['dominant']:.2f} Hz (force {row['force']:.2f} Hz),"
        f" {row['near']:.0%} of the power within {_BAND:.0%} of it, {row['above']:.0%} above"
        f" {_HIGH:g} Hz, exponent {row['exponent']:.3f} +- {row['error']:.3f}"
        for row in rows
    )
    return Finding(
        None,
        f"{listed}; the time of each wave is scaled so that this comes out, an identity: the"
        " parameters of the chapter's Duffing oscillator, or its record, would decide",
    )


_CASE = (
    "Ueda's oscillator, displacement as base acceleration, strongest line at 20 Hz; equal mean"
    " square of the base acceleration; rig of Fig. 25 as one mass with a breathing crack; load"
    " amplitude 100 N at 6.4 mm; Walker's law with handbook constants, 6.4 to 14 mm"
)
_GRID = (
    f"spread over {len(WAVES)} waves, {len(RIGS)} rigs, dampings"
    f" {' and '.join(f'{d:g}' for d in DAMPINGS)}, equal {' or '.join(MEASURES)}, two laws"
)
CHECKS = (
    Check("F13", f"mean 0: {_CASE}; {_GRID}", lambda: _ratio(0.0, "4"), _judge_ratio),
    Check("F14", f"mean 150 N: {_CASE}; {_GRID}", lambda: _ratio(150.0, "56"), _judge_ratio),
    Check("F15", f"printed ratios of Figs. 21 and 22; few: less than {_FEW:g}", _few_times,
          _judge_few_times),
    Check("F16", "mean 0, at two lengths of the crack, rainflow cycles by half the time between"
          f" their ends; high: above {_HIGH:g} Hz; mainly: more than half of the damage;"
          f" {_CASE}", _by_frequency, _judge_by_frequency),
    Check("F17", f"spectra of {len(WAVES)} waves over 12 s", _spectra, _judge_spectra),
)  # fmt: skip
