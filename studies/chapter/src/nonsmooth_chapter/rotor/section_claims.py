"""Claims on the sections of Fig. 37 and on settling: regimes, coexistence, shape of attractors."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from nonsmooth import bifurcation_diagram, correlation_dimension, regime, stroboscopic_map
from nonsmooth_chapter.judgement import Check, Evidence, Finding
from nonsmooth_chapter.rotor.coexistence import STARTS, coexisting
from nonsmooth_chapter.rotor.data import set_a
from nonsmooth_chapter.rotor.sections import PANELS
from nonsmooth_chapter.rotor.speed_sweeps import even_values

__all__ = ["CHECKS"]

_EXCHANGED = {"a": 2.181, "b": 2.223}
_APART = 3.0  # distance of two attractors beside that of two samples of one
_SETTLED = 1e-3  # of the displacement: less than a point of the picture


def _motion(delta: float, eta: float) -> Evidence:
    found = regime(set_a(delta, eta), transient=1000)
    length = float(set_a(delta, eta).period_value or 0.0)
    row: Evidence = {
        "delta": delta,
        "eta": eta,
        "regime": found["regime"].item(),
        "period": int(found["period"]),
        "message": found.attrs["message"],
        "others": [
            {name: each[name] for name in ("period", "share", "from_zero")}
            for each in coexisting(set_a(delta, eta))
        ],
    }
    if not row["period"]:
        row |= {
            "exponent": float(found["exponent"]) * length,
            "error": float(found["exponent_error"]) * length,
        }
    return row


def _panel(panel: str) -> Evidence:
    delta, eta = PANELS[panel]
    rows = [_motion(delta, eta)]
    if panel in _EXCHANGED:
        rows.append(_motion(delta, _EXCHANGED[panel]))
    return {"panel": panel, "rows": rows}


def _text(evidence: Evidence) -> str:
    parts = []
    for row in evidence["rows"]:
        others = ", ".join(
            f"{'period ' + str(each['period']) if each['period'] else 'no period'}"
            f" ({each['share']:.0%})"
            for each in row["others"]
        )
        part = f"eta {row['eta']:g}: {row['regime']}"
        part += f", period {row['period']}" if row["period"] else ""
        if "exponent" in row:
            part += f", exponent per period {row['exponent']:.3f} +- {row['error']:.3f}"
        parts.append(f"{part} from zero; {STARTS + 1} starts lead to {others}")
    tail = "; the second eta is that printed for the other panel" if len(parts) > 1 else ""
    return f"Delta {evidence['rows'][0]['delta']:g}: " + "; ".join(parts) + tail


def _judge_three(evidence: Evidence) -> Finding:
    return Finding(evidence["rows"][0]["period"] == 3, _text(evidence))


def _judge_quasi(evidence: Evidence) -> Finding:
    return Finding(evidence["rows"][0]["regime"] == "quasi-periodic", _text(evidence))


def _judge_chaos(evidence: Evidence) -> Finding:
    row = evidence["rows"][0]
    chaos = row["regime"] == "chaotic" and row["exponent"] > 3.0 * row["error"]
    return Finding(bool(chaos), _text(evidence))


def _structure(eta: float = 2.442, record: int = 6000) -> Evidence:
    """Distances between two samples of each attractor, and between the attractors."""
    clouds, dimensions = {}, []
    for delta in (0.0, 0.1):
        found = stroboscopic_map(set_a(delta, eta), transient=1000, record=2 * record)
        points = np.stack([found[name].values for name in ("x", "y", "vx", "vy")], axis=1)
        clouds[delta] = (points[:record], points[record:])
        fit = correlation_dimension(found, states=["x", "y", "vx", "vy"])
        dimensions.append([float(fit["correlation_dimension"]), float(fit["standard_error"])])
    size = float(np.ptp(clouds[0.0][0], axis=0).max())
    own = [_mean_distance(*pair) / size for pair in clouds.values()]
    across = _mean_distance(clouds[0.0][0], clouds[0.1][0]) / size
    return {"eta": eta, "own": own, "across": across, "dimensions": dimensions}


def _mean_distance(one: np.ndarray, other: np.ndarray) -> float:
    """Mean distance from points of each set to the nearest of the other, the larger of the two."""
    ways = ((one, other), (other, one))
    return max(float(cKDTree(b).query(a)[0].mean()) for a, b in ways)


def _judge_structure(evidence: Evidence) -> Finding:
    own, across = max(evidence["own"]), evidence["across"]
    dimensions = ", ".join(f"{d:.2f} +- {error:.2f}" for d, error in evidence["dimensions"])
    text = (
        f"mean distance between the attractors {across:.2%} of their size, between two samples of"
        f" one {own:.2%} at most; correlation dimensions without and with preload {dimensions};"
        f" changed means {_APART:g} times as far apart"
    )
    return Finding(bool(across > _APART * own), text)


def _settling(
    columns: int = 100, dropped: int = 300, record: int = 150, later: int = 2500
) -> Evidence:
    """Which periodic columns still move, or have not found their motion, after the transient."""
    rows = []
    for delta in (0.0, 0.1):
        etas = even_values(2.0, 5.0, columns)
        first, last = (
            bifurcation_diagram(set_a(delta), "eta", etas, transient=n, record=record).isel(lane=0)
            for n in (dropped, later)
        )
        periodic = last["period"].values > 0
        early, late = first["x"].values[periodic], last["x"].values[periodic]
        apart = np.array(
            [np.abs(a[:, None] - b).min(axis=1).max() for a, b in zip(early, late, strict=True)]
        )
        rows.append(
            {
                "delta": delta,
                "columns": len(etas),
                "periodic": int(periodic.sum()),
                "unsettled": int(np.sum(apart > _SETTLED)),
                "worst": float(apart.max()),
                "where": last["parameter"].values[periodic][apart > _SETTLED].tolist(),
            }
        )
    return {"dropped": dropped, "later": later, "rows": rows}


def _judge_settling(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    listed = "; ".join(
        f"Delta {row['delta']:g}: {row['unsettled']} of {row['columns']} columns"
        f" ({row['periodic']} periodic in the end) show points off their final motion, by up to"
        f" {row['worst']:.2g}" + (f", at eta {', '.join(f'{e:.3g}' for e in row['where'])}"
                                  if row["where"] else "")
        for row in rows
    )  # fmt: skip
    return Finding(all(not row["unsettled"] for row in rows), listed)


CHECKS = (
    Check(
        "R15",
        "set A, 101 columns from zero, Delta 0 and .1; points in periods 300 to 450 against the"
        f" periodic motion after 2500, farther than {_SETTLED:g} gaps counts; columns without a"
        " period in the end are left out",
        _settling,
        _judge_settling,
    ),
    Check("R27", f"regime from zero, 1000 periods dropped; {STARTS} random starts beside it; the"
          " same at the eta printed for (b)", lambda: _panel("a"), _judge_three),
    Check("R28", "the same, and at the eta printed for (a)", lambda: _panel("b"), _judge_quasi),
    Check("R30", "regime from zero, 1000 periods dropped; exponent above 3 standard errors, and the"
          " 0-1 test", lambda: _panel("c"), _judge_chaos),
    Check("R31", "the same", lambda: _panel("d"), _judge_chaos),
    Check("R32", "6000 strobes of each from zero, 1000 periods dropped, in x, y, vx, vy; distance"
          " between the sets against that of two samples of one", _structure, _judge_structure),
)  # fmt: skip
