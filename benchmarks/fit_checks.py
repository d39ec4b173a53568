"""Single checks of `fit` for `bench_fit.py`: each returns what it has found, as plain numbers."""

import time
from unittest.mock import patch

import numpy as np
import synthetic_motions as motions
import synthetic_records as synthetic
from scipy import stats
from scipy.integrate import solve_ivp
from synthetic_sensors import Sensor, fine_times, record

import nonsmooth as ns
from nonsmooth.fitting import report
from nonsmooth.fitting.flights import Flights
from nonsmooth.fitting.intervals import Interval, threshold

CRACK = 11.3  # mm
SPEEDS = np.linspace(0.95, 1.35, 8)  # of the base, at which the same crack is measured
TEN = {
    "k1": 1.0, "c1": 0.04, "k2": 0.8, "c2": 0.03, "m2": 0.7, "k3": 0.5, "c3": 0.02, "k_stop": 20.0,
    "e": 0.9, "A": 0.5,
}  # fmt: skip
REPEATED = (0, 1, 2, 3, 5, 24, 25, 27, 29, 48, 49, 51, 53, 72, 73, 74, 75, 77, 96, 97, 99)
DRAWS = 8  # of the noise of each of these records, which take a few seconds
FURTHER = {  # records beyond the hundred, by their kind
    "white": range(460, 700), "coloured": range(460, 700), "sensor": range(100, 340),
    "model": range(100, 340),
}  # fmt: skip
QUICK = ("soft_impact", "impact_oscillator", "breathing_crack", "moling")
SPEED = 0.8  # of the force on the two masses


def recorded(machine, periods, start, channels, sensor, seed, per_period=60):
    """A record of a machine through one kind of sensor, and its motion."""
    step = machine.period / per_period
    times = fine_times(0.0, step, per_period * periods)
    found = motions.motion(machine, times, start)
    shown = {name: of(found) for name, of in channels.items()}
    rng = np.random.default_rng(seed)
    return record(step, machine.period, shown, dict.fromkeys(shown, sensor), times, rng), found


def forty() -> dict:
    """40 periods of the soft impact oscillator, in many segments and in one.

    What counts is where the start leads: a wide interval may lead on to a lower minimum.
    """
    shown, found = recorded(
        motions.soft_impact(), 40, (0.3, 0.1), {"x": lambda each: each.states[:, 0]},
        Sensor(0.02), 1,
    )  # fmt: skip
    free, truth = {"beta": (18, 58), "e": (0.9, 1.9), "zeta": (0.002, 0.05)}, motions.SOFT_IMPACT
    answers: dict = {"events": int(found.event_times.size), "truth": [truth[name] for name in free]}
    for name, segments in (("many", None), ("one", 1)):
        fitted = ns.fit(ns.models.soft_impact(), shown, free, starts=1, segments=segments)
        answers[name] = {
            "estimate": fitted["estimate"].values.tolist(),
            "led_to": fitted["start_estimate"].isel(start=0).values.tolist(),
            "low": fitted["interval_low"].values.tolist(),
            "high": fitted["interval_high"].values.tolist(),
            "noise": float(fitted["noise"][0] / shown["x"].std()),
        }
    off = {
        name: np.abs(np.array(answers[name]["led_to"]) / answers["truth"] - 1.0)
        for name in ("many", "one")
    }
    return answers | {"passed": bool(np.all(off["many"] < 0.05) and np.any(off["one"] > 0.1))}


def crack() -> dict:
    """A crack of 11.3 mm behind an imperfect sensor, on a beam with a mode that no model has.

    One record says how far noise and sensor leave the length open. What the model lacks shifts
    each estimate by its own amount, which only records at several speeds show: their estimates
    scatter by more than their intervals say, and the interval of the mean counts that in.
    """
    estimates, lows, highs = [], [], []
    for k, eta in enumerate(SPEEDS):
        machine = motions.breathing_crack(small=motions.SMALL_MASS, crack=CRACK, eta=float(eta))
        sensor = Sensor(
            0.02, colour=0.6, band=0.4, gain=1.015, delay=0.3, jitter=1e-3, bits=12
        )  # fmt: skip
        shown, _ = recorded(
            machine, 20, (0.3, 0.0, 0.3, 0.0), {"u": lambda each: each.states[:, 0]}, sensor, k
        )
        step = machine.period / 60
        fitted = ns.fit(
            ns.models.breathing_crack(eta=float(eta)), shown,
            {"crack": (6, 18), "xi": (0.003, 0.03), "s": (0.9, 1.1)},
            gain=(0.97, 1.03), delay=(0.0, 2.0 * step), starts=2,
        ).sel(parameter="crack")  # fmt: skip
        estimates.append(float(fitted["estimate"]))
        lows.append(float(fitted["interval_low"]))
        highs.append(float(fitted["interval_high"]))
    middle, error = np.mean(estimates), np.std(estimates, ddof=1) / np.sqrt(len(estimates))
    half = error * stats.t.ppf(0.975, len(estimates) - 1)
    return {
        "estimates": estimates, "low": lows, "high": highs,
        "together": [float(middle - half), float(middle), float(middle + half)],
        "single_hold": int(np.sum((np.array(lows) <= CRACK) & (np.array(highs) >= CRACK))),
        "passed": bool(abs(middle - CRACK) <= half and half < 0.2),
    }  # fmt: skip


