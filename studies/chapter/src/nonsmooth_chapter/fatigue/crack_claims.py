"""Claims on a crack of fixed length: stiffness, phase portraits, regimes."""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from typing import Any, Literal

import numpy as np
from scipy.spatial import cKDTree

from nonsmooth import bifurcation_diagram, ensemble
from nonsmooth.fatigue import Specimen, cubic_stiffness
from nonsmooth_chapter.fatigue.crack_figures import (
    LAWS,
    RATIOS,
    closed_arcs,
    portrait_beam,
    settled_orbit,
)
from nonsmooth_chapter.fatigue.crack_motions import (
    BOX_STARTS,
    K_CLOSED,
    K_FACTOR,
    S_RANGE,
    WIDTH,
    XI,
    beam,
    exponent_of_beam,
    motions,
    motions_from,
    period_of,
    scan_of_missing_data,
    settling,
)
from nonsmooth_chapter.fatigue.rig import SET_24, SET_25
from nonsmooth_chapter.judgement import Evidence, Finding, agreed, agrees

__all__ = [
    "arc_distance",
    "circle_criterion",
    "orbits_of_convention",
    "regimes_at",
    "scan_of_orbits",
]


# Claims on the stiffness of the cracked specimen: how it falls, and by which law.

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


# Claims on the phase portraits of Fig. 28, for which the chapter gives no parameters.
#
# The caption prints a mean load of zero, so at rest the specimen is straight and d = 0. The
# convention is the set of Fig. 29 with s = 1, from rest, and the open stiffness of Eq. (48), which
# section 3.5 gives; the cubic law of Fig. 29 stands beside it. The claims are looked at over a
# range of damping, frequency and s as well, with both laws, to show what depends on them.
#
# At d = 0 every periodic motion passes the switch. Were u of one sign throughout, the equation
# would be linear, u'' + 2 xi u' + k u = eta^2 sin(eta tau) with one k > 0. Its mean over a period
# is k <u> = 0, and a u of one sign with mean zero is zero, which the forcing excludes.

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
        for orbits, ratios in _cases(eta, law):
            cases += 1
            counts["period_one"] += all(_period_one(orbit) for orbit in orbits)
            sizes = [float(np.ptp(orbit[:, 0])) for orbit in orbits]
            counts["growing"] += bool(np.all(np.diff(sizes) > 0.0))
            slope = min(slope, *ratios)
            if all(orbit[:, 0].min() < 0.0 < orbit[:, 0].max() for orbit in orbits):
                distance = arc_distance([orbit[orbit[:, 0] <= 0.0] for orbit in orbits])
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


# Claims on the responses at four crack lengths of Fig. 29: period one, two chaotic, period four.
#
# The chapter gives neither s nor d. What the convention gives is computed from many starts and by
# following, and what the range of missing data gives from two; near 5 mm open and closed stiffness
# are so close that the circle criterion decides for every d.

_STARTS = {"u": [0.0, 1.0], "v": [0.0, 0.0]}
_FOLLOWED = {"follow up": 5.0, "follow down": 18.0}
_LASTS = 500  # periods: the linear motion settles within 100
_STEP = 0.02  # mm between columns that are followed
CHAOTIC = 0


def regimes_at(crack: float) -> Evidence:
    """Regimes of the beam with a crack of one length, by every route.

    Parameters
    ----------
    crack : float
        Length [mm].

    Returns
    -------
    dict
        ``attractors`` of a box of starts, ``starts`` (rest and (1, 0)), ``followed`` up from 5 and
        down from 18 mm, ``settling`` times and the ``scan`` over s and d.
    """
    system = beam(crack)
    scan = scan_of_missing_data(crack)
    return {
        "crack": crack,
        "attractors": list(motions(system)),
        "starts": motions_from(system, _STARTS),
        "followed": [_followed(crack, start) for start in _FOLLOWED],
        "settling": settling(system),
        "scan": {name: scan[name] for name in ("cases", "shares")},
    }


def _followed(crack: float, start: Any) -> Evidence:
    begin = _FOLLOWED[start]
    columns = max(round(abs(begin - crack) / _STEP), 1)
    values = np.unique(np.linspace(begin, crack, columns + 1))
    found = bifurcation_diagram(
        beam(crack), "crack", values, start=start, transient=300, record=128
    ).sel(parameter=crack, method="nearest").isel(lane=0)  # fmt: skip
    row: Evidence = {"start": start, "from": begin, "period": int(found["period"])}
    if not row["period"]:
        row |= exponent_of_beam(beam(crack), found.isel(point=-1))
    return row


