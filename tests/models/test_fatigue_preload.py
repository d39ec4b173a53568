"""Least preload: against a linear solver, against runs at and below it, and what is said of loss.

The linear solver has the matrix of the 50-digit automaton, so signs and statics are not the
library's own. Runs are bracketed at 1e-6 around a force found: contact above, a loss below.
"""

import dataclasses

import numpy as np
import pytest
from mpmath import mp

import nonsmooth as ns
from contract.rig import DIGITS, automaton
from models.fatigue_truth import FIGURE_25, other_names
from nonsmooth.models import FatigueRig, check_contact, fatigue_rig, least_preload
from nonsmooth.models.fatigue_preload import _least
from nonsmooth.models.fatigue_rigs.motion import first_loss, settled_motion

UNEQUAL = FIGURE_25 | {"lambda2": 3.2, "xi_p2": 0.2, "f1": 9.0, "f2": 4.0}


def linear_forces(system):
    """Contact forces at rest and their amplitudes in Phase (i) by numpy on the automaton."""
    p = system.parameter_values
    with mp.workdps(DIGITS):
        mode = automaton(other_names(p))["both"]
        rows = np.array([[float(x) for x in row] for row in mode.matrix])
        guards = np.array([[float(x) for x in exit.guard] for exit in mode.exits])
    drive = rows[:5, 6]  # what multiplies sin
    motion = np.linalg.solve(1j * p["eta"] * np.eye(5) - rows[:5, :5], drive)
    return guards[:, 7] / p["eps"], np.abs(guards[:, :5] @ motion) / p["eps"]


def steady_keeps(system):
    return first_loss(settled_motion(system).run) is None


def start_up_keeps(system):
    return first_loss(ns.simulate(system, periods=40)) is None


@pytest.mark.parametrize("changes", [{}, FIGURE_25, UNEQUAL])
def test_margin_by_a_linear_solver(changes):
    system = fatigue_rig(**changes)
    static, amplitude = linear_forces(system)
    found = least_preload(system)
    # the solver subtracts displacements that differ by 1e-3 of their size
    assert np.allclose(found["static"], static, rtol=1e-11)
    assert np.allclose(found["amplitude"], amplitude, rtol=1e-9)
    assert np.allclose(found["margin"], static - amplitude, rtol=1e-8)
    assert found.attrs["method"] == "closed form"


@pytest.mark.parametrize("changes", [{}, FIGURE_25, UNEQUAL])
@pytest.mark.parametrize(
    ("motion", "keeps"), [("steady", steady_keeps), ("start-up", start_up_keeps)]
)
def test_contact_is_kept_from_the_forces_found_on(changes, motion, keeps):
    system = fatigue_rig(**changes)
    found = least_preload(system, motion=motion)
    force = found["force"].values
    alone = found["least_alone"].values
    cases = [
        found["least_pair"].values,
        found["least_at_ratio"].values,
        np.array([alone[0], force[1]]),
        np.array([force[0], alone[1]]),
    ]
    raised = [(0, 1), (0, 1), (0,), (1,)]
    for least, which in zip(cases, raised, strict=True):
        for factor, kept in ((1 + 1e-6, True), (1 - 1e-6, False)):
            f = [x * (factor if i in which else 1.0) for i, x in enumerate(least)]
            try:
                changed = system.with_parameters(f1=f[0], f2=f[1])
            except ns.ModelError:
                assert not kept
                continue
            assert keeps(changed) is kept, (least, factor)


def test_start_up_asks_for_more_than_steady_motion():
    system = fatigue_rig(**FIGURE_25)
    steady, start = (least_preload(system, motion=m) for m in ("steady", "start-up"))
    assert (start["least_pair"] >= steady["least_pair"]).all()
    assert (start["margin"] <= steady["margin"]).all()


@pytest.mark.slow
@pytest.mark.parametrize("motion", ["steady", "start-up"])
def test_bisection_finds_the_closed_form(motion):
    """A crack that hardly changes the stiffness goes by simulation, and has the linear forces."""
    system = fatigue_rig(**UNEQUAL)
    nearly = fatigue_rig(**UNEQUAL, open_stiffness=1 - 1e-12)
    closed, bisected = (least_preload(each, motion=motion) for each in (system, nearly))
    assert bisected.attrs["method"] == "bisection"
    for name in ("least_alone", "least_at_ratio"):
        assert np.allclose(closed[name], bisected[name], rtol=3e-8), name


