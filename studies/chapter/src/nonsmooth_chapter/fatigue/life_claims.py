"""Claims on the specimen and its lives, under harmonic and chaotic shaking."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
from scipy.integrate import quad
from scipy.stats import spearmanr

from nonsmooth.excitation import equal_power
from nonsmooth.fatigue import (
    Specimen,
    Walker,
    aluminium_2024_t351,
    chapter_tests,
    compare_lives,
    count_cycles,
    growth_by_frequency,
    published_laws,
)
from nonsmooth_chapter.fatigue.chaotic_loads import (
    CRACKS,
    DAMPINGS,
    FREQUENCY,
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
from nonsmooth_chapter.judgement import Evidence, Finding, agrees

__all__ = ["ORDERS"]


# Claims on material, tests and specimen: Tables 1-3, compliance, sensor, bending frequency.

_DIGIT = 0.01  # of a percentage in Table 2
_ROUNDING = 1e-12
_LEAST_SPAN = 2.5
_SAME = 0.02  # of two published formulas
_FAR = 10.0  # an order of magnitude
_TEST_FREQUENCY = 20.0


def _composition() -> Evidence:
    parts = aluminium_2024_t351()["composition"]
    return {
        "elements": [str(name) for name in parts["element"].values],
        "sum": round(float(parts.sum()), 9),
    }


def _judge_composition(evidence: Evidence) -> Finding:
    total = evidence["sum"]
    return Finding(
        abs(total - 100.0) < _DIGIT / 2,
        f"the {len(evidence['elements'])} percentages add up to {total:.2f}",
    )


def _load_ratios() -> Evidence:
    tests = chapter_tests()
    rows = [
        {
            "test": str(name),
            "computed": float((mean - size) / (mean + size)),
            "printed": f"{float(printed):g}",
        }
        for name, mean, size, printed in zip(
            tests["test"].values, tests["mean_load"].values, tests["load_amplitude"].values,
            tests["printed_ratio"].values, strict=True,
        )
    ]  # fmt: skip
    return {"rows": rows}


def _judge_load_ratios(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    wrong = [row["test"] for row in rows if not agrees(row["computed"], row["printed"])]
    listed = ", ".join(f"{row['test']} {row['computed']:.3f} ({row['printed']})" for row in rows)
    return Finding(not wrong, f"computed (printed): {listed}; wrong: {', '.join(wrong) or 'none'}")


def _crack_free(lengths: tuple[float, ...] = (1.0, 0.1, 0.01, 1e-3, 1e-4)) -> Evidence:
    """Deflection of a beam by the work of its moments, and what a short crack adds."""
    s = Specimen()
    inertia = s.thickness * s.width**3 / 12.0
    work = 2.0 * quad(lambda x: (0.5 * x) ** 2, 0.0, 0.5 * s.span, epsabs=0.0, epsrel=1e-13)[0]
    added = [float(s.crack_compliance(a)) for a in lengths]
    return {
        "by_moments": work / (1e3 * s.youngs_modulus * inertia),
        "by_formula": 1.0 / s.closed_stiffness,
        "lengths": list(lengths),
        "added": added,
        "added_at_zero": float(s.crack_compliance(0.0)),
        "total_at_zero": float(s.compliance(0.0)),
        "order": float(np.log(added[-2] / added[-1]) / np.log(lengths[-2] / lengths[-1])),
    }


def _judge_crack_free(evidence: Evidence) -> Finding:
    off = evidence["by_formula"] / evidence["by_moments"] - 1.0
    vanishes = evidence["added_at_zero"] == 0.0 and all(np.diff(evidence["added"]) < 0.0)
    return Finding(
        abs(off) < _ROUNDING and vanishes and evidence["order"] > 0.0,
        f"C_nc {evidence['by_formula']:.6e} mm/N, by the work of the moments"
        f" {evidence['by_moments']:.6e} (relative difference {off:.0e}); C_c at zero crack"
        f" {evidence['added_at_zero']:g}, going with the crack to the power"
        f" {evidence['order']:.2f}",
    )


def _second_formula(ratios: tuple[float, ...] = tuple(np.linspace(0.05, 0.95, 91))) -> Evidence:
    """Stress intensity from the slope of Eq. (32) beside handbooks' formulas."""
    s, short = Specimen(), Specimen(span=80.0)
    cracks = np.array(ratios) * s.width
    pairs = {
        "pure bending, Tada, at this span": (s, "tada", cracks),
        "Guinea's own for stress intensity, at this span": (s, "guinea", cracks),
        # what Srawley states as its range
        "Srawley, span of 4 widths": (short, "srawley", cracks[np.array(ratios) >= 0.2]),
    }
    rows = []
    for name, (beam, formula, at) in pairs.items():
        ours = beam.stress_intensity(1.0, at)
        off = ours / beam.stress_intensity(1.0, at, formula) - 1.0
        worst = int(np.abs(off).argmax())
        rows.append(
            {"formula": name, "worst": float(off[worst]), "at": float(at[worst] / beam.width)}
        )
    return {"span_ratio": s.span_ratio, "rows": rows}


