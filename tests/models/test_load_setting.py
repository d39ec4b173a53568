"""Amplitude of the base for a load: the closed form where the rig is linear, runs where not."""

import dataclasses

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.models import FatigueRig, set_load
from nonsmooth.models.fatigue_rigs.motion import settled_motion, swing
from nonsmooth.models.fatigue_rigs.response import full_contact

RIG = FatigueRig.from_dimensionless(frequency=20.0, f1=8.0, f2=6.0)
COMPLIANCE = 1 / ns.fatigue.Specimen().closed_stiffness  # mm/N


def deflection(rig):
    """Half the range of the deflection in a long run, mm; no helper of the search."""
    run = ns.simulate(rig.system(), periods=80, samples_per_period=4000)
    late = run["deflection"].values[-4001:]
    return 0.5 * (late.max() - late.min()) * rig.base_amplitude


@pytest.mark.parametrize("load", [50.0, 100.0, 273.5])
def test_a_linear_rig_by_its_closed_form(load):
    """The deflection is |X3| amplitudes of the base, so the amplitude is load C/|X3|."""
    found = set_load(RIG, load)
    gain = abs(full_contact(RIG.parameters()).X3)
    assert float(found["base_amplitude"]) == pytest.approx(load * COMPLIANCE / gain, rel=1e-8)
    assert float(found["deflection"]) == pytest.approx(load * COMPLIANCE, rel=1e-9)
    # elastic force and damper at right angles: the load is larger by a part in 1e4 at most
    assert float(found["load_amplitude"]) == pytest.approx(load, rel=1e-4)
    assert found.attrs["phase_word"] == "i"
    assert float(found["mean_load"]) == pytest.approx(104.05, abs=0.1)


def test_the_gain_sets_the_voltage_alone():
    one, other = (set_load(RIG, 100.0, gain=gain) for gain in (200.0, 50.0))
    assert float(one["base_amplitude"]) == pytest.approx(float(other["base_amplitude"]), rel=1e-8)
    assert float(one["voltage"]) == pytest.approx(100 * COMPLIANCE / 0.2, rel=1e-9)
    assert float(other["voltage"]) == pytest.approx(4 * float(one["voltage"]), rel=1e-8)


@pytest.mark.parametrize(("load", "crack"), [(273.5, 10.0), (100.0, 13.0)])
def test_a_breathing_crack(load, crack):
    found = set_load(RIG, load, crack=crack)
    wanted = load / ns.fatigue.Specimen().stiffness(crack)
    assert float(found["deflection"]) == pytest.approx(wanted, rel=1e-8)
    rig = dataclasses.replace(RIG.cracked(crack), base_amplitude=float(found["base_amplitude"]))
    assert deflection(rig) == pytest.approx(wanted, rel=1e-5)
    amplitudes, voltages = found["tried_amplitude"].values, found["tried_voltage"].values
    assert voltages[amplitudes == float(found["base_amplitude"])] == float(found["voltage"])
    # no motion twice
    assert len(set(amplitudes)) == len(amplitudes)


def test_lost_contact_is_an_error_with_the_phase_or_part_of_the_motion():
    rig = FatigueRig.from_dimensionless(frequency=20.0)
    with pytest.raises(ns.RunError, match=r"at a base amplitude of .* phase iii began") as info:
        set_load(rig, 500.0)
    assert info.value.status == "contact lost"
    assert "raise the preloads" in str(info.value)
    found = set_load(rig, 500.0, contact="any")
    assert "iii" in found.attrs["phase_word"]
    assert "iii" in set(found["tried_phase"].values)
    reached = dataclasses.replace(rig, base_amplitude=float(found["base_amplitude"]))
    assert deflection(reached) == pytest.approx(500.0 * COMPLIANCE, rel=1e-5)
    # contact is lost, so the linear rig would be shaken otherwise
    linear = 500.0 * COMPLIANCE / abs(full_contact(rig.parameters()).X3)
    assert abs(float(found["base_amplitude"]) / linear - 1) > 1e-3


def test_the_start_of_the_search_does_not_matter():
    other = dataclasses.replace(RIG, base_amplitude=0.05)
    forces = {"cylinder_force_1": RIG.cylinder_force_1, "cylinder_force_2": RIG.cylinder_force_2}
    assert other.cylinder_force_1 == forces["cylinder_force_1"]
    one, two = (set_load(rig, 200.0, crack=9.0) for rig in (RIG, other))
    assert float(one["base_amplitude"]) == pytest.approx(float(two["base_amplitude"]), rel=1e-7)


def test_a_load_out_of_reach_says_why():
    with pytest.raises(ns.RunError, match=r"not reached.*0\.1 mm, the largest.*contact is kept"):
        set_load(RIG, 100.0, largest=0.1)
    with pytest.raises(ns.RunError, match=r"not reached.*phase ii\w* began.*raise the preloads"):
        set_load(RIG, 5000.0, contact="any")


def test_a_motion_that_does_not_repeat_is_told():
    free = FatigueRig.from_dimensionless(xi_p1=0, xi_p2=0, xi_Ls=0, xi_s=1e-6, f1=50, f2=50)
    with pytest.warns(ns.errors.ResultWarning, match="does not repeat"):
        found = set_load(free, 100.0)
    assert found.attrs["period"] == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"load": -1.0}, "load = -1.0"),
        ({"load": float("nan")}, "load = nan"),
        ({"load": 100.0, "largest": 0.0}, "largest = 0.0"),
        ({"load": 100.0, "gain": 0.0}, "gain"),
        ({"load": 100.0, "tolerance": -1.0}, "tolerance = -1.0 must be a positive"),
        ({"load": 100.0, "tolerance": float("nan")}, "tolerance = nan"),
        ({"load": 100.0, "tolerance": 2.0}, "at most 0.1"),
        ({"load": "100"}, "load = '100'"),
        ({"load": True}, "load = True"),
        ({"load": 100.0, "crack": 20.0}, "width"),
        ({"load": 100.0, "contact": "perhaps"}, "contact = 'perhaps'"),
        ({"load": 100.0, "specimen": ns.fatigue.Specimen(width=10.0)}, "specimen's stiffness"),
    ],
)
def test_bad_input(arguments, words):
    with pytest.raises(ns.OptionError, match=words):
        set_load(RIG, **arguments)


@pytest.mark.parametrize(("crack", "period"), [(14.0, 1), (5.0, 2), (13.4, 3)])
def test_settled_motion_says_after_how_many_periods_it_repeats(crack, period):
    motion = settled_motion(ns.models.breathing_crack(crack=crack))
    assert motion.period == period
    ends = [motion.run["u"].values[k] for k in (0, -1)]
    assert abs(ends[0] - ends[1]) < 1e-8


def test_swing_of_a_sine():
    run = ns.simulate(ns.models.duffing(alpha=1, beta=0, delta=0, gamma=0), {"x": 1.0}, t_end=7)
    low, high = swing(run, "x")
    assert high == pytest.approx(1, abs=1e-6) and np.isclose(low, -1, atol=1e-6)
