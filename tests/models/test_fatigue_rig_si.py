"""A fatigue rig in SI units: against Eqs. (34)-(37) in m, kg, s and N, and there and back."""

import dataclasses

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from models.fatigue_truth import FIGURE_25
from nonsmooth.models import FatigueRig, fatigue_rig, one_mass

DATA = {
    "mass": 8.3,
    "leaf_stiffness": 19.2e3,
    "contact_stiffness": 9.5e6,
    "specimen_stiffness": 1.177e6,
    "cylinder_stiffness_1": 365e3,
    "cylinder_stiffness_2": 300e3,
    "leaf_damping": 2.0,
    "specimen_damping": 12.5,
    "cylinder_damping_1": 1400.0,
    "cylinder_damping_2": 1100.0,
    "cylinder_force_1": 211.0,
    "cylinder_force_2": 240.0,
    "base_amplitude": 2.8,
    "frequency": 19.15,
    "open_stiffness": 0.7e6,
}
RIG = FatigueRig(**DATA)
G = 9.80665


def rates(d):
    """Newton's law for both masses and the specimen, positions from that of rest, in SI units."""
    weight = d["mass"] * G
    k_l, k_c = d["leaf_stiffness"], d["contact_stiffness"]
    push, pull = d["cylinder_force_1"] + weight, d["cylinder_force_2"] - weight
    k_rest = d["open_stiffness"] if push > pull else d["specimen_stiffness"]
    # balance of mass 1, mass 2 and specimen at rest; absolute static displacements
    matrix = [[k_l + k_c, 0, -k_c], [0, k_l + k_c, -k_c], [-k_c, -k_c, 2 * k_c + k_rest]]
    m1, m2, s = np.linalg.solve(matrix, [push, -pull, 0])
    omega = 2 * np.pi * d["frequency"]
    shake = d["mass"] * d["base_amplitude"] * 1e-3 * omega**2

    def field(t, state):
        z1, v1, z, z2, v2 = state
        R1 = max(k_c * (z1 + m1 - z - s), 0.0)
        R2 = max(k_c * (z + s - z2 - m2), 0.0)
        k = d["open_stiffness"] if z + s > 0 else d["specimen_stiffness"]
        wave = shake * np.sin(omega * t)
        c1 = d["leaf_damping"] + d["cylinder_damping_1"]
        c2 = d["leaf_damping"] + d["cylinder_damping_2"]
        F1 = push - R1 - k_l * (z1 + m1) - d["cylinder_stiffness_1"] * z1 - c1 * v1
        F2 = -pull + R2 - k_l * (z2 + m2) - d["cylinder_stiffness_2"] * z2 - c2 * v2
        bend = R1 - R2 - k * (z + s)
        m = d["mass"]
        return [v1, (F1 + wave) / m, bend / d["specimen_damping"], v2, (F2 + wave) / m]

    return field, s


@pytest.mark.slow
def test_runs_in_metres_and_seconds():
    """Two periods with loss of contact and a crack, by an integrator in SI units."""
    run = RIG.to_si(ns.simulate(RIG.system(), periods=2))
    field, rest = rates(DATA)
    time = run["time"].values
    truth = solve_ivp(
        field, (0, time[-1]), [0.0] * 5, "Radau", time[::20], rtol=1e-8, atol=1e-13, max_step=1e-4
    )
    for i, name in enumerate(("X1", "X2", "X3", "X4", "X5")):
        scale = np.abs(truth.y[i]).max()
        assert np.allclose(1e-3 * run[name].values[::20], truth.y[i], rtol=0, atol=2e-6 * scale), (
            name
        )
    assert np.allclose(1e-3 * run["deflection"][::20], truth.y[2] + rest, atol=1e-9)
    assert {"i", "iii"} <= set(run["mode"].attrs["flag_meanings"].split())
    omega = 2 * np.pi * 19.15
    assert np.allclose(run["base"], -2.8e-3 * omega**2 * np.sin(omega * time), atol=1e-9)
    acceleration = np.array([field(t, y) for t, y in zip(truth.t, truth.y.T, strict=True)])
    assert np.allclose(run["acceleration1"][::20], acceleration[:, 1], rtol=0, atol=1e-3)
    force = 365e3 * truth.y[0] + 1400 * truth.y[1]
    assert np.allclose(run["pneumatic1"][::20], force, rtol=0, atol=1e-5 * np.abs(force).max())