def repeats() -> dict:
    """How often intervals hold the truth where the model is right and only the noise is drawn anew.

    Records of one motion differ in nothing but their noise, so this is what an interval promises.
    Parameters of one record err together: the error of the rate counts records, not intervals.
    """
    answers: dict = {}
    named = 0
    for colour in (0.0, 0.7):
        shares = []
        for number in REPEATED:
            for seed in range(DRAWS):
                case = synthetic.with_noise_again(number, colour, seed)
                found, inside = near_fit(case, case.free)
                shares.append(float(np.mean(inside)))
                named += bool(named_sources(found))
        answers["coloured" if colour else "white"] = with_error(shares)
    rates = np.array(list(answers.values()))
    within = np.abs(rates[:, 0] - 0.95) <= 0.03 + 2.0 * rates[:, 1]
    return answers | {
        "records": len(shares), "falsely_named": named, "passed": bool(within.all()),
    }  # fmt: skip


def further() -> dict:
    """More records like the hundred, of four machines and of all kinds.

    The search begins near the truth, as the right optimum is not the question here, and intervals
    are those of the standard errors: profiles take most of the time. For each kind
    the result has the rate of intervals that hold the truth with its standard error, how many
    there are, how many records there are, and for how many the fit names a source of errors that
    follow the motion; for those with a miss, too. Fits that say that they have not converged are
    counted by themselves.
    """
    answers: dict = {}
    for kind, numbers in FURTHER.items():
        found, failed = [], 0
        for number in numbers:
            plan, own = synthetic.kind_of(number)
            if own != kind or plan.name not in QUICK:
                continue
            case = synthetic.case(number)
            with patch.object(report, "profile_intervals", by_standard_error):
                fitted, inside = near_fit(case, wide_bounds(case.truth))
            if fitted.attrs["status"] == "completed":
                found.append((inside, bool(named_sources(fitted))))
            else:
                failed += 1
        answers[kind] = rates_of(found) | {"not_converged": failed}
    rates = [answers[kind]["hold"] for kind in FURTHER]
    return answers | {
        "passed": all(abs(rate - 0.95) <= 0.03 + 2.0 * error for rate, error in rates)
    }


def rates_of(found: list) -> dict:
    """Rates over records, of each of which it is given which intervals hold and what is named."""
    shares = [float(np.mean(inside)) for inside, _ in found]
    missed = [(inside, named) for inside, named in found if not inside.all()]
    return {
        "hold": with_error(shares), "records": len(found),
        "intervals": [int(sum(np.sum(inside) for inside, _ in found)),
                      int(sum(np.size(inside) for inside, _ in found))],
        "named": sum(named for _, named in found), "with_a_miss": len(missed),
        "with_a_miss_named": sum(named for _, named in missed),
    }  # fmt: skip


def by_standard_error(shooting, fitted, spread, loss):
    """Intervals that a profile has where the likelihood is a parabola."""
    variances, quantiles = np.diag(spread.covariance), threshold(spread.freedom)
    halves = np.sqrt(variances * quantiles)[: shooting.h]
    return [
        Interval(u - half, u + half, (False, False), np.array([[u, 0.0]]))
        for u, half in zip(fitted.u, halves, strict=False)
    ]


def near_fit(case, bounds):
    """A fit from the middle of some bounds, and which intervals hold the truth."""
    known = {key: value for key, value in case.parameters.items() if key not in case.free}
    system = getattr(ns.models, case.plan.name)(**known)
    found = ns.fit(system, case.record, bounds, case.plan.observe, starts=1, **case.options)
    own = found.sel(parameter=list(case.truth))
    truth = np.array(list(case.truth.values()))
    low, high = own["interval_low"].values, own["interval_high"].values
    return found, (low <= truth) & (truth <= high)


