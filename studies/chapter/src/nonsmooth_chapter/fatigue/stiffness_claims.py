"""Claims on the stiffness of the cracked specimen: how it falls, and by which law."""

from __future__ import annotations

from itertools import product

import numpy as np

from nonsmooth.fatigue import Specimen, cubic_stiffness
from nonsmooth_chapter.fatigue.beam_data import K_CLOSED, WIDTH
from nonsmooth_chapter.fatigue.rig_data import SET_24, SET_25
from nonsmooth_chapter.judgement import Check, Evidence, Finding, agreed, agrees

__all__ = ["CHECKS"]

_RATIOS = (0.25, 0.5, 0.75)
_LITTLE_STIFFNESS, _LITTLE_FREQUENCY = 0.1, 0.05
_SHAPE = 0.1  # of the other law: closer is a representation of it


def _monotony(last: float = 0.95, points: int = 2000) -> Evidence:
    specimen = Specimen()
    stiffness = specimen.stiffness(np.linspace(0.0, last, points) * specimen.width)
    falls = -np.diff(stiffness)
    return {
        "points": points,
        "least_fall": float(falls.min()),
        "first": float(stiffness[0]),
        "last": float(stiffness[-1]),
        "closed": float(specimen.closed_stiffness),
    }


def _judge_monotony(evidence: Evidence) -> Finding:
    return Finding(
        evidence["least_fall"] > 0.0,
        f"from {evidence['first']:.2f} N/mm without a crack (closed {evidence['closed']:.2f}) to"
        f" {evidence['last']:.2f} N/mm, least fall between neighbours {evidence['least_fall']:.2e}",
    )


def _losses(ratios: tuple[float, ...] = _RATIOS) -> Evidence:
    """Open over closed stiffness, and over that of the notch alone."""
    specimen = Specimen()
    rows = [
        {
            "ratio": ratio,
            "over_closed": float(specimen.stiffness(ratio * WIDTH) / specimen.closed_stiffness),
            "over_notched": float(
                specimen.stiffness(ratio * WIDTH) / specimen.stiffness(specimen.notch)
            ),
        }
        for ratio in ratios
    ]
    return {"rows": rows}


def _judge_losses(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    listed = ", ".join(
        f"{row['ratio']:.0%}: {row['over_closed']:.3f} of closed, {row['over_notched']:.3f} of"
        " notched"
        for row in rows
    )
    little = [row["ratio"] for row in rows if 1.0 - max(_kept(row).values()) <= _LITTLE_STIFFNESS]
    return Finding(
        len(little) == len(rows),
        f"{listed}; little (a loss of {_LITTLE_STIFFNESS:.0%} at most, by the more favourable"
        f" comparison) at {', '.join(f'{r:.0%}' for r in little) or 'none'} of the depth",
    )


def _kept(row: Evidence) -> dict[str, float]:
    return {name: row[name] for name in ("over_closed", "over_notched")}


def _frequencies(ratios: tuple[float, ...] = _RATIOS) -> Evidence:
    """Frequency on a bilinear spring over that without a crack: the specimen alone, and in rigs.

    In a rig the springs of leaves and cylinders stand beside the specimen: 1 + kappa in place of
    kappa, Eq. (46).
    """
    specimen = Specimen()
    springs = {"alone": 0.0} | {
        name: (2.0 + 2.0 * data["lambda1"] ** 2) / data["theta"] ** 2
        for name, data in {"in the rig of Fig. 24": SET_24, "in that of Fig. 25": SET_25}.items()
    }
    rows = []
    for (name, beside), ratio in product(springs.items(), ratios):
        kept = specimen.stiffness(ratio * WIDTH) / specimen.closed_stiffness
        half = float(np.sqrt((beside + kept) / (beside + 1.0)))
        rows.append(
            {"place": name, "ratio": ratio, "bilinear": 2.0 * half / (1.0 + half), "open": half}
        )
    return {"rows": rows}


def _judge_frequencies(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    listed, true = [], []
    for place in dict.fromkeys(row["place"] for row in rows):
        own = [row for row in rows if row["place"] == place]
        true.append(all(1.0 - row["bilinear"] <= _LITTLE_FREQUENCY for row in own))
        listed.append(
            f"specimen {place} "
            + ", ".join(
                f"{row['ratio']:.0%} {row['bilinear'] - 1.0:+.1%} (always open"
                f" {row['open'] - 1.0:+.1%})"
                for row in own
            )
        )
    return Finding(
        agreed(true),
        f"bilinear frequency beside that without a crack, by depth: {'; '.join(listed)}; little:"
        f" {_LITTLE_FREQUENCY:.0%} at most at each depth",
    )


def _printed(printed: str = str(K_CLOSED), crack: float = 5.0) -> Evidence:
    return {"printed": printed, "crack": crack, "law": float(cubic_stiffness(crack))}


def _judge_printed(evidence: Evidence) -> Finding:
    return Finding(
        agrees(evidence["law"], evidence["printed"]),
        f"{evidence['law']:.6f} at {evidence['crack']:g} mm, printed {evidence['printed']}: what is"
        " called closed is the open law at the notch, the jump there is"
        f" {float(evidence['printed']) - evidence['law']:.1e}",
    )


def _shapes(first: float = 5.0, last: float = 19.0, points: int = 141) -> Evidence:
    """Cubic law beside Eq. (48), both over their values at the first length."""
    cracks = np.linspace(first, last, points)
    specimen = Specimen()
    guinea = specimen.stiffness(cracks) / specimen.stiffness(first)
    cubic = cubic_stiffness(cracks) / cubic_stiffness(first)
    worst = int(np.abs(cubic / guinea - 1.0).argmax())
    at = [8.0, 10.0, 12.09, 14.0, 16.0]
    return {
        "worst": float(cubic[worst] / guinea[worst]),
        "where": float(cracks[worst]),
        "rows": [
            {
                "crack": crack,
                "guinea": float(np.interp(crack, cracks, guinea)),
                "cubic": float(np.interp(crack, cracks, cubic)),
            }
            for crack in at
        ],
    }


def _judge_shapes(evidence: Evidence) -> Finding:
    listed = ", ".join(
        f"{row['crack']:g} mm {row['cubic']:.3f} and {row['guinea']:.3f}"
        for row in evidence["rows"]
    )
    return Finding(
        abs(evidence["worst"] - 1.0) <= _SHAPE,
        f"cubic law and Eq. (48), both 1 at 5 mm: {listed}; farthest apart at"
        f" {evidence['where']:.1f} mm, where the ratio is {evidence['worst']:.2f}",
    )


CHECKS = (
    Check("F33", "Eq. (48) at 2000 crack ratios from 0 to .95", _monotony, _judge_monotony),
    Check("F34", "Eq. (48) over (47), and over (48) at the notch of 5 mm, at 25, 50, 75 % of the"
          f" depth; little: at most {_LITTLE_STIFFNESS:.0%} lost at each", _losses, _judge_losses),
    Check("F35", "2 w1 w2 / (w1 + w2) of one mass on the closed and the open stiffness, at 25, 50,"
          " 75 % of the depth, for the specimen alone and with the springs of both rigs beside it;"
          f" little: at most {_LITTLE_FREQUENCY:.0%} at each", _frequencies,
          _judge_frequencies),
    Check("F40", "printed law at 5 mm; one unit of the last printed digit", _printed,
          _judge_printed),
    Check("F41", f"from 5 to 19 mm, both laws over their value at 5 mm; represents: within"
          f" {_SHAPE:.0%}", _shapes, _judge_shapes),
)  # fmt: skip
