"""How often `fit` finds the right parameters, how often its intervals hold them, what it costs.

`python benchmarks/bench_fit.py [PART ...] [--records N] [--processes P] [--file FILE]`. The parts
are ``records`` (100 synthetic records of six machines, see `synthetic_records`), ``repeats`` (how
often intervals hold the truth when only the noise of a record is drawn anew), ``further`` (more
records of quick machines), ``forty`` (40 periods, with one segment beside many), ``crack`` (the
length of a crack of 11.3 mm behind imperfect sensors), ``open`` (a parameter that no record of this
kind determines) and ``cost`` (ten parameters over 100 periods, as a ratio to one run). Each result
is kept in FILE as soon as it is there, so that an interrupted command goes on where it stopped. The
command fails where fewer than 95 of 100 records lead to the right optimum, where intervals surely
hold the truth less often than 92 % or more often than 98 % for records of the kinds that they are
for, or where another part fails.
"""

import argparse
import json
import os
import sys
import time
import warnings
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import synthetic_records as synthetic
from fit_checks import CHECKS, named_sources
from scipy.stats import beta

import nonsmooth as ns
from nonsmooth.files import replacing

PARTS = ("records", *CHECKS)
STARTS = 2
FAR = 5.0  # standard errors for white noise beyond which likelihoods are compared
LEAST, MOST = 0.92, 0.98  # of intervals that hold the truth
FITTED = ("white", "coloured", "sensor")  # kinds of records whose model is right


class Results:
    """Results by key, kept in a file."""

    def __init__(self, path: Path) -> None:
        self.path = path
        path.parent.mkdir(parents=True, exist_ok=True)
        self.found = json.loads(path.read_text()) if path.exists() else {}

    def keep(self, key: str, result: dict) -> None:
        self.found[key] = result
        with replacing(self.path) as path:
            path.write_text(json.dumps(self.found, indent=1))


def height(found) -> float:
    """Minus the logarithm of the likelihood of a fit, up to a constant."""
    fitted = np.isfinite(found["residual"].values) & ~found["held_back"].values
    return float(found.attrs["cost"] + fitted.sum(axis=1) @ np.log(found["noise"].values))


def system_of(name, parameters, free):
    """A system in which only what is to be found differs from the truth."""
    known = {key: value for key, value in parameters.items() if key not in free}
    return getattr(ns.models, name)(**known)


def fit_record(number: int) -> dict:
    """Fit one record, and judge what was found."""
    warnings.simplefilter("ignore")
    case = synthetic.case(number)
    system, names = system_of(case.plan.name, case.parameters, case.free), list(case.truth)
    begun = time.process_time()
    found = ns.fit(
        system,
        case.record,
        case.free,
        case.plan.observe,
        starts=STARTS,
        seed=number,
        **case.options,
    )
    seconds = time.process_time() - begun
    told = {
        name: [float(value) for value in found[name].sel(parameter=names).values]
        for name in ("estimate", "standard_error", "interval_low", "interval_high",
                     "variance_ratio")
    }  # fmt: skip
    truth = np.array(list(case.truth.values()))
    # without what makes intervals wider, so that no wide one makes an optimum a right one
    least = np.array(told["standard_error"]) / np.sqrt(np.maximum(1.0, told["variance_ratio"]))
    is_right = bool(np.all(np.abs(np.array(told["estimate"]) - truth) < FAR * least))
    if not is_right:  # noise or a wrong model shifts it: is it the one next to the truth?
        near = {
            key: (0.9 * value, 0.99 if key == "r" else 1.1 * value)
            for key, value in case.truth.items()
        }
        other = ns.fit(system, case.record, near, case.plan.observe, starts=1, **case.options)
        is_right = height(found) < height(other) + 2.0
    return told | {
        "machine": case.plan.name, "kind": case.kind, "noise": case.noise,
        "events": case.n_events, "truth": list(map(float, truth)),
        "status": found.attrs["status"], "agree": int(found["start_agrees"].sum()),
        "right": is_right and found.attrs["status"] == "completed", "seconds": seconds,
        "widened": "widened" in found.attrs["interval_method"],
        "sources": named_sources(found),
    }  # fmt: skip


def share(hits: int, count: int) -> str:
    """A rate with its 95 % interval (Clopper and Pearson)."""
    low, high = surely(hits, count)
    return f"{hits}/{count} = {100 * hits / count:.1f} % ({100 * low:.1f} to {100 * high:.1f} %)"


def surely(hits: int, count: int) -> tuple[float, float]:
    """95 % interval of a rate."""
    low = beta.ppf(0.025, hits, count - hits + 1) if hits else 0.0
    high = beta.ppf(0.975, hits + 1, count - hits) if hits < count else 1.0
    return float(low), float(high)


def covered(results: list[dict]) -> tuple[int, int]:
    """How many intervals of right optima hold the truth, and how many there are."""
    inside = [
        low <= true <= high
        for each in results
        if each["right"]
        for low, true, high in zip(
            each["interval_low"], each["truth"], each["interval_high"], strict=True
        )
    ]
    return sum(inside), len(inside)


def show_records(results: list[dict]) -> bool:
    """Print rates; whether they are as they should be."""
    right = sum(each["right"] for each in results)
    print(f"right optimum: {share(right, len(results))}")
    for what, keys in (("machine", [p.name for p in synthetic.PLANS]), ("kind", synthetic.KINDS)):
        for key in keys:
            own = [each for each in results if each[what] == key]
            if own:
                hits = sum(each["right"] for each in own)
                print(
                    f"  {key:18} right {hits}/{len(own)}, intervals hold {share(*covered(own))},"
                    f" median {np.median([each['seconds'] for each in own]):.1f} s"
                )
    hits, count = covered([each for each in results if each["kind"] in FITTED])
    print(f"intervals hold the truth, right models: {share(hits, count)}")
    low, high = surely(hits, count)
    return right >= 0.95 * len(results) and high >= LEAST and low <= MOST


def records(kept: Results, count: int, processes: int) -> bool:
    """The synthetic records, those that are missing in processes side by side."""
    keys = [f"record {number}" for number in range(count)]
    missing = [number for number in range(count) if keys[number] not in kept.found]
    with ProcessPoolExecutor(processes) as pool:
        tasks = {pool.submit(fit_record, number): number for number in missing}
        for task in as_completed(tasks):
            number, result = tasks[task], task.result()
            kept.keep(keys[number], result)
            mark = "right" if result["right"] else "WRONG"
            print(
                f"record {number} {result['machine']} {result['kind']} {result['noise']:g}"
                f" {result['events']} events: {mark}, {result['seconds']:.1f} s",
                flush=True,
            )
    return show_records([kept.found[key] for key in keys])


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], help="all by default")
    parser.add_argument("--records", type=int, default=100)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--file", type=Path, default=Path("benchmark-output/bench_fit.json"))
    given = parser.parse_args()
    kept = Results(given.file)
    passed = True
    for part in given.parts or PARTS:
        if part == "records":
            passed &= records(kept, given.records, given.processes)
            continue
        if part not in kept.found:
            kept.keep(part, CHECKS[part]())
        print(f"{part}: {json.dumps(kept.found[part])}", flush=True)
        passed &= kept.found[part]["passed"]
    return int(not passed)


if __name__ == "__main__":
    sys.exit(main())
