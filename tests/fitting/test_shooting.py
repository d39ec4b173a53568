"""Derivatives of residuals and gaps: those of the engine against central differences."""

import numpy as np
import pytest
import synthetic_motions as machines

import nonsmooth as ns
from fitting.test_several_modes import LATCH_FREE, latch, latch_motion
from fitting.truth import RIGID, SOFT, dataset, rigid_motion, soft_motion
from nonsmooth.fitting.beginning import first_states, sizes_of_states
from nonsmooth.fitting.channels import check_free, read_channels
from nonsmooth.fitting.record_equations import RecordEquations
from nonsmooth.fitting.shooting import Shooting


def soft_case():
    times = np.linspace(0.0, 30.0, 300)
    x, _, a, _ = soft_motion(times, [0.3, 0.1])
    free = {"beta": (15, 45), "e": (0.9, 1.6), "omega": (0.8, 0.9)}
    nuisances = {"gain": {"a": (0.5, 2)}, "offset": {"x": "free"}, "delay": {"a": (-0.5, 0.5)}}
    observe = {"x": "x + 0.1*x**2", "a": "acceleration"}
    return ns.models.soft_impact(**SOFT), dataset(times, x=x, a=a), free, nuisances, observe


def rigid_case():
    times = np.linspace(0.0, 15.0, 200)
    x, _, _, _ = rigid_motion(times, [0.1, 0.2])
    free = {"r": (0.5, 0.95), "sigma": (0.35, 0.6), "omega": (1.2, 1.4)}
    nuisances = {"gain": None, "offset": None, "delay": None}
    return ns.models.impact_oscillator(**RIGID), dataset(times, x=x), free, nuisances, {"x": "x"}


def mole_case():
    """In contact the place of the mass follows from that of the slider."""
    machine = machines.moling()
    times = np.linspace(0.0, 3.0 * machine.period, 180)
    found = machines.motion(machine, times, [0.0, 0.0, 0.0, 0.0])
    record = dataset(times, x=found.states[:, 0] + found.states[:, 3], a=found.rates[:, 1])
    free = {"a": (0.2, 0.4), "xi": (0.03, 0.08)}
    nuisances = {"gain": None, "offset": None, "delay": None}
    return (
        ns.models.moling(**machines.MOLING), record, free, nuisances,
        {"x": "p + v", "a": "acceleration"},
    )  # fmt: skip


def rotor_case():
    """In contact the ring follows from the rotor; a free ring is soon back at its centre."""
    changed = {"eta": 1.8, "delta_x": 0.05, "delta_y": 0.05}
    machine = machines.rotor(**changed)
    times = np.linspace(0.0, 3.0 * machine.period, 120)
    found = machines.motion(machine, times, [0.0, 0.0, 0.0, 0.0])
    record = dataset(times, x=found.states[:, 0], y=found.states[:, 1])
    free = {"K": (20, 40), "eps_x": (0.8, 1.0)}
    nuisances = {"gain": None, "offset": None, "delay": None}
    system = ns.models.rotor(**machines.ROTOR | changed)
    return system, record, free, nuisances, {"x": "x", "y": "y"}


def latch_case():
    """Where segments begin, the mass mostly fits both modes."""
    times = np.linspace(0.0, 30.0, 300)
    record = dataset(times, x=latch_motion(times, [0.3, 0.1], "loose").states[:, 0])
    nuisances = {"gain": None, "offset": None, "delay": None}
    return latch(), record, LATCH_FREE, nuisances, {"x": "x"}


@pytest.mark.parametrize(
    ("case", "n_segments"),
    [
        (soft_case, 5),
        (rigid_case, 5),
        (latch_case, 5),
        (mole_case, 12),
        pytest.param(rotor_case, 12, marks=pytest.mark.slow),
    ],
)
def test_derivatives_agree_with_differences(case, n_segments):
    """Through impacts, by parameters that move events, by the frequency, and by a delay.

    Some segments of the mole and the rotor begin in contact, where some states follow from others.
    """
    system, record, free, nuisances, observe = case()
    times = record["time"].values
    channels = read_channels(system, record, observe, nuisances, None)
    margin = 0.5 if n_segments == 5 else 0.0
    bounds = np.linspace(times[0] - margin, times[-1] + margin, n_segments + 1)
    ranges = check_free(system, free)
    record = RecordEquations(system, tuple(free), channels, times, bounds, 1e-12)
    shooting = Shooting([record], list(ranges.values()), [""])
    values = shooting.guess()
    values[: len(free)] = [system.parameter_values[name] * 1.01 for name in free]
    head, noise = shooting.head_of(values), np.full(len(channels), 0.1)
    rest = np.zeros(shooting.n)
    assert shooting.set_up(head)
    shooting.scale_states(sizes_of_states(record, rest))
    states = first_states(record, values, rest, noise, 0)
    u = shooting.join(head, states)
    found = shooting.evaluate(u, noise)
    begins = {system.structure.running[mode].parent for mode in found.modes[1:]}
    if n_segments == 12:
        assert "contact" in begins
    step = 1e-6
    for k in range(shooting.size):
        ahead, behind = (
            shooting.evaluate(u + way * step * np.eye(shooting.size)[k], noise) for way in (1, -1)
        )
        rows = found.rows
        residual, gap = np.zeros_like(rows.residual), np.zeros_like(found.gap)
        if k < shooting.h:
            residual, gap = rows.head[:, k], found.gap_head[:, :, k]
        else:
            m, j = divmod(k - shooting.h, shooting.n)
            residual = np.where(rows.segment == m, rows.state[:, j], 0.0)
            if m < len(gap):
                gap[m] = found.gap_state[m, :, j]
            if m:
                gap[m - 1, j] -= 1.0 / shooting.gap_unit
        for exact, one, other in (
            (residual, ahead.rows.residual, behind.rows.residual),
            (gap, ahead.gap, behind.gap),
        ):
            if exact.size:
                difference = (one - other) / (2.0 * step)
                off = np.abs(difference - exact)
                # a sample between two positions of an event sees neither derivative
                apart = np.sort(off.ravel())[-3] if exact is residual else off.max()
                assert apart < 1e-5 * max(1.0, np.abs(exact).max())


@pytest.mark.parametrize(("growth", "left"), [(3.0, 60), (4.0, 120)])
def test_segments_stay_apart_where_an_error_grows(growth, left):
    """In one segment it grows by 3, or by 4; in two of them by 9, or by 16, above the limit 10."""
    system = ns.System(states=["x"], parameters={"k": 1.0}, equations={"x": "k*x"})
    bounds = np.arange(121) * np.log(growth)
    times = np.linspace(0.0, bounds[-1], 600)
    nuisances = {"gain": None, "offset": None, "delay": None}
    channels = read_channels(system, dataset(times, x=np.sin(times)), {"x": "x"}, nuisances, None)
    ranges = check_free(system, {"k": (0.9, 1.1)})
    record = RecordEquations(system, ("k",), channels, times, bounds, 1e-12, may_join=True)
    shooting = Shooting([record], list(ranges.values()), [""])
    u = shooting.join(shooting.head_of(np.array([1.0])), np.zeros((120, 1)))
    found = shooting.evaluate(u, np.full(1, 0.1))
    kept = shooting.calm_segments(found)
    assert kept.tolist() == list(range(0, 120, 120 // left))
    fewer = shooting.join_segments(u, kept)
    assert (shooting.n_segments, fewer.size, shooting.n_gaps) == (left, left + 1, left - 1)
