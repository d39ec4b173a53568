"""The engine's first crossings against `reference.modal`, case by case.

    PYTHONPATH=src:tests python -m engine.guard_survey [cases] [first seed]

prints what is wrong, what is refused, and the share of flags by the size of the nearest miss.
"""

import itertools
import sys
from collections import Counter
from functools import cache
from typing import NamedTuple

import numpy as np

import nonsmooth as ns
from engine import conditioning
from engine.flow_survey import ALLOWED, coefficients, template
from engine.guard_cases import GuardCase, draw_guards
from reference.modal import First, first_of

ROUNDINGS = 64 * 2.0**-52  # of the largest state; the engine's margin begins at 32


class Verdict(NamedTuple):
    """``word`` is right, wrong, flagged or refused; ``depth`` the nearest miss.

    ``depth`` is relative to the terms of the guard there, ``resolved`` the same in units of
    what double precision may lose, 1e-12 kappa; both inf where nothing came near.
    """

    word: str
    depth: float
    resolved: float
    detail: str


@cache
def guarded(n: int, k: int, e: int) -> ns.System:
    """The template of the flow with e guards, each of which stops the run."""
    plain = template(n, k)
    parameters, exits = dict(plain.parameters), []
    for g in range(e):
        terms = [f"h{g}_{j}*x{j}" for j in range(n)] + [f"b{g}"]
        terms += [f"hc{g}_{j}*cos(w{j}*t) + hs{g}_{j}*sin(w{j}*t)" for j in range(k)]
        exits.append(ns.Exit(" + ".join(terms), to="stop", name=f"guard{g}"))
        parameters |= {f"h{g}_{j}": 1.0 for j in range(n)} | {f"b{g}": 1.0}
        parameters |= {f"h{c}{g}_{j}": 1.0 for c in "cs" for j in range(k)}
    mode = ns.Mode(plain.modes["m"].flow, exits=exits)
    return ns.System(states=plain.states, parameters=parameters, modes={"m": mode})


def parameter_values(case: GuardCase) -> dict[str, float]:
    """Values of the parameters of `guarded` for a case."""
    n, k = len(case.flow.start), case.flow.frequencies.size
    values = coefficients(case.flow)
    for g, row in enumerate(case.guards):
        values |= {f"h{g}_{j}": row[j] for j in range(n)} | {f"b{g}": row[n]}
        values |= {f"hc{g}_{j}": row[n + 1 + 2 * j] for j in range(k)}
        values |= {f"hs{g}_{j}": row[n + 2 + 2 * j] for j in range(k)}
    return {name: float(value) for name, value in values.items()}


def run(case: GuardCase, **sampling):
    """The case by the engine; raises what it raises."""
    n, k, e = len(case.flow.start), case.flow.frequencies.size, len(case.guards)
    initial = {f"x{i}": float(x) for i, x in enumerate(case.flow.start)}
    values = parameter_values(case)
    sampling = sampling or {"times": [0.0, case.time]}
    return ns.simulate(guarded(n, k, e), initial, parameters=values, **sampling)


def judge(seed: int) -> Verdict:
    """Run one case and compare."""
    case = draw_guards(seed)
    true = first_of(case.matrix.tolist(), case.start.tolist(), case.guards.tolist(), case.time)
    depth, resolved = nearest(case, true)
    try:
        result = run(case)
    except ns.OptionError as reason:
        outside = np.any(
            case.guards @ case.start < -ALLOWED * np.abs(case.guards * case.start).sum()
        )
        return Verdict("right" if outside else "refused", depth, resolved, str(reason)[:90])
    except (ns.ModelError, ns.RunWarning) as reason:
        if "diverged" in str(reason) and _grows_beyond(case, 1e30):
            return Verdict("right", depth, resolved, str(reason)[:90])
        return Verdict("refused", depth, resolved, str(reason)[:90])
    stopped = result.attrs["status"] == "stopped"
    found = float(result["event_time"][-1]) if stopped else np.inf
    expected = np.inf if true.time is None else float(true.time)
    detail = f"found {found!r}, true {expected!r}, {case.name}, {case.kinds}"
    # a run also logs what it finds uncertain behind its end; that is tested elsewhere
    rows = result["event_time"].values <= case.time
    if not result["certified"].values[rows].all():
        return Verdict("flagged", depth, resolved, detail)
    same = found == expected or (
        np.isfinite(found + expected) and abs(found - expected) <= tolerance(case, true)
    )
    if not same and true.time is None and np.isfinite(found):
        same = _zero_there(case, found)  # where all has decayed the truth sees nothing either
    return Verdict("right" if same else "wrong", depth, resolved, detail)


