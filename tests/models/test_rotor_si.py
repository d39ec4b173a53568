"""A rotor rig in SI units: against equations in kg, m, s and N, and there and back."""

import dataclasses

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.models import RotorRig, snubber_boundaries, snubber_ring, static_contact

DATA = {
    "mass": 9.7,
    "unbalance_mass": 0.028,
    "unbalance_radius": 35.0,
    "rotor_stiffness": 79e3,
    "ring_stiffness": 2354e3,
    "rotor_damping": 105.0,
    "ring_damping": 3.5,
    "gap": 0.5,
    "speed": 30.1,
    "eccentricity_x": 0.5,
    "preload_x": 0.1,
    "preload_y": 0.1,
}
RIG = RotorRig(**DATA)


def in_contact(run):
    """Where the mode is none of the cells without contact."""
    names = run["mode"].attrs["flag_meanings"].split()
    return np.array([names[number] != "free" for number in run["mode"].values])


@pytest.fixture(scope="module")
def run():
    return ns.simulate(RIG.system(), periods=30)


def test_scaling_of_the_chapter():
    """Section 4.3 by hand: 9.7 kg on 79 kN/m, 2 sqrt(k_r M) = 1750.8 kg/s."""
    assert RIG.natural_frequency == pytest.approx(14.363088, abs=1e-6)
    values = RIG.parameters()
    assert values["nu1"] == pytest.approx(105.0 / 1750.7714, rel=1e-7)
    assert values["nu2"] == pytest.approx(3.5 / 1750.7714, rel=1e-7)
    assert values["K"] == pytest.approx(2354 / 79, rel=1e-15)
    assert values["eta_m"] == pytest.approx(0.028 / 9.7, rel=1e-15)
    assert values["rho"] == pytest.approx(70.0, rel=1e-15)
    assert values["eta"] == pytest.approx(30.1 / 14.363088, rel=1e-7)
    assert (values["eps_x"], values["delta_x"], values["phi0"]) == (1.0, 0.2, 0.0)
    assert dict(RIG.system().parameter_values) == values


def test_free_flight_in_metres_and_seconds():
    """Until the first contact: M x'' + c_r x' + k_r (x - eps) = m rho Omega^2 cos, in SI."""
    rig = dataclasses.replace(RIG, eccentricity_x=0.1, eccentricity_y=-0.05, phase=0.4)
    system = rig.system()
    si = rig.to_si(ns.simulate(system, {"x": 0.2, "vy": 0.1}, t_end=6.0))
    free = ~in_contact(si)
    last = int(np.argmin(free)) if not free.all() else free.size
    assert last > 50
    omega, m_rho = 2 * np.pi * 30.1, 0.028 * 0.035

    def rates(t, state):
        x, y, vx, vy = state
        push = m_rho * omega**2 * np.array([np.cos(0.4 + omega * t), np.sin(0.4 + omega * t)])
        ax = (push[0] - 105.0 * vx - 79e3 * (x - 1e-4)) / 9.7
        ay = (push[1] - 105.0 * vy - 79e3 * (y + 5e-5)) / 9.7
        return [vx, vy, ax, ay]

    time = si["time"].values[:last]
    rate = np.sqrt(79e3 / 9.7)
    start = [1e-4, 0.0, 0.0, 0.1 * 5e-4 * rate]
    truth = solve_ivp(rates, (0.0, time[-1]), start, "DOP853", time, rtol=1e-12, atol=1e-15)
    for i, name in enumerate(("x", "y", "vx", "vy")):
        assert np.allclose(1e-3 * si[name].values[:last], truth.y[i], rtol=1e-8, atol=1e-11), name


def test_force_in_newtons(run):
    """In contact the springs and dampers of (55)-(58) in N/m and kg/s give the same force."""
    si = RIG.to_si(run)
    beyond = np.abs(si["sx"].values) > 0.1
    contact = in_contact(si)
    count = np.where(beyond, 1, 2)
    spring = 2354e3 * 1e-3 * (count * si["sx"].values + (count == 1) * 0.1 * np.sign(si["sx"]))
    expected = spring + 3.5 * 1e-3 * count * si["ring_vx"].values
    assert contact.sum() > 500
    assert np.allclose(si["force_x"].values[contact], expected[contact], rtol=1e-10, atol=1e-9)
    # energy of a spring pair within its preload: k_s s^2, in mJ
    inside = contact & ~beyond & (np.abs(si["sy"].values) < 0.1)
    radius = np.hypot(si["sx"], si["sy"]).values
    assert np.allclose(si["energy"].values[inside], 2354.0 * radius[inside] ** 2, atol=1e-9)


