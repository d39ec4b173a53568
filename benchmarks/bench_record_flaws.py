"""How often `measured.check` is right: false alarms on clean records, and flaws that it finds.

`python benchmarks/bench_record_flaws.py [--records N] [--seed N]`. Clean records are motions of
impacting and sticking machines with white noise, rounded as a recorder of 12 or 16 bit does. Flaws
are put into such records at random places. Every rate is printed with its 95 % interval (Clopper
and Pearson). The command fails where false alarms are surely more than allowed; the channel whose
contacts graze for less than three samples is printed and not counted, as the page says.
"""

import argparse
import sys
from collections import Counter
from typing import NamedTuple

import numpy as np
from scipy.stats import beta

import nonsmooth as ns

RATE = 2000.0  # samples per s
COUNT = 10_000  # samples of a record
NOISE = (0.002, 0.01, 0.05)  # of the standard deviation of the motion
BITS = (12, 16)
ALLOWED = 1e-3  # false alarms per channel, as by default


class Motion(NamedTuple):
    """A channel of a settled motion, longer than a record."""

    name: str
    values: np.ndarray
    speed: float  # revolutions per s


GRAZING = "soft_impact 0.8 acceleration"

CHANNELS = (
    ("soft_impact", {"omega": 0.8}, ("x", "acceleration")),
    ("soft_impact", {"omega": 0.86}, ("x", "acceleration")),
    ("impact_oscillator", {}, ("x", "v")),
    ("fatigue_rig", {"eta": 2.5, "lambda1": 4.36, "lambda2": 4.36, "f1": 5.44, "f2": 3.52},
     ("acceleration1", "acceleration2")),
    ("rotor", {"eta": 2.442}, ("x", "y")),
    ("moling", {}, ("acceleration", "z")),
    ("friction_oscillator", {}, ("x", "v")),
)  # fmt: skip


def motions() -> list[Motion]:
    """Motions of machines, sampled as by a recorder that knows nothing of their period."""
    found = []
    for name, parameters, channels in CHANNELS:
        system = getattr(ns.models, name)(**parameters)
        speed = 17.3  # revolutions per s
        times = (np.arange(3 * COUNT) / RATE * speed + 200.0) * system.period_value
        run = ns.simulate(system, times=times, events=False)
        for channel in channels:
            values = run[channel].values - float(run[channel].mean())
            if name == "moling" and channel == "z":  # what progresses has a drift by nature
                values = values - np.polyval(np.polyfit(times, values, 1), times)
            title = f"{name} {next(iter(parameters.values()), '')} {channel}".replace("  ", " ")
            found.append(Motion(title, values / values.std(), speed))
    return found


def clean(motion: Motion, noise: float, bits: int, rng: np.random.Generator) -> np.ndarray:
    """A record of a motion from a random instant on, as a recorder of some bits has it."""
    first = rng.integers(0, motion.values.size - COUNT)
    values = motion.values[first : first + COUNT] + rng.normal(0.0, noise, COUNT)
    return rounded(values, bits)


def rounded(values: np.ndarray, bits: int) -> np.ndarray:
    """Values on the grid of a recorder whose range is a quarter wider than the motion."""
    step = 2.5 * np.abs(values).max() / 2**bits
    return np.round(values / step) * step


def checked(values: np.ndarray, speed: float, marked: bool):
    """What is found in a record."""
    times = np.arange(values.size) / RATE
    marks = np.arange(0.0, times[-1], 1.0 / speed) if marked else None
    record = ns.measured.from_arrays({"x": values}, times=times, marks=marks)
    return ns.measured.check(record, false_alarms=ALLOWED)


def freeze(values, noise, rng):
    """Two tenths of a second at the same value."""
    first = rng.integers(100, values.size - 600)
    values[first : first + 400] = values[first]
    return "frozen"


def clip(values, noise, rng):
    """A rail at nine tenths of the largest value."""
    top = 0.9 * np.abs(values).max()
    values[:] = np.clip(values, -top, top)
    return "clipped"


def spike(values, noise, rng):
    """One sample off by fifteen standard deviations of the noise."""
    values[rng.integers(100, values.size - 100)] += 15.0 * noise * rng.choice((-1.0, 1.0))
    return "spike"


def drift(values, noise, rng):
    """A mean that moves by a half of the standard deviation of the motion."""
    values += 0.5 * np.linspace(-0.5, 0.5, values.size)
    return "drift"


def hum(values, noise, rng):
    """A line of 50 Hz, half as high as the noise."""
    phase = rng.uniform(0.0, 2.0 * np.pi)
    values += 0.5 * noise * np.sin(2.0 * np.pi * 50.03 * np.arange(values.size) / RATE + phase)
    return "hum"


def interval(hits: int, count: int) -> str:
    """A rate with its 95 % interval."""
    low = beta.ppf(0.025, hits, count - hits + 1) if hits else 0.0
    high = beta.ppf(0.975, hits + 1, count - hits) if hits < count else 1.0
    return f"{hits}/{count} = {100 * hits / count:.2f} % ({100 * low:.2f} to {100 * high:.2f} %)"


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=20, help="of each motion, noise and bits")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    rng = np.random.default_rng(given.seed)
    kinds: Counter[str] = Counter()
    alarms = total = 0
    found: Counter[str] = Counter()
    tried: Counter[str] = Counter()
    for motion in motions():
        here = 0
        for noise in NOISE:
            for bits in BITS:
                for k in range(given.records):
                    result = checked(clean(motion, noise, bits, rng), motion.speed, k % 2 == 0)
                    wrong = result["kind"].values[result["doubtful"].values]
                    here += bool(wrong.size)
                    kinds.update(f"{motion.name} {noise} {bits} {kind}" for kind in set(wrong))
                    flaw = (freeze, clip, spike, drift, hum)[k % 5]
                    first = rng.integers(0, motion.values.size - COUNT)
                    values = motion.values[first : first + COUNT] + rng.normal(0, noise, COUNT)
                    kind = flaw(values, noise, rng)
                    # a recorder rounds; it does not unclip
                    result = checked(rounded(values, bits), motion.speed, k % 2 == 0)
                    tried[f"{kind} {noise} {bits}"] += 1
                    tried[f"{kind} {motion.name}"] += 1
                    found[f"{kind} {motion.name}"] += kind in result["kind"].values
                    found[f"{kind} {noise} {bits}"] += kind in result["kind"].values
        if motion.name != GRAZING:
            total += 6 * given.records
            alarms += here
        print(f"{motion.name:30} false alarms {interval(here, 6 * given.records)}", flush=True)
    print(f"all but grazing contacts: {interval(alarms, total)}; allowed {100 * ALLOWED:g} %")
    for name, count in sorted(kinds.items()):
        print(f"    {name}: {count}")
    for name in sorted(tried):
        print(f"{name:36} found {interval(found[name], tried[name])}")
    surely = beta.ppf(0.025, alarms, total - alarms + 1) if alarms else 0.0
    return int(surely > ALLOWED)


if __name__ == "__main__":
    sys.exit(main())
