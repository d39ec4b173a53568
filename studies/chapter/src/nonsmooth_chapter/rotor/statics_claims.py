"""Claims on where the ring stands: regimes, boundaries, Tables 4-6, the release condition."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth.models import snubber_ring
from nonsmooth_chapter.judgement import Check, Evidence, Finding
from nonsmooth_chapter.rotor.ring_tables import (
    REGIME_OF_ROW,
    boundary_curve,
    energy_by_work,
    force_of_springs,
    table_4,
    table_5,
    table_6,
)

__all__ = ["CHECKS"]

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


CHECKS = (
    Check(
        "R05",
        "positions on a grid of 61 x 61 over 4 x 4 gaps, Delta .1, .05 and (.1, .05); the energy of"
        " Eq. (60) is searched all round the constraint and compared with the closed forms, farther"
        " than 1e-3 from a boundary",
        _regimes,
        _judge_regimes,
    ),
    Check(
        "R06",
        "200 points of each printed curve in the first quadrant, regimes 1e-6 on either side, for"
        " the same preloads; each curve on its own side of the corner",
        _curves,
        _judge_curves,
    ),
    Check("R07", "2000 random ring positions and velocities per row, Delta (.1, .07)", _table_four,
          _judge_table),
    Check("R08", "2000 random ring positions per row, Delta (.1, .07), against the work of Eq. (60)"
          " and the gradient against Table 4", _table_five,
          lambda evidence: _judge_printed(evidence, "of the energy")),
    Check("R09", "20,000 random rotor positions, Delta (.1, .07), against the ring of least energy",
          _table_six, lambda evidence: _judge_printed(evidence, "of the position")),
    Check("R10", "200,000 random pairs of directions of n and F_s", _release, _judge_release),
)  # fmt: skip
