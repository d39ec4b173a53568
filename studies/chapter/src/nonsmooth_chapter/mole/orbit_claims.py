"""Claims on the construction of periodic responses from phases: section 2.2, Eqs. (18)-(23)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from nonsmooth import find_orbit, regime
from nonsmooth.models import four_phase_orbit, moling, progression_start
from nonsmooth_chapter.judgement import Check, Evidence, Finding, agreed
from nonsmooth_chapter.mole.four_stages import stages
from nonsmooth_chapter.mole.orbit_branches import FOUR_PHASES, four_phase_branch, turn_word
from nonsmooth_chapter.mole.regime import REST, STARTS

__all__ = ["CHECKS"]

Values = Mapping[str, float]

_FIG10 = {"xi": 0.01, "omega": 0.1}
# Figures with the sets tried for them; amplitudes and static forces of Fig. 10 are ours.
_SETS: Mapping[str, Sequence[Values]] = {
    "7(d), 9": ({"a": 0.3, "b": 0.15, "xi": 0.05, "omega": 0.1},),
    "10(a)": tuple(
        {"a": a, "b": 0.15, "xi": 0.01, "omega": w} for a in (0.3, 0.4) for w in (0.05, 0.1, 0.2)
    ),
    "10(b)": tuple({"a": a, "b": b, **_FIG10} for b in (0.1, 0.2) for a in (0.2, 0.4, 0.8)),
    "10(c)": tuple(
        {"a": a, "b": b, **_FIG10}
        for a, forces in ((0.3, (0.08, 0.16)), (0.5, (0.2, 0.3, 0.4)), (0.9, (0.1, 0.4, 0.7)))
        for b in forces
    ),
}
_FIG8: Sequence[Values] = ({"a": 0.5, "b": 0.25, "xi": 0.05}, {"a": 0.9, "b": 0.4, "xi": 0.05})
_SAME = 1e-8


def _period_one(values: Values, starts: Sequence[Mapping[str, float]]) -> list[xr.Dataset]:
    """Period-one orbits that are motions, from a number of starts; each once."""
    system = moling(**values)
    found: list[xr.Dataset] = []
    for start in starts:
        orbit = find_orbit(system, dict(start), transient=60)
        if orbit.attrs["status"] != "completed":
            continue
        place = np.array([orbit[name].item() for name in "pyq"])
        known = [np.array([other[name].item() for name in "pyq"]) for other in found]
        if all(np.abs(place - other).max() > _SAME for other in known):
            found.append(orbit)
    return found


def _words(
    sets: Mapping[str, Sequence[Values]] = _SETS,
    starts: Sequence[Mapping[str, float]] = (REST, *STARTS),
) -> Evidence:
    rows = []
    for figure, chosen in sets.items():
        words: dict[str, int] = {}
        for values in chosen:
            for orbit in _period_one(values, starts):
                word = turn_word(orbit)
                words[word] = words.get(word, 0) + 1
        rows.append({"figure": figure, "sets": len(chosen), "words": words})
    return {"starts": len(starts), "rows": rows}


def _judge_words(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    whole = sum(sum(row["words"].values()) for row in rows)
    these = sum(row["words"].get(FOUR_PHASES, 0) for row in rows)
    others: dict[str, int] = {}
    for row in rows:
        for word, count in row["words"].items():
            if word != FOUR_PHASES:
                others[word] = others.get(word, 0) + count
    listed = ", ".join(
        f"{row['figure']} {row['words'].get(FOUR_PHASES, 0)} of {sum(row['words'].values())}"
        for row in rows
    )
    text = (
        f"{these} of {whole} period-one orbits have this word (sets of {listed}); the others:"
        f" {'; '.join(f'{word} ({count})' for word, count in others.items()) or 'none'}"
    )
    return Finding(all(row["words"].get(FOUR_PHASES, 0) > 0 for row in rows), text)


def _durations(a: float = 0.3, b: float = 0.15, xi: float = 0.05, omega: float = 0.1) -> Evidence:
    orbit, start = stages(a, b, xi, omega)
    names = orbit["stage_mode"].attrs["flag_meanings"].split()
    return {
        "set": {"a": a, "b": b, "xi": xi, "omega": omega},
        "word": " ".join(names[mode] for mode in orbit["stage_mode"].values),
        "durations": [float(each) for each in orbit["durations"]],
        "length": float(2.0 * np.pi / omega),
        "status": orbit.attrs["status"],
        "stable": orbit.attrs["stable"],
        "start": {name: float(start[name][0]) for name in ("psi_0", "x_0", "y_0")},
    }


def _judge_durations(evidence: Evidence) -> Finding:
    durations, start = evidence["durations"], evidence["start"]
    true = (
        evidence["word"] == FOUR_PHASES
        and evidence["status"] == "completed"
        and min(durations) > 0.0
        and abs(sum(durations) - evidence["length"]) < 1e-9 * evidence["length"]
    )
    named = ", ".join(f"{name} {value:g}" for name, value in evidence["set"].items())
    text = (
        f"{named}: {evidence['word']}, durations"
        f" {', '.join(f'{each:.6g}' for each in durations)}; psi_0 {start['psi_0']:.6f}, x_0"
        f" {start['x_0']:.6f}, y_0 {start['y_0']:.6f};"
        f" {'stable' if evidence['stable'] else 'unstable'}"
    )
    return Finding(true, text)


def _starts_of_progression(
    sets: Mapping[str, Sequence[Values]] = _SETS,
    fast: Sequence[Values] = _FIG8,
    starts: Sequence[Mapping[str, float]] = (REST, *STARTS[:4]),
) -> Evidence:
    """What Eq. (19) leaves where progression begins: from contact, or just at an impact."""
    rows: list[Evidence] = []
    for values in [*(each for chosen in sets.values() for each in chosen), *fast]:
        for orbit in _period_one(values, starts):
            found = progression_start(orbit)
            rows += [
                {
                    "set": dict(values),
                    "entered": str(found["entered"].values[k]),
                    "residual": float(found["residual"][k]),
                    "y_0": float(found["y_0"][k]),
                }
                for k in range(found.sizes["start"])
            ]
    return {"rows": rows}


def _judge_starts(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    holds = [abs(row["residual"]) < 1e-10 for row in rows]
    direct = [row for row in rows if "impact" in row["entered"]]
    slow = [abs(row["residual"]) for row in rows if "impact" not in row["entered"]]
    text = (
        f"{len(rows)} starts of progression on period-one orbits: from contact ({len(slow)})"
        f" Eq. (19) leaves {max(slow, default=0.0):.1e} at most"
    )
    if direct:
        most = max(direct, key=lambda row: row["residual"])
        text += (
            f"; where the slider yields at the impact itself ({len(direct)}) the force is above the"
            f" limit at once, by {most['residual']:.3g} at a = {most['set']['a']:g}, b ="
            f" {most['set']['b']:g}, xi = {most['set']['xi']:g}, and x0 = g"
        )
    return Finding(all(holds), text)


_MINIMA = tuple(
    (a, b) for a, forces in ((0.3, (0.09, 0.13, 0.16, 0.175)), (0.5, (0.13, 0.34, 0.4)))
    for b in forces
)  # fmt: skip


def _minima(sets: Sequence[tuple[float, float]] = _MINIMA, xi: float = 0.01) -> Evidence:
    rows = []
    for a, b in sets:
        system = moling(a=a, b=b, xi=xi)
        found = four_phase_orbit(system)
        branch = four_phase_branch("b", (0.02, 1.2 * a), a=a, xi=xi)
        kept = [branch.isel(point=k) for k in _crossings(branch["b"].values, b)]
        motions = [each for each in kept if bool(each["admissible"])]
        settled = regime(system)
        rows.append(
            {
                "a": a,
                "b": b,
                "least": float(found["F"].min()),
                "closes": bool(found["closes"].any()),
                "closes_as_motion": bool(found["admissible"].any()),
                "orbits": len(motions),
                "stable": any(bool(each["stable"]) for each in motions),
                "from_rest": int(settled["period"]),
            }
        )
    return {"xi": xi, "rows": rows}


def _crossings(values: np.ndarray, wanted: float) -> list[int]:
    """Points right before a branch passes a value."""
    side = values > wanted
    return [int(k) for k in np.flatnonzero(side[1:] != side[:-1])]


def _judge_minima(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    readings = {
        "F as printed, and a stable orbit": ("closes", "stable"),
        "F as printed, and an orbit that is a motion": ("closes", "orbits"),
        "beside it, phase IV held below the friction limit, and a stable orbit": (
            "closes_as_motion", "stable",
        ),
        "the same, and an orbit that is a motion": ("closes_as_motion", "orbits"),
    }  # fmt: skip
    true = {
        name: all(bool(row[zero]) == bool(row[there]) for row in rows)
        for name, (zero, there) in readings.items()
    }
    printed = [each for name, each in true.items() if name.startswith("F as printed")]
    listed = "; ".join(
        f"a {row['a']:g}, b {row['b']:g}: least F {row['least']:.1e}"
        f" ({'a motion' if row['closes_as_motion'] else 'no motion'}),"
        f" {'stable' if row['stable'] else 'unstable' if row['orbits'] else 'no'} orbit, from rest"
        f" {'period ' + str(row['from_rest']) if row['from_rest'] else 'no period'}"
        for row in rows
    )
    told = "; ".join(f"{name}: {'yes' if each else 'no'}" for name, each in true.items())
    return Finding(agreed(printed), f"{told}. {listed}")


CHECKS = (
    Check(
        "M30",
        "period-one orbits from rest and 12 other starts after 60 periods, sets of Figs. 7(d), 9"
        " and 10 (Fig. 10: a and b that are not printed are chosen); true when orbits of each"
        " figure have it",
        _words,
        _judge_words,
    ),
    Check(
        "M31",
        "set of Fig. 7(d), orbit from the equations of its word",
        _durations,
        _judge_durations,
    ),
    Check(
        "M32",
        "period-one orbits of the sets of M30 and of two in the ranges of Fig. 8, each start of"
        " progression; to 1e-10",
        _starts_of_progression,
        _judge_starts,
    ),
    Check(
        "M33",
        "xi .01, omega .1, a .3 and .5, b below, inside and beyond the window; minima of F by a"
        " simplex from a grid, zero: below 1e-9; orbits on the branch of the same word; regime from"
        " rest; F as Eq. (23) prints it decides, with either meaning of a regime that exists",
        _minima,
        _judge_minima,
    ),
)
