"""A million periods: the memory of the samples alone, phases as exact as in the first period."""

import json
import subprocess
import sys

import mpmath
import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, System

MANY = 1_000_000
NUMBERS = {"omega": 2.0, "zeta": 0.05, "r": 0.5, "sigma": 0.1}


def wall(**parameters):
    """A mass on a spring that hits a wall at x = sigma."""
    return System(
        name="wall",
        states=["x", "v"],
        parameters=NUMBERS | parameters,
        period="2*pi/omega",
        modes={
            "free": Mode(
                {"x": "v", "v": "cos(omega*t) - 2*zeta*v - x"},
                exits=[Exit("sigma - x", reset={"v": "-r*v"}, name="impact")],
            )
        },
    )


def closed_form():
    """Phase of the impact, in periods, and speed before it, of one impact per period.

    After an impact at x = sigma, s later, x = exp(-zeta s) (A cos w s + B sin w s) + c cos omega s
    + d sin omega s, where c, d are the amplitudes of the steady motion turned by the phase of
    the impact. x(0) = x(T) = sigma, x'(T) = v, x'(0) = -r v give A, B, c, d linear in v; the sum
    of squares c^2 + d^2 is that of the steady motion, which gives v, and then the phase.
    """
    with mpmath.workdps(40):
        omega, zeta, r, sigma = (mpmath.mpf(NUMBERS[k]) for k in ("omega", "zeta", "r", "sigma"))
        w, period = mpmath.sqrt(1 - zeta**2), 2 * mpmath.pi / omega
        stiffness, damping = 1 - omega**2, 2 * zeta * omega
        size = stiffness**2 + damping**2
        steady_c, steady_s = stiffness / size, damping / size
        decay, cos, sin = mpmath.exp(-zeta * period), mpmath.cos(w * period), mpmath.sin(w * period)
        ratio = (1 / decay - cos) / sin  # B/A
        first = -zeta + w * ratio  # of the rate x'(0), per A
        last = decay * (first * cos - (zeta * ratio + w) * sin)  # of the rate x'(T), per A
        a = (1 + r) / (last - first)  # A per v; then c = sigma - a v, d = b v
        b = (1 - last * a) / omega
        p, q, n = a**2 + b**2, -2 * sigma * a, sigma**2 - 1 / size
        v = (-q + mpmath.sqrt(q**2 - 4 * p * n)) / (2 * p)
        c, d = sigma - a * v, b * v
        angle = mpmath.atan2(c * steady_s - d * steady_c, c * steady_c + d * steady_s)
        return (angle / (2 * mpmath.pi)) % 1, v


# ---------------------------------------------------------------- phases


@pytest.mark.slow
def test_impacts_keep_their_phase_for_a_million_periods():
    phase, speed = closed_form()
    run = ns.simulate(wall(), periods=MANY, samples_per_period=1, events=False)
    assert run.attrs["status"] == "completed"
    # one impact per period once the start is forgotten
    assert abs(run.attrs["n_events"] - MANY) < 100
    last = ns.simulate(wall(), run, periods=10, samples_per_period=1)
    assert last["event_kind"].values.tolist() == ["start"] + 10 * ["impact"]
    assert last["event_period_number"].values[1:].tolist() == list(range(MANY, MANY + 10))
    for k in range(1, 11):
        error = mpmath.mpf(float(last["event_phase"][k])) / mpmath.mpf(run.attrs["period"]) - phase
        assert abs(error) < 1e-12
    before = last["state_before"].sel(state="v").values[1:]
    assert np.abs(before - float(speed)).max() < 1e-12
    # time is period number and phase in one number, so it has the spacing of doubles there
    time = (mpmath.mpf(MANY + 9) + phase) * 2 * mpmath.pi / mpmath.mpf(NUMBERS["omega"])
    assert abs(time - float(last["event_time"][-1])) < 2 * np.spacing(float(time))