def _judge_second_formula(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    listed = "; ".join(
        f"{row['formula']}: {row['worst']:+.2%} at most, at a/W = {row['at']:.2f}" for row in rows
    )
    return Finding(
        evidence["span_ratio"] > _LEAST_SPAN and all(abs(row["worst"]) <= _SAME for row in rows),
        f"span over width {evidence['span_ratio']:g}; stress intensity from Eq. (32) beside"
        f" {listed}",
    )


def _sensor(
    gains: tuple[float, ...] = (-1e4, -200.0, -1.0, 1.0, 200.0, 1e4),
    voltages: tuple[float, ...] = (-5.0, 0.3, 10.0),
    points: int = 96,
) -> Evidence:
    s = Specimen()
    cracks = np.linspace(0.0, 0.95, points) * s.width
    worst = 0.0
    for gain in gains:
        for voltage in voltages:
            deflection = gain / 1000.0 * voltage
            off = s.load(voltage, gain, cracks) / deflection / s.stiffness(cracks) - 1.0
            worst = max(worst, float(np.abs(off).max()))
    return {"worst": worst, "gains": list(gains), "crack_ratios": [0.0, 0.95]}


def _judge_sensor(evidence: Evidence) -> Finding:
    low, high = min(map(abs, evidence["gains"])), max(map(abs, evidence["gains"]))
    return Finding(
        evidence["worst"] < _ROUNDING,
        f"P over deflection is k_op of Eq. (48) within {evidence['worst']:.0e}, relative, at crack"
        f" ratios from 0 to 0.95, gains of either sign from {low:g} to {high:g}. It is an identity"
        " of the printed formulas: Eq. (33) divides the deflection G_f V_so/1000 by C_nc + C_c, and"
        " Eq. (48) is 1/(C_nc + C_c); the runs show that the program keeps to both",
        for_all="every gain, by the identity",
    )


def _bending(frequency: float = _TEST_FREQUENCY) -> Evidence:
    return {"frequency": Specimen().bending_frequency, "operating": frequency}


def _judge_bending(evidence: Evidence) -> Finding:
    ratio = evidence["frequency"] / evidence["operating"]
    return Finding(
        ratio >= _FAR,
        f"first bending frequency {evidence['frequency']:.0f} Hz, {ratio:.0f} times the"
        f" {evidence['operating']:g} Hz of the tests",
    )


# Claims on the eight measured lives of Table 3, and whether a law of growth orders them so.

# tests in the order in which their lives fall, by claim
ORDERS = {
    "F06": ("hl0(100)", "hl100(100)", "hl150(100)", "hl200(100)"),
    "F07": ("hl0(78.5)", "hl0(100)", "hl0(273.5)"),
    "F08": ("hl150(50)", "hl150(100)"),
    "F09": ("hl150(50)", "hl100(100)"),
    "F10": ("hl200(50)", "hl150(100)"),
}
_MEASURES = ("maximum_load", "mean_load", "load_amplitude")
_PUBLISHED = ("walker 2024-T3", "paris 2024-T351", "forman 2024-T351")
_FAR_LIFE = ((1.5, 0.05), (1.5, 0.95), (6.0, 0.05), (6.0, 0.95))  # m and gamma near their limits
_CLOSURES = ("shut", "none")


def _lives(names: Sequence[str]) -> Evidence:
    tests = chapter_tests()
    picked = tests.sel(test=list(names))
    return {
        "tests": list(names),
        "mean_load": picked["mean_load"].values.tolist(),
        "load_amplitude": picked["load_amplitude"].values.tolist(),
        "life": picked["life"].values.tolist(),
    }


def _judge_order(evidence: Evidence) -> Finding:
    lives = evidence["life"]
    listed = ", ".join(
        f"{name} {life:g} s" for name, life in zip(evidence["tests"], lives, strict=True)
    )
    return Finding(all(np.diff(lives) < 0.0), listed)


def _correlations() -> Evidence:
    """Rank correlations of the lives, and pairs of tests that each measure puts wrong."""
    tests = chapter_tests()
    lives = tests["life"].values
    rows = []
    for name in _MEASURES:
        values = tests[name].values
        found = spearmanr(values, lives)
        rows.append(
            {
                "measure": name,
                "correlation": float(found.statistic),
                **_pairs([values], lives),
            }
        )
    joint = _pairs([tests["mean_load"].values, tests["load_amplitude"].values], lives)
    return {"rows": rows, "joint": joint, "tests": int(lives.size)}


def _pairs(measures: Sequence[Any], lives: Any) -> Evidence:
    """Pairs of which one is the heavier by all measures: told, and told wrong."""
    told = wrong = 0
    for i in range(lives.size):
        for j in range(lives.size):
            steps = [m[j] - m[i] for m in measures]
            if min(steps) < 0.0 or max(steps) == 0.0:
                continue
            told += 1
            wrong += bool(lives[j] >= lives[i])
    return {"told": told, "wrong": wrong}


def _judge_correlations(evidence: Evidence) -> Finding:
    """Lives are compared in pairs, and mean and amplitude are one measure of two numbers."""
    rows = {row["measure"]: row for row in evidence["rows"]}
    maximum, joint = rows["maximum_load"], evidence["joint"]
    pairs = evidence["tests"] * (evidence["tests"] - 1) // 2
    listed = ", ".join(
        f"{name.replace('_', ' ')} {row['correlation']:+.2f} ({row['wrong']} of {row['told']} pairs"
        " wrong)"
        for name, row in rows.items()
    )
    return Finding(
        joint["wrong"] == 0 and joint["told"] > 0 and maximum["wrong"] > 0,
        f"of {pairs} pairs of tests mean and amplitude together order {joint['told']},"
        f" {joint['wrong']} of them wrong, and leave the rest open; the largest load orders"
        f" {maximum['told']}, {maximum['wrong']} of them wrong, and calls the others equal, whose"
        f" lives are not (F09, F10). Rank correlation of life with {listed}: among single numbers"
        " the largest load ranks the lives best",
    )


def _predicted(far: Sequence[tuple[float, float]] = _FAR_LIFE) -> Evidence:
    """Lives by published constants; loads in each order, from which it follows for any others."""
    tests, specimen, laws = chapter_tests(), Specimen(), published_laws()
    published = []
    for name in _PUBLISHED:
        found = compare_lives(tests, specimen.stress_intensity, laws[name])
        lives = dict(zip(found["test"].values, found["predicted"].values, strict=True))
        published.append(
            {
                "law": name,
                "source": laws[name].source,
                "ratio": {
                    str(test): float(ratio)
                    for test, ratio in zip(found["test"].values, found["ratio"].values, strict=True)
                },
                "follow": [claim for claim in ORDERS if _falls(lives, claim)],
                "rank_correlation": float(found.attrs["rank_correlation"]),
            }
        )
    base = laws["walker 2024-T3"]
    assert isinstance(base, Walker)
    broken = []
    for (m, gamma), closure in product(far, _CLOSURES):
        law = replace(base, m=m, gamma=gamma)
        found = compare_lives(tests, specimen.stress_intensity, law, closure=closure)
        lives = dict(zip(found["test"].values, found["predicted"].values, strict=True))
        broken += [
            {"m": m, "gamma": gamma, "closure": closure, "claim": claim}
            for claim in ORDERS
            if not _falls(lives, claim)
        ]
    return {"published": published, "loads": _loads(), "far": len(far) * 2, "broken": broken}


def _loads() -> list[Evidence]:
    """Largest load and range of load along each order, the range with the crack shut and not."""
    tests = chapter_tests()
    rows = []
    for claim, names in ORDERS.items():
        picked = tests.sel(test=list(names))
        mean, size = picked["mean_load"].values, picked["load_amplitude"].values
        high, low = mean + size, mean - size
        for closure in _CLOSURES:
            under = np.maximum(low, 0.0) if closure == "shut" else low
            rows.append(
                {"claim": claim, "closure": closure, "largest": high.tolist(),
                 "range": (high - under).tolist()}
            )  # fmt: skip
    return rows


def _rises(row: Evidence) -> bool:
    """Whether from test to test neither number falls, and one of them rises."""
    steps = np.diff([row["largest"], row["range"]], axis=1)
    return bool(np.all(steps >= 0.0) and np.all(steps.max(axis=0) > 0.0))


def _falls(lives: dict[str, float], claim: str) -> bool:
    values = np.array([lives[name] for name in ORDERS[claim]])
    # equal lives fall in rounding only
    return bool(np.all(np.diff(values) < -1e-9 * values[:-1]))


def _judge_predicted(evidence: Evidence) -> Finding:
    parts = []
    for row in evidence["published"]:
        ratios = list(row["ratio"].values())
        missing = [claim for claim in ORDERS if claim not in row["follow"]]
        parts.append(
            f"{row['law']}: orders {', '.join(row['follow'])} follow"
            + (f", {', '.join(missing)} not (equal lives)" if missing else "")
            + f", predicted over measured {min(ratios):.0f} to {max(ratios):.0f}, rank correlation"
            f" {row['rank_correlation']:.2f} ({row['source']})"
        )
    proved = all(_rises(row) for row in evidence["loads"])
    true = proved and not evidence["broken"]
    return Finding(
        true,
        "by Walker's law da/dN = C (Y(a) S)^m with S = Pmax^(1-gamma) dP^gamma, a life is the"
        " integral of da/(C Y^m) over S^m. From test to test of each order neither Pmax nor the"
        f" range dP falls, and one of them rises: {'yes' if proved else 'no'}, with the crack shut"
        " below zero load or not. So S rises and the life falls for any C, m > 0, Y(a) and"
        f" 0 < gamma < 1; computed lives break {len(evidence['broken'])} orders in"
        f" {evidence['far']} cases at the edges. " + "; ".join(parts),
        for_all="Walker's law with any C > 0, m > 0 and 0 < gamma < 1, with the crack shut below"
        " zero load or not, by proof"
        if true
        else "",
    )


# Claims on lives under chaotic shaking: ratios, their spread, and what does the damage.

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
