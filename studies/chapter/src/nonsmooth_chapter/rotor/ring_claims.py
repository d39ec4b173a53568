"""Claims on the ring: statics, contact, and its motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from nonsmooth import System
from nonsmooth.models import snubber_ring
from nonsmooth_chapter.judgement import Evidence, Finding
from nonsmooth_chapter.rotor.motions import set_a, set_b
from nonsmooth_chapter.rotor.ring import PANELS, in_contact, panel_system, ring_jumps, ring_run
from nonsmooth_chapter.rotor.ring_tables import (
    REGIME_OF_ROW,
    boundary_curve,
    energy_by_work,
    force_of_springs,
    table_4,
    table_5,
    table_6,
)

# Claims on where the ring stands: regimes, boundaries, Tables 4-6, the release condition.

_PRELOADS = ((0.1, 0.1), (0.05, 0.05), (0.1, 0.05))
_ROUNDING = 1e-12
_NEAR = 1e-3  # displacement from a preload, within which a minimised regime is not compared
_NAMES = ("I", "II", "III", "IV", "V")


def _minimised(x: np.ndarray, y: np.ndarray, dx: float, dy: float) -> tuple[np.ndarray, ...]:
    """Ring positions of least energy on |r - s| = 1 by search, and the number of local minima."""
    angle = np.linspace(-np.pi, np.pi, 720, endpoint=False)

    def energy(turn: np.ndarray) -> np.ndarray:
        sx, sy = x[:, None] - np.cos(turn), y[:, None] - np.sin(turn)
        return energy_by_work(sx, sy, delta_x=dx, delta_y=dy)

    all_round = energy(np.broadcast_to(angle, (x.size, angle.size)))
    lowest = (all_round < np.roll(all_round, 1, 1)) & (all_round < np.roll(all_round, -1, 1))
    best, width = angle[all_round.argmin(axis=1)], angle[1] - angle[0]
    for _ in range(12):
        around = best[:, None] + width * np.linspace(-1.0, 1.0, 21)
        best = np.take_along_axis(around, energy(around).argmin(axis=1)[:, None], 1)[:, 0]
        width *= 0.15
    return x - np.cos(best), y - np.sin(best), lowest.sum(axis=1)


def _regimes(preloads: Sequence[tuple[float, float]] = _PRELOADS, side: int = 61) -> Evidence:
    axis = np.linspace(-2.0, 2.0, side) + 1e-3
    x, y = (part.ravel() for part in np.meshgrid(axis, axis))
    rows = []
    for dx, dy in preloads:
        ring = snubber_ring(x, y, delta_x=dx, delta_y=dy)
        regime = ring["regime"].values
        out = regime > 1
        sx, sy, minima = _minimised(x[out], y[out], dx, dy)
        found = 2 + (np.abs(sx) > dx) + 2 * (np.abs(sy) > dy)
        clear = np.minimum(np.abs(np.abs(sx) - dx), np.abs(np.abs(sy) - dy)) > _NEAR
        apart = np.hypot(sx - ring["sx"].values[out], sy - ring["sy"].values[out])
        rows.append(
            {
                "delta": [dx, dy],
                "positions": int(x.size),
                "several_minima": int(np.sum(minima > 1)),
                "other_regime": int(np.sum(found[clear] != regime[out][clear])),
                "distance": float(apart.max()),
                "present": [_NAMES[k - 1] for k in np.unique(regime)],
            }
        )
    return {"rows": rows}


def _judge_regimes(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    true = all(
        row["present"] == list(_NAMES) and not row["several_minima"] and not row["other_regime"]
        for row in rows
    )
    listed = "; ".join(
        f"Delta ({row['delta'][0]:g}, {row['delta'][1]:g}): regimes {' '.join(row['present'])},"
        f" {row['several_minima']} positions with a second minimum, {row['other_regime']} in"
        f" another regime, ring within {row['distance']:.0e} of the closed forms"
        for row in rows
    )
    return Finding(true, f"{rows[0]['positions']} positions each; {listed}")


def _curves(
    preloads: Sequence[tuple[float, float]] = _PRELOADS, points: int = 200, offset: float = 1e-6
) -> Evidence:
    rows = []
    for dx, dy in preloads:
        corner = 1.0 + 1.0 / np.hypot(dx, dy)
        # coordinate of each curve up to the corner, and the pieces beyond it
        spans = {
            62: ((0.0, 1.0), None, "I", "II"),
            63: ((dx * corner, 1.0 + dx), (dx * 1.05, dx * corner), "II", "III"),
            64: ((dy * corner, 1.0 + dy), (dy * 1.05, dy * corner), "II", "IV"),
            65: ((dy * 1.2, dy * corner), (dy * corner, 1.0 + dy), "III", "V"),
            66: ((dx * 1.2, dx * corner), (dx * corner, 1.0 + dx), "IV", "V"),
        }
        for number, (valid, beyond, inner, outer) in spans.items():
            shares = [
                None if span is None
                else _share(number, span, inner, outer, dx, dy, points, offset)
                for span in (valid, beyond)
            ]  # fmt: skip
            rows.append(
                {"delta": [dx, dy], "equation": number, "valid": shares[0], "beyond": shares[1]}
            )
    return {"rows": rows}


def _share(
    number: int, span: tuple[float, float], inner: str, outer: str, dx: float, dy: float,
    points: int, offset: float,
) -> float:  # fmt: skip
    """Part of a curve with the named regimes just on either side, along the given coordinate."""
    given = span[0] + (span[1] - span[0]) * (np.arange(points) + 0.5) / points
    other = boundary_curve(number, given, delta_x=dx, delta_y=dy)
    sides = []
    for sign, name in ((-1.0, inner), (1.0, outer)):
        moved = given + sign * offset
        x, y = (moved, other) if number in (62, 63, 66) else (other, moved)
        ok = np.isfinite(other) & (other >= 0.0)
        regime = snubber_ring(x[ok], y[ok], delta_x=dx, delta_y=dy)["regime"].values
        sides.append(np.where(ok, False, False))
        sides[-1][ok] = regime == _NAMES.index(name) + 1
    return float(np.mean(sides[0] & sides[1]))


def _judge_curves(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    wrong = [row for row in rows if row["valid"] < 1.0]
    beyond = {row["beyond"] for row in rows if row["beyond"] is not None}
    text = (
        f"{len(rows) - len(wrong)} of {len(rows)} curves separate the regimes that the chapter"
        " names at every point of their piece, up to the corner r = Delta(1 + gamma/|Delta|) where"
        f" all four meet; beyond it {max(beyond):.0%} of their points do"
    )
    return Finding(not wrong, text)


def _random_ring(count: int, delta: tuple[float, float], row: int) -> tuple[np.ndarray, ...]:
    random = np.random.default_rng(row)
    inside_x, inside_y = (REGIME_OF_ROW[row] in names for names in (("II", "IV"), ("II", "III")))
    parts = []
    for inside, limit in ((inside_x, delta[0]), (inside_y, delta[1])):
        size = random.uniform(0.0, limit, count) if inside else random.uniform(limit, 1.0, count)
        parts.append(size * random.choice((-1.0, 1.0), count))
    return (*parts, *random.uniform(-1.0, 1.0, (2, count)))


def _table_four(
    delta: tuple[float, float] = (0.1, 0.07), count: int = 2000, c_s: float = 0.3
) -> Evidence:
    rows = []
    for row in REGIME_OF_ROW:
        sx, sy, vx, vy = _random_ring(count, delta, row)
        options = {"c_s": c_s, "delta_x": delta[0], "delta_y": delta[1]}
        of_table = table_4(row, sx, sy, vx, vy, **options)
        of_springs = force_of_springs(sx, sy, vx, vy, **options)
        apart = max(np.abs(a - b).max() for a, b in zip(of_table, of_springs, strict=True))
        rows.append({"row": row, "difference": float(apart)})
    return {"delta": list(delta), "rows": rows}


def _table_five(delta: tuple[float, float] = (0.1, 0.07), count: int = 2000) -> Evidence:
    rows, step = [], 1e-6
    options = {"delta_x": delta[0], "delta_y": delta[1]}
    for row in REGIME_OF_ROW:
        sx, sy, *_ = _random_ring(count, delta, row)
        work = energy_by_work(sx, sy, **options)
        force = table_4(row, sx, sy, **options)
        found: Evidence = {"row": row}
        for name, printed in (("printed", True), ("corrected", False)):
            energy = table_5(row, sx, sy, printed=printed, **options)
            slope = [
                (table_5(row, sx + hx, sy + hy, printed=printed, **options)
                 - table_5(row, sx - hx, sy - hy, printed=printed, **options)) / (2.0 * step)
                for hx, hy in ((step, 0.0), (0.0, step))
            ]  # fmt: skip
            found[name] = float(np.abs(energy - work).max())
            found[f"{name}_gradient"] = float(
                max(np.abs(a - b).max() for a, b in zip(slope, force, strict=True))
            )
        rows.append(found)
    return {"delta": list(delta), "rows": rows}


def _table_six(delta: tuple[float, float] = (0.1, 0.07), count: int = 20000) -> Evidence:
    random = np.random.default_rng(0)
    x, y = random.uniform(-2.0, 2.0, (2, count))
    options = {"delta_x": delta[0], "delta_y": delta[1]}
    ring = snubber_ring(x, y, **options)
    rows = []
    for row, regime in REGIME_OF_ROW.items():
        here = ring["regime"].values == _NAMES.index(regime) + 1
        true = [ring[name].values[here] for name in ("sx", "sy")]
        found: Evidence = {"row": row, "positions": int(here.sum())}
        for name, printed in (("printed", True), ("corrected", False)):
            place = table_6(row, x[here], y[here], printed=printed, **options)
            apart = np.max([np.abs(a - b) for a, b in zip(place, true, strict=True)], axis=0)
            found[f"{name}_without_root"] = int(np.isnan(apart).sum())
            found[name] = float(np.nanmax(apart)) if np.isfinite(apart).any() else None
        rows.append(found)
    return {"delta": list(delta), "rows": rows}


def _judge_table(evidence: Evidence) -> Finding:
    return Finding(
        all(row["difference"] <= _ROUNDING for row in evidence["rows"]),
        "largest difference of the force from Eqs. (55)-(59) by row: "
        + ", ".join(f"{row['row']}: {row['difference']:.1g}" for row in evidence["rows"]),
    )


def _judge_printed(evidence: Evidence, what: str) -> Finding:
    rows = evidence["rows"]

    def wrong(row: Evidence) -> bool:
        missing = row.get("printed_without_root", 0) or row["printed"] is None
        return bool(missing or row["printed"] > 1e-9)

    def shown(value: float | None) -> str:
        return "no root" if value is None else f"{value:.2g}"

    listed = ", ".join(
        f"row {row['row']} {shown(row['printed'])} (corrected {shown(row['corrected'])})"
        for row in rows
    )
    bad = [str(row["row"]) for row in rows if wrong(row)]
    return Finding(not bad, f"largest difference {what}: {listed}; wrong rows: {', '.join(bad)}")


def _release(count: int = 200_000) -> Evidence:
    random = np.random.default_rng(0)
    normal, force = random.uniform(-np.pi, np.pi, (2, count))
    projected = np.cos(normal - force) <= 0.0
    psi = np.arccos(np.cos(normal))
    phi = np.arctan(np.sin(force) / np.cos(force))
    printed = np.cos(phi - psi) <= 0.0
    quadrant = (np.sin(normal) < 0.0).astype(int) * 2 + (np.cos(normal) < 0.0)
    names = ("x > 0, y > 0", "x < 0, y > 0", "x > 0, y < 0", "x < 0, y < 0")
    differ = projected != printed
    aligned = np.cos(normal - force) > np.cos(0.2)  # as with little damping
    return {
        "directions": count,
        "share": float(differ.mean()),
        "share_by_quadrant_of_n": {
            name: float(differ[quadrant == k].mean()) for k, name in enumerate(names)
        },
        "share_near_the_normal": {
            name: float(differ[aligned & (quadrant == k)].mean()) for k, name in enumerate(names)
        },
    }


def _judge_release(evidence: Evidence) -> Finding:
    near = ", ".join(f"{k}: {v:.0%}" for k, v in evidence["share_near_the_normal"].items())
    text = (
        f"the two forms differ for {evidence['share']:.0%} of {evidence['directions']} pairs of"
        f" directions; for forces within 0.2 rad of n, by quadrant of n, {near}"
    )
    return Finding(evidence["share"] == 0.0, text)


# Claims on contact with the ring: when it begins, what it keeps, how the free ring returns.

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


# Claims on the motion of the ring, Fig. 38: where its velocity jumps, how far it goes.

_HERE = 1e-3  # of the gap: a ring within it of a place is there
_JUMPS = 1e-4  # of the velocity's range, above which it jumps


def _panel(panel: str, periods: int = 24) -> Evidence:
    run = ring_run(panel_system(panel), periods=periods)
    name, delta, eta = PANELS[panel]
    reach = float(np.ptp(run["ring_vx"].values))
    jumps = ring_jumps(run)
    big = [row for row in jumps if abs(row["jump"]) > _JUMPS * reach]
    at_zero = [row for row in big if abs(row["sx"]) <= _HERE]
    beyond = [row for row in big if delta and abs(abs(row["sx"]) - delta) <= _HERE]
    crossed = [
        row for row in jumps if row["name"] == "spring" and abs(abs(row["sx"]) - delta) <= _HERE
    ]
    return {
        "panel": panel, "set": name, "delta": delta, "eta": eta, "range": reach,
        "hits": sum(row["name"] == "contact" for row in jumps),
        "hits_with_jump": sum(row["name"] == "contact" for row in at_zero),
        "at_zero": len(at_zero), "at_preload": len(beyond), "crossings_of_preload": len(crossed),
        "elsewhere": len(big) - len(at_zero) - len(beyond),
        "largest_at_zero": max((abs(row["jump"]) for row in at_zero), default=0.0),
        "largest_at_preload": max((abs(row["jump"]) for row in beyond), default=0.0),
        "extreme": float(np.abs(run["sx"].values).max()),
        "begun_anew": int(run.attrs["begun_anew"]),
    }  # fmt: skip


def _panels(letters: str) -> Evidence:
    return {"rows": [_panel(letter) for letter in letters]}


def _text(row: Evidence) -> str:
    return (
        f"({row['panel']}) set {row['set']}, Delta {row['delta']:g}: {row['hits_with_jump']} of"
        f" {row['hits']} hits with a jump at x_s = 0 (up to {row['largest_at_zero']:.3g}),"
        f" {row['at_preload']} jumps at |x_s| = Delta_x in {row['crossings_of_preload']} crossings"
        f" (up to {row['largest_at_preload']:.3g}), {row['elsewhere']} elsewhere"
    )


def _judge_zero(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    true = all(row["hits"] and row["hits_with_jump"] == row["hits"] for row in rows)
    return Finding(bool(true), "; ".join(_text(row) for row in rows))


def _judge_preload(evidence: Evidence) -> Finding:
    (row,) = evidence["rows"]
    true = row["crossings_of_preload"] and row["at_preload"] == row["crossings_of_preload"]
    return Finding(bool(true), _text(row))


def _judge_amplitude(evidence: Evidence) -> Finding:
    without, loaded = (row["extreme"] for row in evidence["rows"])
    return Finding(
        loaded < without, f"largest |x_s| {without:.4f} without and {loaded:.4f} with preload"
    )
