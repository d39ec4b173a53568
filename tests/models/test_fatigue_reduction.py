"""The rig as one mass: the chapter's formulas by hand, and errors against five equations."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from models.fatigue_truth import FIGURE_25
from models.test_fatigue_preload import linear_forces
from nonsmooth.models import FatigueRig, fatigue_rig, one_mass, reduction_error
from nonsmooth.models.fatigue_one_mass import lengths_to_check
from nonsmooth.models.fatigue_rigs.motion import first_loss, settled_motion, swing

PRESSED = FIGURE_25 | {"f1": 9.0, "f2": 7.0}


def test_parameters_as_printed():
    found = one_mass(fatigue_rig(**PRESSED), version="chapter")
    lam, theta = 4.36, 7.828
    root = math.sqrt(1 + lam**2)
    assert found.kappa == pytest.approx(theta**2 / (2 + 2 * lam**2), rel=1e-15)
    assert found.xi == pytest.approx((0.00255 + lam * 0.4 + theta * 0.002 / 2) / root, rel=1e-15)
    assert found.eta == pytest.approx(2.5 / root, rel=1e-15)
    assert found.share == 1.0


def test_repaired_stiffness_is_a_series_of_springs():
    """Two contacts beside each other, 2/eps, in series with theta^2; over 2 + 2 lambda^2."""
    found = one_mass(fatigue_rig(**PRESSED))
    series = 1 / (0.002012 / 2 + 1 / 7.828**2)
    assert found.kappa == pytest.approx(series / (2 + 2 * 4.36**2), rel=1e-14)
    assert found.share == pytest.approx(series / 7.828**2, rel=1e-14)


@pytest.mark.parametrize("version", ["chapter", "repaired"])
def test_the_system_has_the_response(version):
    reduced = one_mass(fatigue_rig(**PRESSED), version=version)
    run = settled_motion(reduced.system()).run
    low, high = swing(run, "y")
    assert 0.5 * (high - low) == pytest.approx(abs(reduced.response), rel=1e-7)
    assert np.allclose(run["deflection"], reduced.share * run["y"] + reduced.gamma, atol=1e-15)


def test_errors_against_simulated_five_equations():
    system = fatigue_rig(**PRESSED)
    run = settled_motion(system).run
    reduced = {version: one_mass(system, version=version) for version in ("chapter", "repaired")}
    found = reduction_error(system)
    time = run["time"].values
    masses = 0.5 * (run["X1"] + run["X4"]).values
    turn = np.exp(1j * 2.5 * time)
    for version, limit in (("chapter", 0.05), ("repaired", 1e-6)):
        own = (reduced[version].response * turn).imag
        error = np.abs(own - masses).max() / np.abs(masses).max()
        said = float(found["error"].sel(version=version).item())
        assert error == pytest.approx(said, rel=0.01, abs=1e-8)
        assert said < limit


def test_the_error_is_proportional_to_the_compliance():
    """F32: for rigid contacts five equations become two; 4 % at the printed compliance."""
    eps = [1e-6, 1e-5, 1e-4, 0.002012]
    found = reduction_error(fatigue_rig(**FIGURE_25), eps)
    error = found["error"].sel(version="chapter").values
    assert np.allclose(error[1:3] / error[:2], 10, rtol=0.01)
    assert 0.03 < error[-1] < 0.05
    assert found["error"].sel(version="repaired").values.max() < 1e-6
    assert found["specimen_error"].sel(version="repaired").values.max() < 1e-4


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"lambda2": 3.0}, "lambda1 = 4.36 and lambda2 = 3 differ.*same lambda"),
        ({"xi_p1": 0.3}, "xi_p1 = 0.3 and xi_p2 = 0.4 differ"),
        ({"open_stiffness": 0.5}, "breathing_crack"),
        ({"f2": 3.52, "f1": 5.44}, "phase iii.*mass 2 has left.*f2 = 4.133 alone"),
        ({"f1": 3.5, "f2": 6.0}, "phase ii .*mass 1 has left"),
        ({"eta": 3, "lambda1": 2, "lambda2": 2, "f1": 3.75, "f2": 3.75}, "phase iv.*both masses"),
    ],
)
def test_refused(changes, words):
    with pytest.raises(ns.ModelError, match=words):
        one_mass(fatigue_rig(**PRESSED | changes))


def test_bad_options():
    with pytest.raises(ns.OptionError, match="version"):
        one_mass(fatigue_rig(**PRESSED), version="better")
    with pytest.raises(ns.OptionError, match="positive"):
        reduction_error(fatigue_rig(**PRESSED), [0.0])
    with pytest.raises(ns.OptionError, match="one or more"):
        reduction_error(fatigue_rig(**PRESSED), [])
    with pytest.raises(ns.OptionError, match="not the two-mass"):
        reduction_error(ns.models.soft_impact())


def test_linear_forces_and_reduction_agree():
    """The load of one mass is the difference of the contact forces that a linear solver finds."""
    system = fatigue_rig(**PRESSED)
    _, amplitude = linear_forces(system)
    reduced = one_mass(system)
    # equal sides share the load: half each, in k_Ls A_b
    load = abs(reduced.response) * reduced.kappa * (1 + 4.36**2)
    assert amplitude[0] == pytest.approx(amplitude[1], rel=1e-9)
    assert load == pytest.approx(amplitude[0], rel=1e-3)


@pytest.mark.parametrize("version", ["chapter", "repaired"])
def test_breathing_crack_of_a_rig_by_its_si_equation(version):
    """Eq. (45) with statics in m, kg, s: nothing in the cylinders where z = 0."""
    rig = FatigueRig.from_dimensionless(f1=9.0, f2=7.0)
    crack = 12.0
    k_open = ns.fatigue.guinea_stiffness(crack) * 1e3
    k_closed = rig.specimen_stiffness
    c_s = rig.specimen_damping
    if version == "repaired":
        soft = 1 / (2 * rig.contact_stiffness)
        c_s /= (1 + soft * k_closed) ** 2
        k_open, k_closed = (1 / (1 / k + soft) for k in (k_open, k_closed))
    M = 2 * rig.mass
    k_p = rig.cylinder_stiffness_1 + rig.cylinder_stiffness_2
    c = 2 * rig.leaf_damping + rig.cylinder_damping_1 + rig.cylinder_damping_2 + c_s
    force = rig.cylinder_force_1 + M * 9.80665 - rig.cylinder_force_2
    x = force / (2 * rig.leaf_stiffness + k_open)
    omega = 2 * np.pi * 19.15

    def field(t, state):
        z, v = state
        k = k_open if z + x > 0 else k_closed
        push = M * 2.8e-3 * omega**2 * np.sin(omega * t)
        springs = k_p * z + (2 * rig.leaf_stiffness + k) * (z + x)
        return [v, (push + force - springs - c * v) / M]

    end = 3 / 19.15
    system = rig.breathing_crack(crack, version=version)
    start = {"u": x * 1e3 / rig.base_amplitude}
    run = rig.to_si(ns.simulate(system, start, periods=3))
    other = solve_ivp(
        field, (0, end), [0.0, 0.0], t_eval=run["time"].values[:-1], rtol=1e-11, atol=1e-14,
        method="DOP853", max_step=1e-4,
    )  # fmt: skip
    assert np.allclose(run["u"].values[:-1], 1e3 * (other.y[0] + x), rtol=0, atol=1e-5)
    assert float(run["time"][-1]) == pytest.approx(end, rel=1e-12)
    assert set(run.attrs["phase_word"].split()) == {"open", "closed"}
    k = np.where(run["u"] > 0, k_open, k_closed)
    assert np.allclose(run["load"], k * run["u"] * 1e-3, rtol=1e-9)


def test_breathing_crack_and_two_masses_agree():
    """The repaired version stays within a per cent of the two-mass rig with the same crack."""
    rig = FatigueRig.from_dimensionless(f1=9.0, f2=7.0).cracked(12.0)
    two = rig.to_si(settled_motion(rig.system()).run)
    spans = {}
    for version in ("chapter", "repaired"):
        beam = rig.breathing_crack(version=version)
        one = rig.to_si(settled_motion(beam).run)
        spans[version] = np.subtract(*swing(one, "load")[::-1])
    exact = np.subtract(*swing(two, "load")[::-1])
    assert abs(spans["repaired"] / exact - 1) < 0.01
    assert abs(spans["repaired"] / exact - 1) < 0.3 * abs(spans["chapter"] / exact - 1)


def test_breathing_crack_refuses_lost_contact_and_says_when():
    rig = FatigueRig.from_dimensionless(f1=4.0, f2=3.0)
    with pytest.raises(ns.ModelError, match=r"contact is lost: phase ii*v? began at time .*raise"):
        rig.breathing_crack(10.0)
    assert rig.breathing_crack(10.0, contact="assumed").name == "breathing_crack"


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("f1", "f2", "safe", "lost", "growth"),
    [
        (5.44, 3.52, 12.0, 6.0, "12 - 0.01*t"),
        (4.5, 4.5, 5.0, 17.0, "5 + 0.01*t"),
        # kept at both ends and lost between
        (4.6, 4.1, 19.0, 17.0, "19 - 10*t/(100 + t)"),
    ],
)
def test_a_growing_crack_keeps_contact_at_all_its_lengths(f1, f2, safe, lost, growth):
    rig = FatigueRig.from_dimensionless(f1=f1, f2=f2)
    assert first_loss(settled_motion(rig.cracked(safe).system()).run) is None
    assert first_loss(settled_motion(rig.cracked(lost).system()).run) is not None
    rig.breathing_crack(growth=f"{safe}")
    with pytest.raises(ns.ModelError, match=r"growth = .* has by t = .* contact is lost") as info:
        rig.breathing_crack(growth=growth)
    named = float(str(info.value).split("with a crack of ")[1].split(" mm")[0])
    assert first_loss(settled_motion(rig.cracked(named).system()).run) is not None
    assert rig.breathing_crack(growth=growth, contact="assumed").name == "breathing_crack"


@pytest.mark.parametrize(
    ("growth", "lowest", "highest"),
    [
        ("12", 12.0, 12.0),
        ("5 + 1e-3*exp(t/54734 - 7.8)", 5.0, 19.0),
        ("12 - 0.01*t", 0.0, 12.0),
        ("8 + 2*sin(t/100)", 6.0, 10.0),
        ("10 + 2*t/(1 + t)", 10.0, 12.0),
        ("5 + 1e9*t", 5.0, 19.0),
        ("5 + sqrt(-t)", 5.0, 5.0),
        ("19.5", 19.5, 19.5),
    ],
)
def test_lengths_of_a_growing_crack(growth, lowest, highest):
    lengths = sorted(each.length for each in lengths_to_check(growth))
    assert lengths[0] == pytest.approx(lowest, abs=2e-3)
    assert lengths[-1] == pytest.approx(highest, abs=2e-3)
    assert np.diff(lengths, append=lengths[-1]).max() <= 2.0
    assert lengths_to_check(growth)[0].time == 0.0


def test_growing_crack_of_a_rig():
    rig = FatigueRig.from_dimensionless(f1=9.0, f2=7.0)
    growing = rig.breathing_crack(growth="10 + 1e-3*t")
    fixed = rig.breathing_crack(10.0)
    one, other = (ns.simulate(system, periods=1) for system in (growing, fixed))
    assert np.allclose(one["u"], other["u"], atol=1e-12)
    run = rig.to_si(ns.simulate(growing, periods=3))
    assert run["crack"].attrs["units"] == "mm" and run["u"].attrs["units"] == "mm"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({}, "give crack="),
        ({"crack": 20.0}, "width"),
        ({"crack": -1.0}, "-1"),
        ({"crack": 10.0, "growth": "10"}, "in place of crack"),
        ({"growth": "5 + x"}, "uses 'x'"),
        ({"growth": "25"}, "width"),
        ({"crack": 10.0, "law": "linear"}, "law"),
        ({"crack": 10.0, "version": "better"}, "version"),
        ({"crack": 10.0, "contact": "lost"}, "contact"),
        ({"crack": 10.0, "specimen": ns.fatigue.Specimen(width=30.0)}, "specimen's stiffness"),
    ],
)
def test_bad_breathing_crack(arguments, words):
    with pytest.raises(ns.OptionError, match=words):
        FatigueRig.from_dimensionless(f1=9.0, f2=7.0).breathing_crack(**arguments)
