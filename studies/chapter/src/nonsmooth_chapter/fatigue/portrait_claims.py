"""Claims on the phase portraits of Fig. 28, for which the chapter gives no parameters.

The caption prints a mean load of zero, so at rest the specimen is straight and d = 0. The
convention is the set of Fig. 29 with s = 1, from rest, and the open stiffness of Eq. (48), which
section 3.5 gives; the cubic law of Fig. 29 stands beside it. The claims are looked at over a range
of damping, frequency and s as well, with both laws, to show what depends on them.

At d = 0 every periodic motion passes the switch. Were u of one sign throughout, the equation would
be linear, u'' + 2 xi u' + k u = eta^2 sin(eta tau) with one k > 0. Its mean over a period is
k <u> = 0, and a u of one sign with mean zero is zero, which the forcing excludes.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from typing import Literal

import numpy as np
from scipy.spatial import cKDTree

from nonsmooth import ensemble
from nonsmooth.fatigue import Specimen, cubic_stiffness
from nonsmooth_chapter.fatigue.beam_data import K_CLOSED, S_RANGE, WIDTH
from nonsmooth_chapter.fatigue.crack_motions import period_of
from nonsmooth_chapter.fatigue.portraits import (
    LAWS,
    RATIOS,
    closed_arcs,
    portrait_beam,
    settled_orbit,
)
from nonsmooth_chapter.judgement import Check, Evidence, Finding

__all__ = ["CHECKS", "arc_distance", "orbits_of_convention", "scan_of_orbits"]

STATED = "guinea"
_XI, _ETA = (0.005, 0.014, 0.05), (0.8, 1.1475, 1.6)
_S = tuple(np.geomspace(*S_RANGE, 9).round(6).tolist())
_DROPPED, _PERIODS, _SAMPLES = 1500, 8, 128  # of a scan, samples per period
_SAME_PATH = 0.05  # of the size of the closed arcs
_VISIBLE = 0.1  # change of slope of the restoring force


def arc_distance(arcs: list[np.ndarray]) -> float:
    """Largest distance between two arcs of a set, beside the size of all of them.

    Parameters
    ----------
    arcs : list of numpy.ndarray
        Points of each arc, not empty.

    Returns
    -------
    float
        Of each pair the largest distance from a point of the arc with the smaller reach to the
        other one, so that an arc which ends earlier on the same path has none.

    Examples
    --------
    >>> import numpy as np
    >>> line = np.stack([np.linspace(-1, 0, 50), np.zeros(50)], axis=1)
    >>> arc_distance([line, line[25:]])
    0.0
    """
    size = np.ptp(np.concatenate(arcs), axis=0)
    scaled = [arc / np.where(size > 0.0, size, 1.0) for arc in arcs]
    worst = 0.0
    for k, one in enumerate(scaled):
        for other in scaled[:k]:
            ways = [cKDTree(b).query(a)[0].max() for a, b in ((one, other), (other, one))]
            worst = max(worst, float(min(ways)))
    return worst


@lru_cache(maxsize=2)
def orbits_of_convention() -> Evidence:
    """Orbits at the four ratios by both laws, s = 1, d = 0, from rest.

    Returns
    -------
    dict
        For each law ``rows`` with ``ratio``, ``period``, ``amplitude``, ``slopes`` (restoring
        stiffness closed over open) and whether it ``crosses``; and the ``distance`` of closed arcs.
    """
    found: Evidence = {}
    for law in LAWS:
        rows, arcs = [], []
        for ratio in RATIOS:
            orbit = settled_orbit(portrait_beam(ratio, law))
            u = orbit["u"].values
            force = (orbit["load"].values + u)[np.abs(u).argsort()]
            stiffness = force / np.sort(np.abs(u)) * np.sign(u[np.abs(u).argsort()])
            arcs.append(closed_arcs(orbit))
            rows.append(
                {
                    "ratio": ratio,
                    "period": int(orbit.attrs["period_of_motion"]),
                    "amplitude": float(np.ptp(u) / 2.0),
                    "slopes": float(np.nanmax(stiffness) / np.nanmin(stiffness)),
                    "crosses": bool(u.min() < 0.0 < u.max()),
                }
            )
        found[law] = {"rows": rows, "distance": arc_distance(arcs)}
    return found


@lru_cache(maxsize=2)
def scan_of_orbits() -> Evidence:
    """The four orbits by both laws over the range of what the chapter lacks.

    Returns
    -------
    dict
        ``cases``, and how many of them have period one at all ratios (``period_one``), amplitudes
        that grow (``growing``), closed arcs on one path (``one_path``), orbits that pass the
        switch at all ratios (``crossing``) with a visible change of slope (``visible``); the least
        ``distance`` of arcs where all orbits pass it, and the least change of slope, ``slope``.
    """
    counts = dict.fromkeys(("period_one", "growing", "one_path", "crossing", "visible"), 0)
    cases, least, slope = 0, np.inf, np.inf
    for eta, law in product(_ETA, LAWS):
        for motions, ratios in _cases(eta, law):
            cases += 1
            counts["period_one"] += all(_period_one(orbit) for orbit in motions)
            sizes = [float(np.ptp(orbit[:, 0])) for orbit in motions]
            counts["growing"] += bool(np.all(np.diff(sizes) > 0.0))
            slope = min(slope, *ratios)
            if all(orbit[:, 0].min() < 0.0 < orbit[:, 0].max() for orbit in motions):
                distance = arc_distance([orbit[orbit[:, 0] <= 0.0] for orbit in motions])
                least = min(least, distance)
                counts["one_path"] += bool(distance <= _SAME_PATH)
                counts["crossing"] += 1
                counts["visible"] += bool(min(ratios) - 1.0 >= _VISIBLE)
    return {"cases": cases, **counts, "distance": float(least), "slope": float(slope)}


def _cases(eta: float, law: Literal["cubic", "guinea"]) -> list[tuple[np.ndarray, list[float]]]:
    """Orbits of the four ratios, one array each, and the ratios of slopes."""
    system = portrait_beam(RATIOS[0], law, eta=eta)
    length = 2.0 * np.pi / eta
    times = length * (_DROPPED + np.arange(_PERIODS * _SAMPLES) / _SAMPLES)
    cracks = [round(ratio * WIDTH, 9) for ratio in RATIOS]
    runs = ensemble(
        system, {"u": 0.0, "v": 0.0}, times=times,
        parameters={"xi": list(_XI), "s": list(_S), "crack": cracks},
    )  # fmt: skip
    points = np.stack([runs["u"].values, runs["v"].values], axis=-1)
    groups = points.reshape(-1, len(RATIOS), *points.shape[1:])
    scales = runs["s"].values.reshape(-1, len(RATIOS))[:, 0]
    parts = [_open_part(law, crack) for crack in cracks]
    slopes = [[(1.0 + s * K_CLOSED) / (1.0 + s * K_CLOSED * p) for p in parts] for s in scales]
    return list(zip(groups, slopes, strict=True))


def _open_part(law: str, crack: float) -> float:
    """Open stiffness beside the closed one."""
    if law == "cubic":
        return float(cubic_stiffness(crack)) / K_CLOSED
    return float(Specimen().stiffness(crack) / Specimen().closed_stiffness)


def _period_one(orbit: np.ndarray) -> bool:
    return period_of(orbit[::_SAMPLES], 3) == 1


def _evidence() -> Evidence:
    return {"convention": orbits_of_convention(), "scan": scan_of_orbits()}


def _rows(evidence: Evidence, name: str, form: str) -> str:
    return "; ".join(
        f"{law}: " + ", ".join(f"{row['ratio']:g} {row[name]:{form}}" for row in part["rows"])
        for law, part in evidence["convention"].items()
    )


def _judge_period(evidence: Evidence) -> Finding:
    scan = evidence["scan"]
    return Finding(
        all(row["period"] == 1 for row in evidence["convention"][STATED]["rows"]),
        f"periods at the four ratios, {_rows(evidence, 'period', 'd')}; period one at all ratios in"
        f" {scan['period_one']} of {scan['cases']} cases",
    )


def _judge_amplitude(evidence: Evidence) -> Finding:
    scan = evidence["scan"]
    sizes = [row["amplitude"] for row in evidence["convention"][STATED]["rows"]]
    return Finding(
        bool(np.all(np.diff(sizes) > 0.0)),
        f"half of the range of u, {_rows(evidence, 'amplitude', '.3f')}; growing in"
        f" {scan['growing']} of {scan['cases']} cases",
    )


def _judge_path(evidence: Evidence) -> Finding:
    listed = ", ".join(
        f"{law} {part['distance']:.1%}" for law, part in evidence["convention"].items()
    )
    scan = evidence["scan"]
    stated = evidence["convention"][STATED]["distance"] <= _SAME_PATH
    everywhere = scan["one_path"] == (scan["cases"] if stated else 0)
    return Finding(
        stated,
        f"largest distance between closed arcs beside their size: {listed}; one path"
        f" ({_SAME_PATH:.0%}) in {scan['one_path']} of {scan['cases']} cases, least"
        f" {scan['distance']:.1%}",
        for_all=f"the {scan['cases']} cases of the scan" if everywhere else "",
    )


def _judge_slope(evidence: Evidence) -> Finding:
    rows, scan = evidence["convention"][STATED]["rows"], evidence["scan"]
    passes = all(row["crosses"] for row in rows) and scan["crossing"] == scan["cases"]
    true = passes and scan["slope"] - 1.0 >= _VISIBLE
    return Finding(
        true,
        f"at zero mean load every periodic motion passes the switch, as the mean of a linear"
        f" equation would be u = 0 (seen in {scan['crossing']} of {scan['cases']} cases);"
        f" restoring stiffness closed over open, {_rows(evidence, 'slopes', '.3g')}; at least"
        f" {scan['slope']:.3f} over the range, visible ({1.0 + _VISIBLE:g}) in {scan['visible']}",
        for_all=f"every damping and frequency, s from {S_RANGE[0]:g} to {S_RANGE[1]:g}, both laws"
        if true
        else "",
    )


_PROTOCOL = (
    "d = 0, as the caption prints zero mean load; xi .014, eta 1.1475, s = 1, from rest, 2000"
    " periods dropped, both stiffness laws (Eq. (48) decides); scan over both laws, xi"
    f" {_XI[0]:g} to {_XI[-1]:g}, eta {_ETA[0]:g} to {_ETA[-1]:g}, s {S_RANGE[0]:g} to"
    f" {S_RANGE[1]:g}: {len(_XI)} by {len(_ETA)} by {len(_S)} values, {_DROPPED} periods dropped"
)

CHECKS = (
    Check("F36", _PROTOCOL, _evidence, _judge_period),
    Check("F37", _PROTOCOL + "; amplitude: half of the range of u", _evidence, _judge_amplitude),
    Check("F38", _PROTOCOL + "; largest distance between two arcs with u < 0 in the (u, v) plane,"
          f" each scaled to the size of all; one path: {_SAME_PATH:.0%}", _evidence, _judge_path),
    Check("F39", _PROTOCOL + "; (1 + kappa_closed) / (1 + kappa_open) where an orbit has both;"
          f" visible: {1.0 + _VISIBLE:g}", _evidence, _judge_slope),
)  # fmt: skip