def circle_criterion(crack: float, s: float, *, xi: float = XI) -> float:
    """Share of what the circle criterion allows by which open and closed stiffness differ.

    Below 1 any two motions approach each other, for every force: there is one motion with the
    period of the forcing, and all others settle to it.

    Parameters
    ----------
    crack : float
        Length [mm].
    s : float
        Scale of the stiffnesses.
    xi : float, optional
        Ratio of damping.

    Returns
    -------
    float
        (kappa_closed - kappa_open) / (4 xi (sqrt(k) - xi)), with k = 1 + kappa_closed.

    Examples
    --------
    >>> circle_criterion(5.05, 1.0) < 1.0 < circle_criterion(5.1, 1.0)
    True
    """
    difference = s * (K_CLOSED - K_FACTOR * (WIDTH - crack) ** 3)
    # Re 1/(k - w^2 + 2 i xi w) is largest where k - w^2 = 2 xi sqrt(k)
    return float(difference / (4.0 * xi * (np.sqrt(1.0 + s * K_CLOSED) - xi)))


def _near_five(cracks: tuple[float, ...] = (5.0, 5.05)) -> Evidence:
    scales = np.geomspace(*S_RANGE, 200)
    return {
        "rows": [regimes_at(crack) for crack in cracks],
        "criterion": [
            {
                "crack": crack,
                "worst": max(abs(circle_criterion(crack, s)) for s in scales),
                "convention": circle_criterion(crack, 1.0),
            }
            for crack in cracks
        ],
    }


def _regime(row: Evidence) -> str:
    if row["period"]:
        return f"period {row['period']}"
    return f"chaos ({row['exponent']:.3f} +- {row['error']:.3f} per period)" if row.get(
        "chaotic", row.get("kind") == "chaotic"
    ) else f"no period ({row['exponent']:.3f} +- {row['error']:.3f})"  # fmt: skip


def _text(evidence: Evidence) -> str:
    found = ", ".join(
        f"{_regime(row)} ({row['share']:.0%}"
        + (f", multiplier {row['multiplier']:.2f})" if row["period"] else ")")
        for row in evidence["attractors"]
    )
    starts = ", ".join(
        f"{_regime(row)} from ({row['u']:g}, {row['v']:g})" for row in evidence["starts"]
    )
    followed = ", ".join(
        f"{_regime(row)} by {row['start']} from {row['from']:g}" for row in evidence["followed"]
    )
    waits = evidence["settling"]
    settled = "" if waits["longest"] is None else (
        f"; cycles are reached within {waits['longest']} periods (median {waits['median']:.0f})"
        + (", no chaotic transient that lasts" if waits["longest"] < _LASTS else "")
    )  # fmt: skip
    shares = ", ".join(
        f"{name if name in ('chaotic', 'neither') else 'period ' + name} {share:.1%}"
        for name, share in sorted(evidence["scan"]["shares"].items(), key=lambda row: -row[1])[:6]
    )
    return (
        f"{evidence['crack']:g} mm, s = 1, d = 0: {found} of {BOX_STARTS} starts; {starts};"
        f" {followed}{settled}; over s and d ({evidence['scan']['cases']} cases): {shares}"
    )


def _judge_label(evidence: Evidence, label: int | str) -> Finding:
    first = evidence["starts"][0]
    chaos = label == "chaos"
    here = first["period"] == (CHAOTIC if chaos else label) and (first["chaotic"] or not chaos)
    return Finding(bool(here), _text(evidence))


def _judge_five(evidence: Evidence) -> Finding:
    alone = all(
        [motion["period"] for motion in row["attractors"]] == [1] for row in evidence["rows"]
    )
    proven = all(row["worst"] < 1.0 for row in evidence["criterion"])
    scanned = all(row["scan"]["shares"] == {"1": 1.0} for row in evidence["rows"])
    bounds = ", ".join(
        f"{row['crack']:g} mm {row['worst']:.2g} (s = 1: {row['convention']:.2g})"
        for row in evidence["criterion"]
    )
    text = (
        f"{_text(evidence['rows'][0])}; difference of stiffness beside what the circle criterion"
        f" allows, at most over s: {bounds}; below 1 the motion of period one is the only one"
    )
    for_all = f"s {S_RANGE[0]:g} to {S_RANGE[1]:g}, every d" if proven and scanned else ""
    return Finding(alone, text, for_all)