@pytest.mark.slow
def test_a_breathing_crack_asks_for_other_forces():
    system = fatigue_rig(**FIGURE_25 | {"f1": 4.5}, open_stiffness=0.4)
    found = least_preload(system, ratio=0.8)
    f1, f2 = found["least_at_ratio"].values
    assert f2 == pytest.approx(0.8 * f1)
    assert steady_keeps(system.with_parameters(f1=f1, f2=f2))
    assert not steady_keeps(system.with_parameters(f1=f1 * (1 - 1e-6), f2=f2 * (1 - 1e-6)))
    linear = least_preload(fatigue_rig(**FIGURE_25 | {"f1": 4.5}), ratio=0.8)
    assert abs(float(linear["least_at_ratio"][0]) / f1 - 1) > 0.05


@pytest.mark.parametrize("tolerance", [0, -1, float("nan"), float("inf"), 0.5, "1e-9", True])
@pytest.mark.parametrize("ratio", [None, 0.5])
def test_a_tolerance_is_a_small_positive_number(tolerance, ratio):
    system = fatigue_rig(f1=9.0, f2=8.0, open_stiffness=ratio)
    with pytest.raises(ns.OptionError, match=r"tolerance = .* positive number of at most 0\.1"):
        least_preload(system, tolerance=tolerance)


def test_a_bisection_ends_at_neighbouring_numbers():
    found = []
    for tolerance in (1e-9, 1e-300):
        looks = 0

        def kept(force):
            nonlocal looks
            looks += 1
            return force >= 2.0**0.5

        found.append(_least(kept, 9.0, tolerance))
        assert looks < 120
    assert found[0] == pytest.approx(2.0**0.5, rel=3e-9)
    assert found[1] == 2.0**0.5
    assert np.isnan(_least(lambda force: False, 9.0, 1e-9))
    assert np.isnan(_least(lambda force: True, 9.0, 1e-9))
    assert _least(lambda force: force >= 2.0**0.5, 1e-300, 1e-9) == pytest.approx(2.0**0.5)


def test_forces_of_cylinders_in_newtons():
    rig = FatigueRig.from_dimensionless()
    found = rig.least_preload(ratio=0.9)
    P1, P2 = found["least_at_ratio"].values
    assert found["margin"].attrs["units"] == "N"
    scale = rig.leaf_stiffness * 2.8e-3
    weight = rig.mass * 9.80665
    assert (P2 - weight) / (P1 + weight) == pytest.approx(0.9, rel=1e-12)
    own = least_preload(fatigue_rig(**FIGURE_25), ratio=0.9)
    assert (P1 + weight) / scale == pytest.approx(float(own["least_at_ratio"][0]), rel=1e-9)
    assert np.allclose(found["margin"], scale * own["margin"], rtol=1e-9)
    kept = dataclasses.replace(rig, cylinder_force_1=P1 * 1.001, cylinder_force_2=P2 * 1.001)
    assert steady_keeps(kept.system())


@pytest.mark.parametrize(
    ("changes", "phase"),
    [(FIGURE_25, "iii"), (FIGURE_25 | {"f1": 3.5, "f2": 6.0}, "ii"), ({}, "iii")],
)
def test_an_error_names_the_phase_and_when(changes, phase):
    run = ns.simulate(fatigue_rig(**changes), periods=5)
    with pytest.raises(
        ns.RunError, match=f"phase {phase} began at time .*raise the preloads"
    ) as info:
        check_contact(run)
    assert info.value.status == "contact lost"
    names = run["event_to"].attrs["flag_meanings"].split()
    entered = [names[int(number)] for number in run["event_to"].values].index(phase)
    assert info.value.time == float(run["event_time"][entered])


@pytest.mark.parametrize("si", [False, True])
def test_a_loss_after_the_last_sample(si):
    """One sample at the start, the loss at 0.3496, the end at 0.36."""
    rig = FatigueRig.from_dimensionless(**fatigue_rig().parameter_values)
    run = ns.simulate(rig.system(), t_end=0.36, samples_per_period=1)
    assert run.sizes["time"] == 1 and float(run["event_time"][-1]) < 0.36
    with pytest.raises(ns.RunError, match="phase iii began at time") as info:
        check_contact(rig.to_si(run) if si else run)
    unit = rig.units.time if si else 1.0
    assert info.value.time == pytest.approx(0.34963951813 * unit, rel=1e-9)
    # until then both masses press
    check_contact(ns.simulate(rig.system(), t_end=0.349, samples_per_period=1))


