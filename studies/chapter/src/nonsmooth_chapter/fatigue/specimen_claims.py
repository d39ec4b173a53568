"""Claims on material, tests and specimen: Tables 1-3, compliance, sensor, bending frequency."""

from __future__ import annotations

import numpy as np
from scipy.integrate import quad

from nonsmooth.fatigue import Specimen, aluminium_2024_t351, chapter_tests
from nonsmooth_chapter.judgement import Check, Evidence, Finding, agrees

__all__ = ["CHECKS"]

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


CHECKS = (
    Check("F01", "sum of the nine printed percentages, exactly 100 in two digits", _composition,
          _judge_composition),
    Check("F02", "(mean - amplitude)/(mean + amplitude), one unit of the last printed digit",
          _load_ratios, _judge_load_ratios),
    Check("F03", "Eq. (31) beside the work of the moments by quadrature; Eq. (32) at zero and down"
          " to 1e-4 mm", _crack_free, _judge_crack_free),
    Check("F04", "Irwin's stress intensity from the slope of Eq. (32) beside three published"
          f" formulas, a/W from .05 to .95 (Srawley from .2); valid: within {_SAME:.0%}",
          _second_formula, _judge_second_formula),
    Check("F05", "Eq. (33) over G_f V_so/1000, against Eq. (48), at 96 crack ratios, six gains,"
          " three voltages", _sensor, _judge_sensor),
    Check("F20", "Euler-Bernoulli beam on two supports at the loading span, data of Table 1; far"
          f" below: a ratio of {_FAR:g} at least; the masses of the rig are not on it", _bending,
          _judge_bending),
)  # fmt: skip