def test_forcing_keeps_its_phase_for_a_million_periods():
    # The steady motion of a damped oscillator under two harmonics, by its closed form at the
    # phases of the samples; a phase off by 1e-12 periods shows as 6e-12 of an amplitude.
    omega, zeta = 0.85, 0.1
    system = System(
        states=["x", "v"],
        parameters={"omega": omega, "zeta": zeta},
        period="2*pi/omega",
        outputs={"force": "cos(omega*t) + sin(3*omega*t)"},
        modes={"m": Mode({"x": "v", "v": "cos(omega*t) + sin(3*omega*t) - 2*zeta*v - x"})},
    )
    run = ns.simulate(system, periods=MANY, samples_per_period=1, events=False)
    assert run.attrs["status"] == "completed" and run.attrs["n_events"] == 0
    last = ns.simulate(system, run, periods=2, samples_per_period=7)
    assert last["period_number"].values.tolist() == 7 * [MANY] + 7 * [MANY + 1] + [MANY + 2]
    turns = np.arange(15) % 7 / 7
    angle = 2 * np.pi * turns
    x = v = 0.0
    for wave, w in ((np.exp(1j * angle), omega), (-1j * np.exp(3j * angle), 3 * omega)):
        answer = wave / (1 - w**2 + 2j * zeta * w)
        x, v = x + answer.real, v + (1j * w * answer).real
    # a dozen roundings of quantities of order one
    assert np.abs(last["x"].values - x).max() < 1e-14
    assert np.abs(last["v"].values - v).max() < 1e-14
    force = np.cos(angle) + np.sin(3 * angle)
    assert np.abs(last["force"].values - force).max() < 1e-14
    strobes = run["x"].values[-1000:]
    assert np.abs(strobes - x[0]).max() < 1e-14


# ---------------------------------------------------------------- without the event log


def kept_and_bare(periods):
    """The same irregular run with its log and without."""
    return [
        ns.simulate(wall(sigma=0.0, r=0.8), {"x": -1.0}, periods=periods, events=keep)
        for keep in (True, False)
    ]


def without_log(run):
    """Variables and attributes that do not depend on whether the log was kept."""
    data = run.drop_vars([name for name in run.variables if "event" in run[name].dims])
    del data.attrs["events"], data.attrs["n_rows"]
    return data


@pytest.mark.parametrize("periods", [0.1, 5.3, 2000.7])
def test_leaving_out_the_log_changes_nothing_else(periods):
    kept, bare = kept_and_bare(periods)
    assert without_log(kept).identical(without_log(bare))
    assert "event" not in bare.dims and kept.sizes["event"] == kept.attrs["n_events"] + 1
    # both go on bit for bit, with a log or without
    going_on = [
        ns.simulate(wall(sigma=0.0, r=0.8), run, periods=30, samples_per_period=3, events=keep)
        for run in (kept, bare)
        for keep in (True, False)
    ]
    for run in going_on[1:]:
        assert without_log(run).identical(without_log(going_on[0]))
    assert going_on[0].identical(going_on[2])


def ball(gravity="1"):
    return System(
        name="ball",
        states=["x", "v"],
        modes={"m": Mode({"x": "v", "v": f"-{gravity}"}, exits=[Exit("x", reset={"v": "-0.5*v"})])},
    )


def circle():
    return System(
        name="circle",
        states=["x"],
        modes={
            "left": Mode({"x": "-1"}, exits=[Exit("x", to="right")]),
            "right": Mode({"x": "1"}, exits=[Exit("-x", to="left")]),
        },
    )


def rattle():
    """20 bounces per unit of time; ends at t = 300 where a slow state reaches zero."""
    return System(
        name="rattle",
        states=["x", "v", "fuel"],
        parameters={"use": 1 / 300},
        modes={
            "fly": Mode(
                {"x": "v", "v": "-40", "fuel": "-use"},
                exits=[Exit("x", reset={"v": "-v"}), Exit("fuel", to="stop")],
            )
        },
    )


@pytest.mark.parametrize(
    ("system", "initial", "t_end", "status"),
    [
        (ball(), {"x": 1.0}, 50.0, "event_limit"),
        (circle(), {"x": 1.0}, 5.0, "undecided"),
        (circle(), {"x": 0.0}, 5.0, "undecided"),
        (rattle(), {"v": 1.0, "fuel": 1.0}, 500.0, "stopped"),
    ],
    ids=["event_limit", "undecided", "undecided at once", "stopped"],
)
@pytest.mark.filterwarnings("ignore::nonsmooth.RunWarning")
def test_runs_that_end_early_say_the_same_without_a_log(system, initial, t_end, status):
    kept, bare = (ns.simulate(system, initial, t_end=t_end, events=keep) for keep in (True, False))
    assert kept.attrs["status"] == bare.attrs["status"] == status
    assert without_log(kept).identical(without_log(bare))


def test_phase_words_of_many_modes_without_a_log():
    # 20 bounces per time unit and no period: the word has more modes than it shows
    kept, bare = (
        ns.simulate(rattle(), {"v": 1.0, "fuel": 1.0}, t_end=200.0, events=keep)
        for keep in (True, False)
    )
    assert bare.attrs["phase_word"] == kept.attrs["phase_word"] == "... " + " ".join(100 * ["fly"])


