"""Claims on single periodic orbits of the mole, and on the work to find them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from nonsmooth import find_orbit, regime
from nonsmooth.models import four_phase_orbit, moling, progression_start
from nonsmooth_chapter.judgement import Evidence, Finding, agreed
from nonsmooth_chapter.mole.independent import adaptive_mole_run
from nonsmooth_chapter.mole.orbits import FOUR_PHASES, four_phase_branch, stages, turn_word
from nonsmooth_chapter.mole.sweeps import REST, STARTS

# Claims on the construction of periodic responses from phases: section 2.2, Eqs. (18)-(23).

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


# Claim on the work that the semi-analytical prediction saves (section 2.2).

_STABLE: Sequence[Values] = (
    {"a": 0.35, "b": 0.15, "xi": 0.01, "omega": 0.1},
    {"a": 0.5, "b": 0.3, "xi": 0.01, "omega": 0.1},
    {"a": 0.9, "b": 0.4, "xi": 0.01, "omega": 0.1},
)
_FAR_LESS = 10.0  # times
_AGREES = 1e-6


def _costs(sets: Sequence[Values] = _STABLE, periods: int = 30) -> Evidence:
    """Progression by three routes, and what two of them evaluate; a neighbour gives the guess."""
    rows = []
    for values in sets:
        system = moling(**values)
        near = find_orbit(system, parameters={"b": 0.99 * values["b"]})
        orbit = find_orbit(system, near)
        found = four_phase_orbit(system, progression_start(near))
        turns = 2.0 * np.pi / values["omega"] * np.arange(periods + 1)
        run = adaptive_mole_run(system.parameter_values, turns, tolerance=1e-9, longest_step=4.0)
        drift = float(orbit["v_per_period"])
        others = {
            "minimum": float(found["v_per_period"][0]),
            "steps": float(np.diff(run.states[:, 3])[-1]),
        }
        rows.append(
            {
                "set": dict(values),
                "per_period": drift,
                "differences": {name: abs(each / drift - 1.0) for name, each in others.items()},
                "evaluations": int(found.attrs["evaluations"]),
                "steps": run.n_steps,
                "rates": run.n_evaluations,
            }
        )
    return {"periods": periods, "rows": rows}


def _judge_costs(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    worst = max(max(row["differences"].values()) for row in rows)
    ratio = min(row["steps"] / row["evaluations"] for row in rows)
    listed = "; ".join(
        f"a {row['set']['a']:g}, b {row['set']['b']:g}: {row['evaluations']} evaluations of F,"
        f" {row['steps']} steps with {row['rates']} evaluations of the rates"
        for row in rows
    )
    text = (
        f"progression by the minimum of F and by {evidence['periods']} simulated periods agrees to"
        f" {worst:.1e}; {listed}; {ratio:.0f} steps for each evaluation of F at least (far less:"
        f" {_FAR_LESS:g}). An evaluation of F passes one period in closed form; to miss no end of"
        " a phase, this program looks at some 2000 values of its formulas, a choice of its own"
    )
    return Finding(worst < _AGREES and ratio >= _FAR_LESS, text)
