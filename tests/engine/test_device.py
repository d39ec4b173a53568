"""Kernels for graphics devices: on the processor they give the digits of ordinary runs."""

import re

import numpy as np
import pytest

import nonsmooth as ns
from engine.device_on_processor import device
from nonsmooth.engine import device as on_device
from nonsmooth.engine.device import SOURCE, DeviceLanes, why_not
from nonsmooth.engine.lanes import ANY, lane_records
from nonsmooth.runs import sweep_runner
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.lane_runner import LaneRunner
from nonsmooth.runs.sweep_runner import SweepRunner, SweepStarts, Times

LANES, WINDOWS = 24, 12
LINEAR = [
    "belt_oscillator", "bouncing_ball", "brake_mode_coupling", "breathing_crack", "chua",
    "fatigue_rig", "friction_oscillator", "gear_pair", "impact_oscillator", "moling",
    "percussive_drilling", "print_hammer", "soft_impact", "trilinear",
]  # fmt: skip


def starts_around_rest(system):
    """Starts near rest, some of which no mode admits; what is nan there stays open."""
    rng = np.random.default_rng(1)
    rest = np.array([system.open_state[name] for name in system.states])
    return rest + rng.uniform(-0.5, 0.5, (LANES, rest.size)) * (rng.uniform(size=rest.size) < 0.8)


def signal_system():
    """A mass on a spring, shaken by a record, with a stop."""
    shake = ns.Signal(np.linspace(0.0, 40.0, 161), np.sin(np.arange(161)))
    flow = {"x": "v", "v": "-x - 0.1*v + shake"}
    return ns.System(
        states=["x", "v"], signals={"shake": shake}, period="2.0",
        modes={"free": ns.Mode(flow, exits=[ns.Exit("0.5 - x", reset={"v": "-0.8*v"})])},
    )  # fmt: skip


def run_both(system):
    """Lanes as the processor runs them, and as the kernel does."""
    runner = LaneRunner(system, 1e-12)
    states = starts_around_rest(system)
    numbers, phases = np.arange(WINDOWS + 1), np.zeros(WINDOWS + 1)
    lanes, again = (runner.start(states, Instant(0, 0.0)) for _ in range(2))
    strobes, modes = runner.run(lanes, Instant(WINDOWS, 0.0), numbers, phases)
    records = lane_records(runner.sizes, numbers, phases, 0, LANES)
    statuses = np.zeros(LANES, np.int64)
    kernel = DeviceLanes(device(), runner.tables)
    kernel.run(again.anchors, records, again.mode, (WINDOWS, 0.0), statuses, 1e-12)
    return (strobes, modes, lanes), (records, statuses, again)


@pytest.mark.few(1)
@pytest.mark.parametrize("name", [*LINEAR, "signal"])
def test_lanes_have_the_digits_of_ordinary_runs(name):
    system = signal_system() if name == "signal" else getattr(ns.models, name)()
    assert why_not(system.compiled.program) == ""
    (strobes, modes, lanes), (records, statuses, again) = run_both(system)
    np.testing.assert_array_equal(records.sample_state, strobes)
    np.testing.assert_array_equal(records.sample_mode, modes)
    np.testing.assert_array_equal(statuses, lanes.status)
    np.testing.assert_array_equal(records.counters["uncertain"], lanes.uncertain)
    for field in ("place", "state", "order"):
        np.testing.assert_array_equal(getattr(again.anchors, field), getattr(lanes.anchors, field))
    assert np.isfinite(strobes[:, -1]).any()  # some have come to the end


def swept(system, values, kernel):
    """Motions at some sets of values, recorded with their events."""
    runner = SweepRunner(system, 1e-12)
    runner.most = len(values)
    runner._room = sweep_runner.allocate_stack(system.compiled.program, len(values))
    usable = runner.set_up(values)
    count, n = len(values), len(system.states)
    starts = SweepStarts(
        np.zeros((count, n)), np.full(count, ANY), np.zeros(count, np.int64), np.zeros(count)
    )
    motions = runner.start(starts, usable)
    if kernel:
        runner._device = device()
    numbers = np.tile(np.arange(20, 51), (count, 1))
    return runner.run(motions, Times(numbers, np.zeros(numbers.shape))), motions


@pytest.mark.parametrize("rows", [2, 64])
def test_motions_of_a_sweep_have_the_digits_of_ordinary_runs(monkeypatch, rows):
    """Also where their logs have to grow; values that make no sense are left out."""
    monkeypatch.setattr(on_device, "_ROWS", rows)
    monkeypatch.setattr(sweep_runner, "_LEAST_ON_DEVICE", 1)
    system = ns.models.impact_oscillator()
    place = list(system.parameter_values).index("omega")
    values = np.tile(list(system.parameter_values.values()), (9, 1)).astype(float)
    values[:, place] = np.linspace(0.0, 1.2, 9)  # omega = 0 has no period
    (one, first), (other, second) = (swept(system, values, kernel) for kernel in (False, True))
    for name in one._fields:
        np.testing.assert_array_equal(getattr(other, name), getattr(one, name), err_msg=name)
    for name in ("statuses", "uncertain", "estimated", "since", "end_states", "modes"):
        np.testing.assert_array_equal(getattr(second, name), getattr(first, name), err_msg=name)
    assert np.diff(one.logs).max() > 2 * rows or rows > 2
    assert one.statuses[0] != 0


@pytest.mark.parametrize(
    ("system", "reason"),
    [
        (ns.models.duffing(), "a mode of the system is not linear"),
        (
            ns.System(
                states=["x", "v"],
                modes={"free": ns.Mode(
                    {"x": "v", "v": "-x"}, exits=[ns.Exit("1 - x", reset={"v": "-v**3"})]
                )},
            ),
            "a guard or a reset of the system is not linear",
        ),
        (
            ns.System(
                states=[f"x{i}" for i in range(32)],
                equations={f"x{i}": f"-{i + 1}*x{i}" for i in range(32)},
            ),
            "the system has more than 32 coordinates, the forcing among them",
        ),
    ],
)  # fmt: skip
def test_what_a_device_cannot_run(system, reason):
    assert why_not(system.compiled.program) == reason


def test_the_kernels_are_one_text():
    """The compiler of a device has no files to include: the C++ library only for the processor."""
    text = SOURCE.read_text()
    own, rest = text.split("#else\n", 1)
    headers, body = rest.split("#endif\n", 1)
    assert own.startswith("#ifdef __CUDACC_RTC__")
    assert not re.search(r"^\s*#\s*include", own + body, re.MULTILINE)
    assert all(line.startswith("#include <") for line in headers.splitlines())
    kernels = re.findall(r"^NONSMOOTH_KERNEL (\w+)\(", body, re.MULTILINE)
    assert kernels == ["nonsmooth_lanes_on_device", "nonsmooth_sweep_on_device"]
