"""Claims on the eight measured lives of Table 3, and whether a law of growth orders them so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
from scipy.stats import spearmanr

from nonsmooth.fatigue import (
    Specimen,
    Walker,
    chapter_tests,
    compare_lives,
    published_laws,
)
from nonsmooth_chapter.judgement import Check, Evidence, Finding

__all__ = ["CHECKS", "ORDERS"]

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
_FAR = ((1.5, 0.05), (1.5, 0.95), (6.0, 0.05), (6.0, 0.95))  # m and gamma near their limits
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


def _order(claim: str, protocol: str) -> Check:
    return Check(claim, protocol, lambda names=ORDERS[claim]: _lives(names), _judge_order)


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


def _predicted(far: Sequence[tuple[float, float]] = _FAR) -> Evidence:
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


_TABLE = "lives as printed in Table 3, strictly falling in the order claimed"
CHECKS = (
    *(_order(claim, _TABLE) for claim in ORDERS),
    Check("F11", "pairs of the eight tests, of which one is the heavier by the largest load, or by"
          " mean and amplitude both; true where the first puts some pair wrong and the second none;"
          " Spearman's correlation beside it", _correlations, _judge_correlations),
    Check("F12", "proof from Pmax and range of load along each order; constant amplitude at 20 Hz"
          " from 6.4 to 19 mm, Irwin's stress intensity of Eq. (32), closure when shut, by"
          " published constants and by Walker's law with m and gamma near their limits", _predicted,
          _judge_predicted),
)  # fmt: skip