def test_what_needs_the_log_says_that_there_is_none():
    bare = kept_and_bare(3)[1]
    with pytest.raises(ns.OptionError, match="simulate without events=False"):
        ns.phase_word(bare)


@pytest.mark.parametrize("value", [None, 1, 0, "no", "True", [True]])
def test_events_is_true_or_false(value):
    with pytest.raises(ns.OptionError, match=r"events = .*give True or False"):
        ns.simulate(wall(), periods=1, events=value)


def test_a_part_of_a_run_without_a_log_is_not_the_run():
    bare = kept_and_bare(3)[1]
    with pytest.raises(ns.OptionError, match="part of a run"):
        ns.simulate(wall(sigma=0.0, r=0.8), bare.isel(time=slice(0, 5)), periods=1)
    # nor is a run that has lost its log
    kept = kept_and_bare(3)[0]
    lost = kept.drop_vars([name for name in kept.variables if "event" in kept[name].dims])
    with pytest.raises(ns.OptionError, match="part of a run"):
        ns.simulate(wall(sigma=0.0, r=0.8), lost, periods=1)


# ---------------------------------------------------------------- memory

MEASURE = """
import json, resource, sys, tracemalloc
import nonsmooth as ns
from nonsmooth import Exit, Mode, System
wall = System(
    states=["x", "v"],
    parameters={"omega": 2.0, "zeta": 0.05, "r": 0.5, "sigma": 0.1},
    period="2*pi/omega",
    modes={"free": Mode(
        {"x": "v", "v": "cos(omega*t) - 2*zeta*v - x"},
        exits=[Exit("sigma - x", reset={"v": "-r*v"})],
    )},
)
periods, strobes, traced = json.loads(sys.argv[1])
def go(periods):
    if strobes:
        return ns.simulate(wall, periods=periods, samples_per_period=1, events=False)
    return ns.simulate(wall, times=[periods * wall.period_value], events=False)
go(5000)
resident = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
if traced:
    tracemalloc.start()
run = go(periods)
peak = tracemalloc.get_traced_memory()[1] if traced else 0
grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - resident
print(json.dumps([run.attrs["status"], run.attrs["n_events"], peak, grown]))
"""
KILOBYTE = 1 if sys.platform != "darwin" else 1024  # of ru_maxrss


def measured(periods, strobes, traced):
    """Peak of what Python and numpy allocated in bytes, growth of the process in kilobytes."""
    pytest.importorskip("resource", reason="the size of a process is read with it")
    words = [sys.executable, "-c", MEASURE, json.dumps([periods, strobes, traced])]
    done = subprocess.run(words, check=True, capture_output=True, text=True)
    status, events, peak, grown = json.loads(done.stdout)
    assert status == "completed" and abs(events - periods) < 100
    return peak, grown / KILOBYTE


@pytest.mark.slow
def test_memory_does_not_grow_with_the_length_of_a_run():
    short, long = (measured(periods, False, True)[0] for periods in (2_000, 100_000))
    # caches of the interpreter fill; the log would have taken 11 megabytes
    assert abs(long - short) < 1_000_000


@pytest.mark.slow
def test_a_million_periods_in_constant_memory():
    short, _ = measured(2_000, False, True)
    long, _ = measured(MANY, False, True)
    assert abs(long - short) < 1_000_000
    _, grown = measured(MANY, False, False)
    assert grown < 2_000  # the log would have taken 130 megabytes


@pytest.mark.slow
def test_a_million_strobes_take_the_memory_of_a_million_strobes():
    # Kept: time twice (its index has a copy), number, phase, two states of 8 bytes, mode of 1
    # make 49 bytes. While the dataset is made, the buffers of the run are there too.
    short, _ = measured(100_000, True, True)
    long, _ = measured(MANY, True, True)
    per_strobe = (long - short) / (MANY - 100_000)
    assert 41 < per_strobe < 90
    _, grown = measured(MANY, True, False)
    assert 1024 * grown < 90 * MANY + 4e6


def test_strobes_are_those_of_short_runs():
    mole = ns.models.moling()
    words = {"samples_per_period": 1, "events": False}
    whole = ns.simulate(mole, periods=2000, **words)
    parts = [ns.simulate(mole, periods=500, **words)]
    for _ in range(3):
        parts.append(ns.simulate(mole, parts[-1], periods=500, **words))
    for name in ("p", "y", "q", "v", "mode", "slider_force", "acceleration"):
        joined = np.concatenate([parts[0][name], *(part[name][1:] for part in parts[1:])])
        assert np.array_equal(joined, whole[name].values), name