def test_every_quantity_has_its_unit():
    run = RIG.to_si(ns.simulate(RIG.system(), periods=1))
    expected = {
        "mm": ("X1", "X3", "X4", "deflection"),
        "mm/s": ("X2", "X5"),
        "N": ("load", "contact1", "contact2", "pneumatic1", "pneumatic2"),
        "m/s^2": ("acceleration1", "acceleration2", "absolute1", "absolute2", "base"),
        "s": ("time", "event_time", "phase"),
    }
    for unit, names in expected.items():
        for name in names:
            assert run[name].attrs["units"] == unit, name
    assert list(run["state_units"].values) == ["mm", "mm/s", "mm", "mm", "mm/s"]
    assert run.attrs["period"] == pytest.approx(1 / 19.15, rel=1e-12)
    assert run.attrs["rig_frequency"] == 19.15 and run.attrs["rig_open_stiffness"] == 0.7e6


def test_parameters_by_hand():
    p = RIG.parameters()
    rate = np.sqrt(19.2e3 / 8.3)
    assert p["eta"] == pytest.approx(2 * np.pi * 19.15 / rate, rel=1e-14)
    assert p["theta"] ** 2 == pytest.approx(1.177e6 / 19.2e3, rel=1e-14)
    assert p["lambda2"] ** 2 == pytest.approx(300 / 19.2, rel=1e-14)
    assert p["eps"] == pytest.approx(19.2e3 / 9.5e6, rel=1e-14)
    assert p["f1"] == pytest.approx((211 + 8.3 * G) / (19.2e3 * 2.8e-3), rel=1e-14)
    assert p["f2"] == pytest.approx((240 - 8.3 * G) / (19.2e3 * 2.8e-3), rel=1e-14)
    assert 2 * p["xi_p1"] * p["lambda1"] == pytest.approx(1400 / (8.3 * rate), rel=1e-14)
    assert 2 * p["xi_s"] * p["theta"] == pytest.approx(12.5 / (8.3 * rate), rel=1e-14)
    assert p["open_stiffness"] == pytest.approx(0.7 / 1.177, rel=1e-14)


def test_the_chapters_numbers_make_one_rig():
    """F29: 19.15 Hz, 2.8 mm and 48EI/L^3 give all data, each of a sensible sign and size."""
    rig = FatigueRig.from_dimensionless()
    specimen = 48 * 72.4e9 * (0.01 * 0.02**3 / 12) / 0.27**3
    assert rig.specimen_stiffness == pytest.approx(specimen, rel=1e-12)
    assert rig.leaf_stiffness == pytest.approx(specimen / 7.828**2, rel=1e-12)
    omega = 2 * np.pi * 19.15 / 2.5
    assert rig.mass == pytest.approx(rig.leaf_stiffness / omega**2, rel=1e-12)
    assert rig.contact_stiffness == pytest.approx(rig.leaf_stiffness / 0.002012, rel=1e-12)
    unit = rig.leaf_stiffness * 2.8e-3
    assert rig.cylinder_force_1 == pytest.approx(5.44 * unit - rig.mass * G, rel=1e-12)
    assert rig.cylinder_force_2 == pytest.approx(3.52 * unit + rig.mass * G, rel=1e-12)
    given = {**FIGURE_25, "theta": 7.828, "eps": 0.002012, "xi_Ls": 0.00255, "xi_s": 0.002}
    for name, value in given.items():
        assert rig.parameters()[name] == pytest.approx(value, rel=1e-13), name
    # the load at rest is the mean load of a test of Table 3
    rest = rig.to_si(ns.simulate(rig.system(), times=[0.0]))
    assert float(rest["load"][0]) == pytest.approx(100, rel=0.01)


def test_from_dimensionless_is_the_inverse():
    p = RIG.parameters()
    back = FatigueRig.from_dimensionless(
        frequency=19.15, base_amplitude=2.8, specimen_stiffness=1.177e6, **p
    )
    for name, value in DATA.items():
        assert getattr(back, name) == pytest.approx(value, rel=1e-12), name


def test_from_si_and_back():
    values = {"X1": 1.3, "X5": -20.0, "X3": 0.1, "eta": [18.0, 20.0], "f1": 300.0, "time": 2.0}
    own = RIG.from_si(values)
    units = RIG.units
    for name, value in values.items():
        factor = (units.parameters.get(name) or units.of(name)).factor
        assert np.allclose(np.multiply(own[name], factor), value, rtol=1e-14)
    run = RIG.to_si(ns.simulate(RIG.system(), RIG.from_si({"X1": 1.3}), t_end=own["time"]))
    assert float(run["X1"][0]) == pytest.approx(1.3, rel=1e-12)
    assert float(run["time"][-1]) == pytest.approx(2.0, rel=1e-12)
    assert RIG.from_si({"u": 2.8}, model="one_mass")["u"] == pytest.approx(1.0)