@pytest.mark.parametrize("si", [False, True])
def test_a_run_that_never_had_contact(si):
    rig = FatigueRig.from_dimensionless(f1=3.0, f2=3.0)
    run = ns.simulate(rig.system(), {"X1": -5.0, "X4": 5.0}, t_end=0.01)
    with pytest.raises(ns.RunError, match="phase iv began at time 0") as info:
        check_contact(rig.to_si(run) if si else run)
    assert info.value.time == 0.0


def test_a_phase_that_lasts_no_time_is_none():
    """The run ends at the very instant of the loss."""
    system = fatigue_rig()
    loss = float(ns.simulate(system, t_end=0.36)["event_time"][-1])
    run = ns.simulate(system, t_end=loss)
    assert check_contact(run) is run


def test_samples_that_begin_late_do_not_hide_the_start():
    run = ns.simulate(fatigue_rig(), times=[50.0, 51.0])
    with pytest.raises(ns.RunError, match=r"time 0\.3496.* In a start-up from rest"):
        check_contact(run)


@pytest.mark.parametrize("si", [False, True])
def test_no_event_log_is_refused(si):
    rig = FatigueRig.from_dimensionless()
    bare, run = (ns.simulate(rig.system(), periods=2, events=events) for events in (False, True))
    part = run.isel(event=slice(0, 1))
    if si:
        bare, part = rig.to_si(bare), rig.to_si(run).isel(event=slice(0, 1))
    with pytest.raises(ns.OptionError, match=r"no event log.*events=False"):
        check_contact(bare)
    with pytest.raises(ns.OptionError, match=r"1 of the .* rows of its event log"):
        check_contact(part)


@pytest.mark.parametrize("ratio", [None, 0.5])
def test_preloads_that_suffice_are_not_to_be_raised(ratio):
    system = fatigue_rig(f1=40.0, f2=40.0, open_stiffness=ratio)
    check_contact(ns.simulate(system, periods=1))
    with pytest.raises(ns.RunError, match=r"f1 = 40 and f2 = 40 keep contact.*start is") as info:
        check_contact(ns.simulate(system, {"X1": -0.5}, periods=1))
    assert "raise" not in str(info.value)
    rig = FatigueRig.from_dimensionless(f1=40.0, f2=40.0)
    run = rig.to_si(ns.simulate(rig.system(), {"X1": -0.5}, periods=1))
    force = f"{rig.cylinder_force_1:.4g} N"
    with pytest.raises(ns.RunError, match=f"cylinder 1 = {force}.*The start is"):
        check_contact(run)


def test_full_contact_passes():
    run = ns.simulate(fatigue_rig(f1=30, f2=25), periods=5)
    assert check_contact(run) is run


def test_the_least_preload_that_the_error_names_keeps_contact():
    rig = FatigueRig.from_dimensionless()
    run = rig.to_si(ns.simulate(rig.system(), periods=5))
    with pytest.raises(ns.RunError, match=r"time [\d.]+ s, where mass 2") as info:
        check_contact(run)
    words = str(info.value).split("contact is kept from ")[1]
    P1 = float(words.split("cylinder 1 = ")[1].split(" N")[0])
    P2 = float(words.split("cylinder 2 = ")[1].split(" N")[0])
    # four digits are shown
    raised = dataclasses.replace(rig, cylinder_force_1=P1 * 1.002, cylinder_force_2=P2 * 1.002)
    check_contact(ns.simulate(raised.system(), periods=40))


def test_bad_input():
    system = fatigue_rig()
    with pytest.raises(ns.OptionError, match="'steady' or 'start-up'"):
        least_preload(system, motion="slow")
    with pytest.raises(ns.OptionError, match="ratio = -1"):
        least_preload(system, ratio=-1)
    # the specimen, bent by mass 1, presses on a mass 2 that nothing holds up
    lifted = fatigue_rig(**FIGURE_25 | {"f1": 30.0, "f2": -0.1})
    assert least_preload(lifted).attrs["ratio"] == 1.0
    with pytest.raises(ns.OptionError, match="duffing"):
        least_preload(ns.models.duffing())
    with pytest.raises(ns.OptionError, match="duffing"):
        check_contact(ns.simulate(ns.models.duffing(), periods=1))
    with pytest.raises(ns.OptionError, match="event log"):
        check_contact(ns.simulate(system, periods=1, events=False))