def wide_bounds(truth):
    """Bounds about the true values, within those of each machine."""
    ends = {"r": (0.0, 0.99), "crack": (5.1, 18.0)}
    return {
        name: (max(0.55 * value, ends.get(name, (0.0,))[0]),
               min(1.5 * value, ends.get(name, (np.inf,))[-1]))
        for name, value in truth.items()
    }  # fmt: skip


def named_sources(found):
    """Sources of errors that follow the motion, of which a fit tells."""
    sizes = found["discrepancy"].max("channel")
    return [str(each) for each in found["source"].values if sizes.sel(source=each) > 0.0]


def with_error(shares):
    """A mean with its standard error."""
    return [float(np.mean(shares)), float(np.std(shares, ddof=1) / np.sqrt(len(shares)))]


def unidentifiable() -> dict:
    """A stop that the motion does not meet."""
    shown, _ = recorded(
        motions.soft_impact(e=100.0), 10, (0.3, 0.1), {"x": lambda each: each.states[:, 0]},
        Sensor(0.02, colour=0.5), 3,
    )  # fmt: skip
    fitted = ns.fit(
        ns.models.soft_impact(e=100.0), shown, {"beta": (15, 60), "zeta": (0.002, 0.028)}, starts=1
    )
    return {
        "message": fitted.attrs["open_parameters"],
        "identified": fitted["identified"].values.tolist(),
        "passed": fitted["identified"].values.tolist() == [False, True],
    }


def two_masses() -> ns.System:
    """Two masses, of which the first one meets a stop: ten parameters."""
    return ns.System(
        states=["x", "v", "y", "w"],
        parameters=TEN | {"omega": SPEED},
        period="2*pi/omega",
        equations={
            "x": "v",
            "v": "A*cos(omega*t) - k1*x - c1*v - pull - k_stop*max(x - e, 0)",
            "y": "w",
            "w": "(pull - k3*y - c3*w)/m2",
        },
        definitions={"pull": "k2*(x - y) + c2*(v - w)"},
    )


def ten() -> dict:
    """Ten parameters over 100 periods, as a ratio to one run without and with derivatives."""
    times = np.arange(100 * 40) * 2.0 * np.pi / SPEED / 40
    rng, p = np.random.default_rng(5), TEN

    def rates(t, z):
        x, v, y, w = z
        pull = p["k2"] * (x - y) + p["c2"] * (v - w)
        stop = p["k_stop"] * max(x - p["e"], 0.0)
        force = p["A"] * np.cos(SPEED * t) - p["k1"] * x - p["c1"] * v - pull - stop
        return v, force, w, (pull - p["k3"] * y - p["c3"] * w) / p["m2"]

    known = solve_ivp(
        rates, (0.0, times[-1]), [0.0] * 4, "DOP853", times, rtol=1e-10, atol=1e-11, max_step=0.05
    ).y
    shown = {
        name: ("time", known[k] + 0.02 * known[k].std() * rng.standard_normal(times.size))
        for name, k in (("x", 0), ("y", 2))
    }
    import xarray as xr

    system, bounds = two_masses(), {}
    for name, value in TEN.items():
        middle = value * (1.0 + rng.uniform(-0.3, 0.3))
        bounds[name] = (max(0.02 * value, middle - 0.6 * value), middle + 0.6 * value)
    begun = time.process_time()
    fitted = ns.fit(system, xr.Dataset(shown, {"time": times}), bounds, starts=1)
    seconds = time.process_time() - begun
    flights = Flights(system, list(TEN), 1e-12)
    flights.set_up(TEN)
    plain = least_seconds(lambda: ns.simulate(system, times=times, events=False))
    derived = least_seconds(lambda: flights.fly(np.zeros(4), 0.0, times))
    off = (fitted["estimate"].values - list(TEN.values())) / fitted["standard_error"].values
    return {
        "fit_s": seconds, "run_s": plain, "run_with_derivatives_s": derived,
        "ratio": seconds / plain, "ratio_with_derivatives": seconds / derived,
        "evaluations": int(fitted.attrs["n_evaluations"]), "off": off.tolist(),
        "passed": bool(np.all(np.abs(off) < 5.0)),
    }  # fmt: skip


def least_seconds(call) -> float:
    """Least processor time of five calls."""
    found = []
    for _ in range(5):
        begun = time.process_time()
        call()
        found.append(time.process_time() - begun)
    return min(found)


CHECKS = {
    "repeats": repeats,
    "further": further,
    "forty": forty,
    "crack": crack,
    "open": unidentifiable,
    "cost": ten,
}
