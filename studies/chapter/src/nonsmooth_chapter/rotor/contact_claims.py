"""Claims on contact with the ring: when it begins, what it keeps, how the free ring returns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from nonsmooth import System
from nonsmooth_chapter.judgement import Check, Evidence, Finding
from nonsmooth_chapter.rotor.data import set_a, set_b
from nonsmooth_chapter.rotor.ring_motion import in_contact, ring_run
from nonsmooth_chapter.rotor.ring_tables import force_of_springs

__all__ = ["CHECKS"]

_CLOSED = 1e-9
_SMALL, _LARGE = 0.02, 0.1  # what the rules let "about" mean, in the strict and the wide sense
# Set, preload and eta of the motions looked at: those of Fig. 38, and chaos of Fig. 37.
_MOTIONS = (
    ("B", 0.0, 2.5), ("B", 0.05, 2.5), ("A", 0.0, 3.0), ("A", 0.03, 3.0), ("A", 0.0, 2.442),
    ("A", 0.1, 2.442),
)  # fmt: skip


def _system(name: str, delta: float, eta: float) -> System:
    return {"A": set_a, "B": set_b}[name](delta, eta)


def _named(row: Evidence) -> str:
    return f"set {row['set']}, Delta {row['delta']:g}, eta {row['eta']:g}"


def _distance(
    motions: Sequence[tuple[str, float, float]] = _MOTIONS, periods: int = 20
) -> Evidence:
    """Contact, and distance of the rotor from the origin, at the places that the ring has."""
    rows = []
    for name, delta, eta in motions:
        run = ring_run(_system(name, delta, eta), transient=300, periods=periods)
        free, outside = ~in_contact(run), np.hypot(run["x"].values, run["y"].values) > 1.0
        off = np.hypot(run["sx"].values, run["sy"].values)
        rows.append(
            {
                "set": name, "delta": delta, "eta": eta,
                "free": int(free.sum()), "touching": int((~free).sum()),
                "free_outside": int((free & outside).sum()),
                "touching_inside": int((~free & ~outside).sum()),
                "eccentric": float(off[free].max(initial=0.0)),
            }
        )  # fmt: skip
    return {"rows": rows}


def _judge_distance(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    listed = "; ".join(
        f"{_named(row)}: {row['free_outside']} of {row['free']} samples without contact have"
        f" R > gamma, {row['touching_inside']} of {row['touching']} in contact R <= gamma, the free"
        f" ring up to {row['eccentric']:.2g} gaps off its centre"
        for row in rows
    )
    true = not any(row["free_outside"] or row["touching_inside"] for row in rows)
    return Finding(
        true,
        f"{listed}; contact is decided by D < gamma, the same as R < gamma for a centred ring only",
    )


def _kept(motions: Sequence[tuple[str, float, float]] = _MOTIONS, periods: int = 20) -> Evidence:
    rows = []
    for name, delta, eta in motions:
        run = ring_run(_system(name, delta, eta), transient=300, periods=periods)
        touching = in_contact(run)
        normal = _normal_force(run, delta)[touching]
        rows.append(
            {
                "set": name, "delta": delta, "eta": eta,
                "samples": int(touching.sum()),
                "deviation": float(np.abs(run["gap"].values[touching]).max()),
                "least_force": float(normal.min() / normal.max()),
            }
        )  # fmt: skip
    return {"rows": rows}


def _normal_force(run: xr.Dataset, delta: float) -> np.ndarray:
    """Force with which springs and dampers press the ring on the rotor, by Eqs. (55)-(59)."""
    values = [run[name].values for name in ("sx", "sy", "ring_vx", "ring_vy")]
    data = {"k_s": 30.0, "c_s": 2.0 * 0.002, "delta_x": delta, "delta_y": delta}
    force_x, force_y = force_of_springs(*values, **data)
    apart_x, apart_y = (run[a].values - run[b].values for a, b in (("x", "sx"), ("y", "sy")))
    return force_x * apart_x + force_y * apart_y


def _judge_kept(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    worst = max(row["deviation"] for row in rows)
    count = sum(row["samples"] for row in rows)
    least = min(row["least_force"] for row in rows)
    return Finding(
        worst <= _CLOSED and least >= -_CLOSED,
        f"the model sets D = gamma in contact (largest difference over {count} samples"
        f" {worst:.1e} gaps, rounding), and that is right while springs and dampers press the ring"
        f" on the rotor: the least force between them by Eqs. (55)-(59) is {least:.2g} of the"
        " largest",
    )


def _free_ring(delta: float = 0.1, k_s: float = 30.0, c_s: float = 0.004) -> Evidence:
    rows = []
    for name, s, preload in (
        ("no preload", 0.2, 0.0), ("within the preload", 0.5 * delta, delta),
        ("beyond the preload", 2.0 * delta, delta),
    ):  # fmt: skip
        options = {"k_s": k_s, "c_s": c_s, "delta_x": preload, "delta_y": preload}
        # the resultant is linear in the rate, and zero on a ring that is free
        at_rest, moving = (
            float(force_of_springs(s, 0.0, v, 0.0, **options)[0]) for v in (0.0, 1.0)
        )
        rows.append(
            {
                "case": name,
                "rate_of_springs": -at_rest / (moving - at_rest),
                "rate_printed": -k_s * s / c_s,
            }
        )
    return {"delta": delta, "rows": rows}


def _judge_free_ring(evidence: Evidence) -> Finding:
    ratios = [row["rate_of_springs"] / row["rate_printed"] for row in evidence["rows"]]
    listed = ", ".join(
        f"{row['case']} {ratio:.3g}" for row, ratio in zip(evidence["rows"], ratios, strict=True)
    )
    text = (
        f"rate of return by the one-sided springs (55)-(58) over that of Eq. (52): {listed};"
        " beyond the preload only one spring acts, with its preload, and |s| + Delta decays"
    )
    return Finding(all(abs(ratio - 1.0) < _CLOSED for ratio in ratios), text)


def _work(motions: Sequence[tuple[str, float, float]] = _MOTIONS, periods: int = 24) -> Evidence:
    rows = []
    for name, delta, eta in motions:
        run = ring_run(_system(name, delta, eta), transient=300, periods=periods, samples=1000)
        power = (run["force_x"] * run["ring_vx"] + run["force_y"] * run["ring_vy"]).values
        time, energy = run["time"].values, run["energy"].values
        done = float(np.sum(0.5 * (power[1:] + power[:-1]) * np.diff(time)))
        stored = float(np.diff(energy).clip(min=0.0).sum())
        lost = done - float(energy[-1] - energy[0])
        rows.append({"set": name, "delta": delta, "eta": eta, "ratio": lost / stored})
    return {"periods": periods, "rows": rows}


def _judge_work(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    worst = max(row["ratio"] for row in rows)
    listed = ", ".join(f"{_named(row)}: {row['ratio']:.2%}" for row in rows)
    true = None if _SMALL < worst <= _LARGE else worst <= _SMALL
    return Finding(true, f"work of the ring's dampers over that of its springs: {listed}")


CHECKS = (
    Check("R11", "six motions of sets A and B from zero, 300 periods dropped, 20 kept: contact"
          " beside R, at the positions that the ring has", _distance, _judge_distance),
    Check("R12", "six motions of sets A and B from zero, 300 periods dropped, 20 kept; true where"
          " the ring is pressed on the rotor throughout contact", _kept, _judge_kept),
    Check("R13", "rate of the ring on which no resultant acts, Delta .1, at half and at twice the"
          " preload, and without preload", _free_ring, _judge_free_ring),
    Check("R14", "six motions from zero, 300 periods dropped, 24 kept; negligible: 2 % at most, no"
          " longer above 10 %; the chapter names no measure", _work, _judge_work),
)  # fmt: skip