def test_axes_of_sweeps():
    grid = RIG.from_si({"eta": [18.0, 20.0]})["eta"]
    diagram = ns.bifurcation_diagram(RIG.system(), "eta", grid, transient=10, record=2)
    si = RIG.to_si(diagram)
    assert np.allclose(si["parameter"], [18.0, 20.0], rtol=1e-12)
    assert ns.plot.bifurcation(si, "deflection").get_xlabel() == "frequency of the base [Hz]"
    assert "rig_frequency" not in si.attrs and si.attrs["rig_cylinder_force_1"] == 211.0
    changed = ns.simulate(RIG.system(), periods=2, parameters={"f2": 4.0})
    force = RIG.to_si(changed).attrs["rig_cylinder_force_2"]
    assert force == pytest.approx(4.0 * 19.2e3 * 2.8e-3 + 8.3 * G, rel=1e-12)


def test_forces_that_are_tied_keep_their_unit():
    system = ns.tie_parameters(RIG.system(), {"f1": "f", "f2": "0.8*f"}, f=6.0)
    grid = RIG.from_si({"f": [300.0, 400.0]}, like={"f": "f1"})["f"]
    si = RIG.to_si(ns.bifurcation_diagram(system, "f", grid, transient=5, record=1))
    assert np.allclose(si["parameter"], [300.0, 400.0], rtol=1e-12)
    assert si["parameter"].attrs["units"] == "N"
    assert not {"rig_cylinder_force_1", "rig_cylinder_force_2"} & set(si.attrs)


def test_spectra_are_in_the_machines_units():
    run = ns.simulate(RIG.system(), periods=60)
    spectrum = RIG.to_si(ns.power_spectrum(run, "X1", transient=20))
    peak = spectrum["frequency"].values[int(spectrum["amplitude"].argmax("frequency"))]
    assert peak == pytest.approx(19.15, rel=1e-6)
    assert spectrum["amplitude"].attrs["units"] == "mm"


def test_results_of_one_mass():
    rig = FatigueRig.from_dimensionless(f1=9.0, f2=7.0)
    reduced = one_mass(rig.system(), version="chapter")
    run = rig.to_si(ns.simulate(reduced.system(), periods=2))
    assert run["y"].attrs["units"] == "mm" and run["v"].attrs["units"] == "mm/s"
    assert float(run["time"][-1]) == pytest.approx(2 / 19.15, rel=1e-12)
    k = rig.one_mass_data().specimen_stiffness
    assert np.allclose(run["force"], k * run["y"] * 1e-3, rtol=1e-12)
    data = rig.one_mass_data(version="repaired")
    assert data.specimen_stiffness / data.stiffness == pytest.approx(
        one_mass(rig.system()).kappa, rel=1e-12
    )
    assert data.damping_ratio == pytest.approx(one_mass(rig.system()).xi, rel=1e-12)
    assert data.rate == pytest.approx(reduced.rate * 2 * np.pi * rig.natural_frequency, rel=1e-12)
    with pytest.raises(ns.OptionError, match="not made with"):
        dataclasses.replace(rig, leaf_damping=50.0).to_si(ns.simulate(reduced.system(), periods=1))


def test_cracks():
    rig = FatigueRig.from_dimensionless()
    specimen = ns.fatigue.Specimen()
    assert rig.cracked(8.0).open_stiffness == pytest.approx(1e3 * specimen.stiffness(8.0), rel=1e-9)
    cubic = rig.cracked(8.0, law="cubic").open_stiffness / rig.specimen_stiffness
    assert cubic == pytest.approx((12 / 15) ** 3, rel=1e-12)
    with pytest.raises(ns.OptionError, match="width"):
        rig.cracked(25.0)
    with pytest.raises(ns.OptionError, match="specimen's stiffness"):
        dataclasses.replace(rig, specimen_stiffness=2e6).cracked(8.0)


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        ({"specimen_stiffness": -1.0}, "specimen_stiffness = -1 must be positive"),
        ({"open_stiffness": -1.0}, "open_stiffness = -1 must be positive.*broken"),
        ({"contact_stiffness": 0.0}, "contact_stiffness"),
        ({"leaf_damping": -2.0}, "leaf_damping = -2 must not be negative"),
        ({"cylinder_stiffness_1": 0.0}, "cylinder_damping_1 = 1400 needs a stiffness"),
        ({"frequency": float("nan")}, "frequency = nan is not a finite number"),
        ({"mass": "heavy"}, "mass = 'heavy'"),
        ({"mass": None}, "mass = None"),
        ({"mass": "8"}, "mass = '8' is not a finite number"),
        ({"mass": True}, "mass = True is not a finite number"),
        ({"open_stiffness": np.True_}, "open_stiffness"),
    ],
)
def test_bad_data(bad, words):
    with pytest.raises(ns.ModelError, match=words):
        FatigueRig(**DATA | bad)