def test_there_and_back(run):
    """Undoing the units by hand gives the run again."""
    si, rate = RIG.to_si(run), np.sqrt(79e3 / 9.7)
    for names, factor in (
        (("x", "y", "sx", "sy", "gap"), 0.5),
        (("vx", "vy", "ring_vx", "ring_vy"), 0.5 * rate),
        (("force_x", "force_y", "force"), 79e3 * 0.5e-3),
        (("time", "phase", "event_time", "event_phase"), 1.0 / rate),
        (("energy",), 79e3 * 0.5e-3**2 * 1e3),
        (("mu", "contact_angle"), 1.0),
    ):
        for name in names:
            expected = factor * run[name].values
            assert np.allclose(si[name].values, expected, rtol=1e-14, atol=1e-300), name
    scales = [0.5, 0.5, 0.5 * rate, 0.5 * rate, 0.5, 0.5, 1.0]
    assert np.allclose(si["state_after"].values, scales * run["state_after"].values, rtol=1e-14)
    assert np.array_equal(si["mode"], run["mode"])
    assert si.attrs["period"] == pytest.approx(1.0 / 30.1, rel=1e-14)
    assert si.attrs["rig_gap"] == 0.5
    assert "anchor_phase" not in si.attrs


def test_every_quantity_has_its_units(run, tmp_path):
    si = RIG.to_si(run)
    units = {"x": "mm", "vx": "mm/s", "force": "N", "energy": "mJ", "time": "s", "gap": "mm"}
    assert {name: si[name].attrs["units"] for name in units} == units
    assert si["contact_angle"].attrs["units"] == "rad"
    si.to_netcdf(tmp_path / "rig.nc")


def test_diagram_over_the_speed_in_hertz():
    diagram = ns.bifurcation_diagram(RIG.system(), "eta", [0.5, 0.6], transient=20, record=3)
    si = RIG.to_si(diagram)
    assert si["parameter"].values == pytest.approx([0.5 * 14.363088, 0.6 * 14.363088], rel=1e-7)
    ax = ns.plot.bifurcation(si, "x")
    assert ax.get_xlabel() == "speed of the rotor [Hz]"
    assert ax.get_ylabel().endswith("[mm]")
    assert np.allclose(si["x"], 0.5 * diagram["x"], rtol=1e-15)


@pytest.mark.few(2)
@pytest.mark.parametrize(
    ("name", "value", "unit"),
    [("nu1", 105.0, "kg/s"), ("K", 2354e3, "N/m"), ("eta_m", 0.028, "kg"), ("rho", 35.0, "mm"),
     ("delta_y", 0.1, "mm"), ("eps_x", 0.5, "mm"), ("phi0", 0.0, "rad")],
)  # fmt: skip
def test_axes_of_every_parameter(name, value, unit):
    """A diagram over any parameter has the machine's quantity on its axis."""
    here = RIG.parameters()[name]
    si = RIG.to_si(ns.bifurcation_diagram(RIG.system(), name, [here], transient=1, record=1))
    assert float(si["parameter"][0]) == pytest.approx(value, rel=1e-14)
    assert si["parameter"].attrs["units"] == unit


def test_regime_map_in_hertz_and_millimetres():
    grid = ns.regime_map(RIG.system(), {"eta": [0.5, 0.6], "delta_x": [0.1, 0.2]}, transient=30)
    si = RIG.to_si(grid)
    assert np.allclose(si["delta_x"], [0.05, 0.1], rtol=1e-15)
    assert np.allclose(si["eta"], np.array([0.5, 0.6]) * RIG.natural_frequency, rtol=1e-15)
    assert si["exponent"].attrs["units"] == "1/s"
    ax = ns.plot.regime_map(si)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("speed of the rotor [Hz]", "preload in x [mm]")


def test_spectrum_in_hertz(run):
    """Scaling the spectrum and taking that of the scaled run are the same."""
    scaled = RIG.to_si(ns.power_spectrum(run, "vx", transient=10))
    direct = ns.power_spectrum(RIG.to_si(run), "vx", transient=10)
    for name in ("frequency", "amplitude", "power_density", "harmonic"):
        assert np.allclose(scaled[name].values, direct[name].values, rtol=1e-11), name
    assert float(scaled["frequency"].values[scaled["harmonic"].values == 1.0][0]) == pytest.approx(
        30.1
    )
    assert scaled["amplitude"].attrs["units"] == "mm/s"
    assert scaled["power_density"].attrs["units"] == "(mm/s)^2/Hz"
    assert ns.plot.spectrum(scaled).get_xlabel() == "frequency [Hz]"


def test_exponents_per_second():
    spectrum = ns.lyapunov_spectrum(RIG.system(), transient=20, record=20)
    si, rate = RIG.to_si(spectrum), np.sqrt(79e3 / 9.7)
    for name in ("lyapunov_exponent", "standard_error"):
        assert np.allclose(si[name], rate * spectrum[name], rtol=1e-14, equal_nan=True)
    assert np.array_equal(si["exponent"], spectrum["exponent"])  # numbers of the exponents


@pytest.mark.slow
def test_run_up():
    """The speed may vary slowly; in SI units it is a variable in Hz."""
    text = RIG.system().to_toml() + '\n[slow]\neta = "0.5 + 0.001*t"\n'
    run = ns.simulate(ns.System.from_toml(text), periods=3)
    si = RIG.to_si(run)
    assert si["eta"].attrs["units"] == "Hz"
    assert np.allclose(si["eta"], RIG.natural_frequency * run["eta"], rtol=1e-15)


