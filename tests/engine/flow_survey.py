"""The engine's flow against exact exponentials, class by class.

    PYTHONPATH=src:tests python -m engine.flow_survey [cases per class] [first seed] [classes]

prints the table: cases, refused, and the worst error in units of what is allowed.
"""

import sys
from dataclasses import dataclass, field
from functools import cache
from typing import NamedTuple

import numpy as np

import nonsmooth as ns
from engine import conditioning
from engine.spectra import CLASSES, Case, draw

ALLOWED = 1e-12
ROUNDINGS = 16 * 2.0**-52


@cache
def template(n: int, k: int) -> ns.System:
    """x' = A x + k harmonics with every coefficient a parameter, so that texts are read once."""
    flow, parameters = {}, {f"w{j}": 1.0 for j in range(k)}
    for i in range(n):
        terms = [f"a{i}_{j}*x{j}" for j in range(n)]
        terms += [f"c{i}_{j}*cos(w{j}*t) + s{i}_{j}*sin(w{j}*t)" for j in range(k)]
        flow[f"x{i}"] = " + ".join(terms)
        parameters |= {f"a{i}_{j}": 0.0 for j in range(n)}
        parameters |= {f"{c}{i}_{j}": 0.0 for c in "cs" for j in range(k)}
    return ns.System(
        states=[f"x{i}" for i in range(n)], parameters=parameters, modes={"m": ns.Mode(flow)}
    )


def coefficients(case: Case) -> dict[str, float]:
    """Parameter values of the template."""
    n, k = len(case.matrix), case.frequencies.size
    values = {f"w{j}": case.frequencies[j] for j in range(k)}
    values |= {f"a{i}_{j}": case.matrix[i, j] for i in range(n) for j in range(n)}
    values |= {f"c{i}_{j}": case.cosines[i, j] for i in range(n) for j in range(k)}
    values |= {f"s{i}_{j}": case.sines[i, j] for i in range(n) for j in range(k)}
    return {name: float(value) for name, value in values.items()}


class Verdict(NamedTuple):
    """What became of one case; errors in units of what is allowed, inf where refused."""

    refused: str
    tight: float  # each component against 1e-12 of itself plus 16 roundings of its condition
    strict: float  # each component against its own condition
    vector: float  # largest error against the largest condition
    normwise: float  # against expm_cond and the norm of the result


def judge(case: Case) -> Verdict:
    """Run the engine and compare."""
    m, z, n = case.augmented, case.augmented_start, len(case.start)
    true = conditioning.answer(m, z, case.time, np.eye(len(z))[:n])
    # linear, so the start may be scaled: nothing then leaves the range a run may have
    size = 2.0 ** -np.ceil(np.log2(max(1.0, np.abs(true.value).max(), peak(m, z, case.time)) / 1e6))
    if case.frequencies.size or size > 1.0:
        size = 1.0
    initial = {f"x{i}": float(x * size) for i, x in enumerate(case.start)}
    try:
        run = ns.simulate(
            template(n, case.frequencies.size),
            initial,
            times=[0.0, case.time],
            parameters=coefficients(case),
        )
    except ns.ModelError as reason:
        return Verdict(str(reason).split(": ", 1)[1][:60], *[np.inf] * 4)
    except ns.RunWarning as reason:
        return Verdict(str(reason)[:60], *[np.inf] * 4)
    found = np.array([float(run[f"x{i}"][-1]) for i in range(n)]) / size
    return compare(found, true, conditioning.normwise(m, case.time))


def compare(found: np.ndarray, true: conditioning.Answer, normwise: float) -> Verdict:
    """Errors in units of what each of the three definitions allows."""
    error = np.abs(found - true.value)
    error[~np.isfinite(error)] = np.inf
    largest = np.abs(true.value).max()
    few = ALLOWED * np.abs(true.value) + ROUNDINGS * true.kappa
    tight = error / (few + 1e-280)
    strict = error / (ALLOWED * np.maximum(np.abs(true.value), true.kappa) + 1e-280)
    vector = error.max() / (ALLOWED * max(largest, true.kappa.max()) + 1e-280)
    whole = error.max() / (ALLOWED * max(1.0, normwise) * largest + 1e-280)
    return Verdict("", float(tight.max()), float(strict.max()), float(vector), float(whole))


def peak(matrix: np.ndarray, start: np.ndarray, time: float) -> float:
    """Size that the states reach on the way, roughly."""
    from scipy.linalg import expm

    with np.errstate(all="ignore"):
        step = expm(matrix * (time / 16))
        state, sizes = start, []
        for _ in range(16):
            state = step @ state
            sizes.append(np.abs(state).max())
    return float(max(s for s in [1.0, *sizes] if np.isfinite(s)))


@dataclass
class Row:
    """One class of the table."""

    name: str
    verdicts: list[Verdict] = field(default_factory=list)
    worst_seed: int = -1

    @property
    def refused(self) -> int:
        return sum(bool(v.refused) for v in self.verdicts)

    def wrong(self, which: str) -> int:
        return sum(not v.refused and not getattr(v, which) <= 1.0 for v in self.verdicts)

    def worst(self, which: str) -> float:
        return max((getattr(v, which) for v in self.verdicts if not v.refused), default=np.nan)

    def failures(self, seeds: range) -> list[tuple[int, Verdict]]:
        return [(s, v) for s, v in zip(seeds, self.verdicts, strict=True) if not v.tight <= 1.0]


def survey(name: str, seeds: range) -> Row:
    """All cases of a class for a range of seeds."""
    row = Row(name)
    for seed in seeds:
        row.verdicts.append(judge(draw(name, seed)))
    return row


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    kinds = ("tight", "strict", "vector", "normwise")
    print("| class | cases | refused | " + " | ".join(f"{k}: wrong, worst" for k in kinds) + " |")
    print("|---" * (3 + len(kinds)) + "|")
    for name in sys.argv[3:] or CLASSES:
        seeds = range(first, first + count)
        row = survey(name, seeds)
        cells = [f"{row.wrong(k)}, {row.worst(k):.2g}" for k in kinds]
        print(f"| {name} | {count} | {row.refused} | " + " | ".join(cells) + " |", flush=True)
        for seed, v in row.failures(seeds)[:4]:
            print(f"    seed {seed}: {v}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