def test_bad_input():
    run = ns.simulate(RIG.system(), periods=1)
    with pytest.raises(ns.OptionError, match="SI units already"):
        RIG.to_si(RIG.to_si(run))
    with pytest.raises(ns.OptionError, match="not made with the system of this rig"):
        RIG.to_si(ns.simulate(fatigue_rig(), periods=1))
    with pytest.raises(ns.OptionError, match="'duffing'"):
        RIG.to_si(ns.simulate(ns.models.duffing(), periods=1))
    with pytest.raises(ns.OptionError, match="unknown state or parameter 'X9'"):
        RIG.from_si({"X9": 1.0})
    with pytest.raises(ns.OptionError, match="no number"):
        RIG.from_si({"X1": "far"})
    for bad in (np.nan, [1.0, np.inf], float("-inf"), None):
        with pytest.raises(ns.OptionError, match=r"X1'\] = .* must be finite"):
            RIG.from_si({"X1": bad})
    for bad in ("1.0", ["1", "2"], True, [True], [1.0, [2.0]]):
        with pytest.raises(ns.OptionError, match=r"X1'\] = .* no number"):
            RIG.from_si({"X1": bad})
    with pytest.raises(ns.OptionError, match="model"):
        RIG.from_si({"X1": 1.0}, model="three")
    with pytest.raises(ns.OptionError, match=r"frequency = .* must be a positive number"):
        FatigueRig.from_dimensionless(frequency=-1.0)
    with pytest.raises(ns.OptionError, match="base_amplitude = 'far'"):
        FatigueRig.from_dimensionless(base_amplitude="far")
    with pytest.raises(ns.OptionError, match="crack = 'ten'"):
        RIG.cracked("ten")


@pytest.mark.parametrize("forces", [(-1000.0, 270.0), (211.0, -1000.0), (-1000.0, -1000.0)])
def test_a_mass_that_does_not_press_at_rest(forces):
    """Forces on the masses, weights included, bend leaf springs and the specimen."""
    one, two = forces
    rig = dataclasses.replace(RIG, cylinder_force_1=one, cylinder_force_2=two)
    run = rig.to_si(ns.simulate(rig.system(), times=[0.0]))
    load = (one + rig.mass * 9.80665, two - rig.mass * 9.80665)
    for i in (1, 2):
        alone = load[i - 1] > 0.0  # the other one is off
        # mass 1 alone opens the crack
        specimen = rig.open_stiffness if i == 1 and rig.open_stiffness else rig.specimen_stiffness
        give = 1.0 / rig.leaf_stiffness + 1.0 / specimen + 1.0 / rig.contact_stiffness
        expected = load[i - 1] / rig.leaf_stiffness / give if alone else 0.0
        assert float(run[f"contact{i}"][0]) == pytest.approx(expected, rel=1e-12)


@pytest.mark.slow
def test_a_record_of_the_base_in_place_of_a_sine():
    """A sampled sine is the harmonic base, up to the interpolation between its samples."""
    rate, samples = 2 * np.pi * RIG.frequency, 400
    t = np.arange(0.0, 0.5, 1.0 / RIG.frequency / samples)
    acceleration = -1e-3 * RIG.base_amplitude * rate**2 * np.sin(rate * t)  # m/s^2
    system = RIG.system(base=ns.Signal(t, acceleration))
    assert "eta" not in system.parameters and system.period is None
    times = RIG.from_si({"time": t[::40]})["time"]
    recorded, sine = ns.simulate(system, times=times), ns.simulate(RIG.system(), times=times)
    for name in ("X1", "X3", "X4", "load", "base", "absolute2"):
        size = float(np.abs(sine[name]).max())
        # a spline through 400 samples of a sine is off by (2 pi / 400)^4 / 384 of it
        assert np.abs(recorded[name] - sine[name]).max() < 2e-9 * size
    si, expected = RIG.to_si(recorded), RIG.to_si(sine)
    assert float(si["load"][-1]) == pytest.approx(float(expected["load"][-1]), abs=1e-5)
    assert si["base"].attrs["units"] == "m/s^2" and "rig_frequency" not in si.attrs
    assert si["base"].values == pytest.approx(acceleration[::40], abs=1e-9)
    with pytest.raises(ns.OptionError, match="give a Signal of nonsmooth"):
        RIG.system(base=[1.0, 2.0])
    other = dataclasses.replace(RIG, mass=9.0)
    with pytest.raises(ns.OptionError, match="not made with the system of this rig"):
        other.to_si(recorded)


def test_a_crack_that_stiffens_is_refused():
    with pytest.raises(ns.ModelError, match="a crack softens"):
        dataclasses.replace(RIG, open_stiffness=2e6)
    with pytest.raises(ns.ModelError, match="lengths from 5 mm on"):
        RIG.cracked(0.0, law="cubic")
    with pytest.raises(ns.ModelError, match="a crack softens"):
        fatigue_rig(open_stiffness=1.1)
    assert RIG.cracked(5.0, law="cubic").open_stiffness == RIG.specimen_stiffness