def test_statics_in_millimetres():
    options = {name: RIG.parameters()[name] for name in ("K", "delta_x", "delta_y")}
    ring = snubber_ring([1.5], [0.3], **options)
    si = RIG.to_si(ring)
    assert float(si["x"][0]) == 0.75
    assert float(si["force"][0]) == pytest.approx(39.5 * float(ring["force"][0]), rel=1e-14)
    curves = RIG.to_si(snubber_boundaries(delta_x=0.2, delta_y=0.2))
    assert float(np.abs(np.hypot(curves["x"][0], curves["y"][0]) - 0.5).max()) < 1e-15
    assert curves.attrs["extent"] == 1.0
    assert ns.plot.contact_regions(curves).get_xlabel().endswith("x [mm]")


def test_rotor_at_rest_on_the_ring():
    """Eccentricity 0.8 mm beyond the gap of 0.5 mm: springs k_r and 2 k_s in series."""
    rest = dataclasses.replace(RIG, eccentricity_x=0.8).static_equilibrium()
    force = 0.3e-3 / (1.0 / 79e3 + 1.0 / (2.0 * 2354e3))
    assert bool(rest["contact"])
    assert float(rest["force"]) == pytest.approx(force, rel=1e-12)
    assert float(rest["x"]) == pytest.approx(0.8 - 1e3 * force / 79e3, rel=1e-12)
    assert rest["force"].attrs["units"] == "N"
    clear = dataclasses.replace(RIG, eccentricity_x=0.4).static_equilibrium()
    assert not bool(clear["contact"])
    assert float(clear["x"]) == pytest.approx(0.4, rel=1e-15)


def test_from_si_undoes_to_si():
    """One value of each kind by hand; what comes back is what was given."""
    rate = np.sqrt(79e3 / 9.7)
    found = RIG.from_si({"x": 0.2, "vx": 15.0, "mu": 0.3, "eta": [10.0, 20.0], "delta_x": 0.1})
    assert found["x"] == pytest.approx(0.4, rel=1e-15)
    assert found["vx"] == pytest.approx(15.0 / (0.5 * rate), rel=1e-14)
    assert found["mu"] == 0.3
    assert found["eta"] == pytest.approx([10 * 2 * np.pi / rate, 20 * 2 * np.pi / rate])
    assert found["delta_x"] == pytest.approx(0.2, rel=1e-15)
    start = {"x": 0.2, "vy": 15.0}
    si = RIG.to_si(ns.simulate(RIG.system(), RIG.from_si(start), periods=1))
    assert {name: float(si[name][0]) for name in start} == pytest.approx(start, rel=1e-14)
    with pytest.raises(ns.OptionError, match="unknown state or parameter 'z'"):
        RIG.from_si({"z": 1.0})
    with pytest.raises(ns.OptionError, match=r"values\['x'\] = nan must be finite"):
        RIG.from_si({"x": float("nan")})
    with pytest.raises(ns.OptionError, match=r"x'\] = 'far' is no number"):
        RIG.from_si({"x": "far"})


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("mass", 0.0, "mass = 0 must be positive"),
        ("gap", 0.0, "gap = 0 must be positive: lengths"),
        ("ring_damping", -0.1, "ring_damping = -0.1 must not be negative.*returns at once"),
        ("rotor_damping", -1.0, "rotor_damping = -1 must not be negative"),
        ("preload_x", -0.1, "preload_x = -0.1 must not be negative: a preload presses"),
        ("preload_y", -0.1, "preload_y"),
        ("speed", 0.0, "the rotor must turn"),
        ("unbalance_mass", -0.01, "turn the phase"),
        ("rotor_stiffness", float("inf"), "not a finite number"),
        ("phase", "pi", "not a finite number"),
        ("gap", "0.4", "gap = '0.4' is not a finite number"),
        ("mass", True, "mass = True is not a finite number"),
    ],
)
def test_data_that_no_rig_has(name, value, message):
    with pytest.raises(ns.ModelError, match=message):
        RotorRig(**DATA | {name: value})


def test_results_of_others_are_refused(run):
    other = dataclasses.replace(RIG, gap=0.75)
    with pytest.raises(ns.OptionError, match="not made with the system of this rig"):
        other.to_si(run)
    with pytest.raises(ns.OptionError, match="in SI units already"):
        RIG.to_si(RIG.to_si(run))
    with pytest.raises(ns.OptionError, match="other values of delta_x, delta_y"):
        RIG.to_si(snubber_boundaries(delta_x=0.1, delta_y=0.1))
    with pytest.raises(ns.OptionError, match="other values of K"):
        RIG.to_si(static_contact(eps_x=1.0, delta_x=0.2, delta_y=0.2))
    with pytest.raises(ns.OptionError, match="does not say"):
        RIG.to_si(run.drop_attrs())
    faster = dataclasses.replace(RIG, speed=35.0)
    assert faster.to_si(run).attrs["rig_speed"] == pytest.approx(30.1)  # that of the run