def _grows_beyond(case: GuardCase, size: float) -> bool:
    """Whether the states at the end are larger than a run may have."""
    state = conditioning.flow(case.matrix, case.start, case.time)
    return any(abs(float(y.mid())) > size for y in state)


def _zero_there(case: GuardCase, time: float) -> bool:
    """Whether some guard vanishes at a time, with all its terms below 1e-30 of those before."""
    state = np.array([float(y.mid()) for y in conditioning.flow(case.matrix, case.start, time)])
    before, after = np.abs(case.guards * case.start), np.abs(case.guards * state)
    values = np.abs(case.guards @ state)
    return bool(np.any(values < 1e-30 * before.sum(axis=1)) and after.sum() < before.sum())


def nearest(case: GuardCase, true: First) -> tuple[float, float]:
    """The nearest miss of all guards, relative to their terms and to what rounding may take."""
    best = (np.inf, np.inf)
    for row, gap, place in zip(case.guards, true.gaps, true.places, strict=True):
        if np.isfinite(gap) and place > 0:
            state = [float(y.mid()) for y in conditioning.flow(case.matrix, case.start, place)]
            terms = np.abs(row * np.array(state)).sum()
            lost = resolution(case, row, place, np.array(state))
            best = min(best, (gap / max(terms, 1e-300), gap / max(lost, 1e-300)))
    return best


def resolution(case: GuardCase, row: np.ndarray, time: float, state: np.ndarray) -> float:
    """What double precision may lose of a guard: 1e-12 kappa, or some tens of roundings of the
    largest state on the way. Motions that cancel in the guard are rounded all the same."""
    largest = max(np.abs(state).max(), np.abs(case.start).max())
    lost = ALLOWED * conditioning.kappa(case.matrix, case.start, time, row)
    return max(lost, ROUNDINGS * np.abs(row).sum() * largest)


def tolerance(case: GuardCase, true: First) -> float:
    """Error of the time that the resolution of the guard makes, at a root or a touch."""
    row, time = case.guards[true.number], float(true.time)
    values = [row, row @ case.matrix, row @ case.matrix @ case.matrix]
    state = np.array([float(y.mid()) for y in conditioning.flow(case.matrix, case.start, time)])
    lost = resolution(case, row, time, state)
    rate, second = abs(values[1] @ state), abs(values[2] @ state)
    return 2.0 * lost / max(rate + np.sqrt(lost * second), 1e-300) + 4e-16 * time


def report(verdicts: dict[int, Verdict]) -> str:
    """Words, and the share of flags by decade of the nearest miss."""
    words = Counter(v.word for v in verdicts.values())
    lines = [", ".join(f"{w} {c}" for w, c in words.most_common())]
    lines += [
        "| nearest miss / terms | cases | flagged | wrong | refused |",
        "|---|---|---|---|---|",
    ]
    decades = [-np.inf, *range(-18, -1, 1), np.inf]
    for low, high in itertools.pairwise(decades):
        inside = [
            v.word for v in verdicts.values() if low <= np.log10(max(v.depth, 1e-300)) < high
            or (high == np.inf and v.depth == np.inf)
        ]  # fmt: skip
        if inside:
            c = Counter(inside)
            name = f"1e{low} to 1e{high}"
            lines.append(
                f"| {name} | {len(inside)} | {c['flagged']} | {c['wrong']} | {c['refused']} |"
            )
    return "\n".join(lines)


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 300
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    verdicts = {seed: judge(seed) for seed in range(first, first + count)}
    print(report(verdicts))
    for seed, v in verdicts.items():
        if v.word == "wrong" or (v.word == "flagged" and v.resolved > 10.0):
            print(f"seed {seed}: {v}")


if __name__ == "__main__":
    main()
