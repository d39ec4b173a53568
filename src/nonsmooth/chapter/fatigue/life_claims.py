"""Claims on the eight measured lives of Table 3, and whether a law of growth orders them so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.stats import spearmanr

from nonsmooth.chapter.judgement import Check, Evidence, Finding
from nonsmooth.fatigue import (
    Specimen,
    Walker,
    chapter_tests,
    compare_lives,
    published_laws,
)

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
_PUBLISHED = ("walker 2024-T3", "paris 2024-T3")
_EXPONENTS, _GAMMAS = (1.5, 2.0, 3.0, 4.0, 5.0, 6.0), (0.05, 0.3, 0.5, 0.68, 0.95)
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
    rows = {row["measure"]: row for row in evidence["rows"]}
    worst = abs(rows["maximum_load"]["correlation"])
    others = [abs(rows[name]["correlation"]) for name in _MEASURES[1:]]
    listed = ", ".join(
        f"{name.replace('_', ' ')} {row['correlation']:+.2f} ({row['wrong']} of {row['told']} pairs"
        " wrong)"
        for name, row in rows.items()
    )
    joint = evidence["joint"]
    return Finding(
        worst < min(others),
        f"rank correlation of life with {listed}; mean and amplitude taken together order"
        f" {joint['told']} pairs, {joint['wrong']} of them wrong, and leave the rest of 28 open;"
        " among the three the largest load ranks the lives best, though two pairs with the same"
        " one differ (F09, F10)",
    )


def _predicted(
    exponents: Sequence[float] = _EXPONENTS, gammas: Sequence[float] = _GAMMAS
) -> Evidence:
    """Lives by published constants, and which orders hold over a range of Walker's."""
    tests, specimen = chapter_tests(), Specimen()
    laws = published_laws()
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
    for m in exponents:
        for gamma in gammas:
            for closure in _CLOSURES:
                law = replace(base, m=m, gamma=gamma)
                found = compare_lives(tests, specimen.stress_intensity, law, closure=closure)
                lives = dict(zip(found["test"].values, found["predicted"].values, strict=True))
                broken += [
                    {"m": m, "gamma": gamma, "closure": closure, "claim": claim}
                    for claim in ORDERS
                    if not _falls(lives, claim)
                ]
    return {
        "published": published,
        "exponents": [min(exponents), max(exponents)],
        "gammas": [min(gammas), max(gammas)],
        "laws": len(exponents) * len(gammas) * len(_CLOSURES),
        "broken": broken,
    }


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
            f" {row['rank_correlation']:.2f}"
        )
    low, high = evidence["gammas"]
    first, last = evidence["exponents"]
    true = not evidence["broken"]
    return Finding(
        true,
        "; ".join(parts)
        + f"; {evidence['laws']} sets of Walker's constants break {len(evidence['broken'])} orders"
        "; constants from handbooks: " + evidence["published"][0]["source"],
        for_all=f"Walker's law with any C, m from {first:g} to {last:g} and gamma from {low:g} to"
        f" {high:g}, with the crack shut below zero load or not"
        if true
        else "",
    )


_TABLE = "lives as printed in Table 3, strictly falling in the order claimed"
CHECKS = (
    *(_order(claim, _TABLE) for claim in ORDERS),
    Check("F11", "Spearman's correlation of the eight lives with each measure; the claim is taken"
          " as: weaker for the largest load than for mean and for amplitude", _correlations,
          _judge_correlations),
    Check("F12", "constant amplitude at 20 Hz from 6.4 to 19 mm, Irwin's stress intensity of Eq."
          " (32), closure when shut; published constants, and a grid of Walker's", _predicted,
          _judge_predicted),
)  # fmt: skip
