"""Every verb's result for a rotor rig in SI units: each number by its scale, none left out."""

import dataclasses

import matplotlib.pyplot as plt
import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.models import RotorRig, snubber_boundaries, snubber_ring, static_contact

RIG = RotorRig(
    mass=9.7, unbalance_mass=0.028, unbalance_radius=35.0, rotor_stiffness=79e3,
    ring_stiffness=2354e3, rotor_damping=105.0, ring_damping=3.5, gap=0.5, speed=13.1,
    eccentricity_x=0.5, preload_x=0.1, preload_y=0.1,
)  # fmt: skip
SYSTEM = RIG.system()
RATE = np.sqrt(79e3 / 9.7)  # rad/s
HZ, SECOND, NEWTON = RATE / (2 * np.pi), 1 / RATE, 79e3 * 0.5e-3
SHORT = {"transient": 20, "record": 8}
LONG = {"transient": 20, "record": 300}

# by hand: lengths by the gap of 0.5 mm, forces by 79 kN/m times it, times by sqrt(M / k_r)
MM, MM_S, N, S, HERTZ, PER_S = (
    (0.5, "mm"), (0.5 * RATE, "mm/s"), (NEWTON, "N"), (SECOND, "s"), (HZ, "Hz"), (RATE, "1/s"),
)  # fmt: skip
RAD, ONE = (1.0, "rad"), (1.0, None)
KG_S = (2.0 * np.sqrt(79e3 * 9.7), "kg/s")
STATES = {"x": MM, "y": MM, "vx": MM_S, "vy": MM_S, "sx": MM, "sy": MM, "mu": ONE}
MOTION = STATES | {
    "ring_vx": MM_S, "ring_vy": MM_S, "force_x": N, "force_y": N, "force": N,
    "contact_angle": RAD, "gap": MM, "energy": (NEWTON * 0.5, "mJ"),
}  # fmt: skip
EVENTS = {"event_time": S, "event_phase": S, "state_before": None, "state_after": None}
STATISTICS = ("mean", "rms", "in_contact", "min", "min_error", "max", "max_error", "percentile")
REGIME = {
    "events": ONE, "impacts": ONE, "exponent": PER_S, "exponent_error": PER_S, "K": ONE,
    "residual": ONE, "escape_rate_below": ONE,
}  # fmt: skip
# cycles per unit time are by RATE itself, while the speed is in radians per unit of time
FREQUENCY = {"frequency": (RATE, "Hz"), "harmonic": ONE}
PLANE = {"amplitude": MM, "power_density": (0.25 / RATE, "mm^2/Hz")}
WATERFALL = FREQUENCY | PLANE | {"phase": RAD, "period": S, "parameter": HERTZ}
ATTRACTOR = {
    "points": None, "fraction": ONE, "fraction_error": ONE, "multiplier_real": ONE,
    "multiplier_imag": ONE, "residual": ONE, "exponent": ONE, "exponent_error": ONE,
    "escape_rate_below": ONE,
}  # fmt: skip
INTEGRITY = dict.fromkeys(
    ("local_integrity", "local_error", "global_integrity", "global_error", "integrity_factor",
     "factor_error"), ONE,
) | {"factor_centre": None}  # fmt: skip
ORBIT = {
    **{name: MOTION[name] for name in STATES}, "time": S, "length": S, "residual": ONE,
    "log_determinant": ONE, "durations": S, "leg_time": S, "leg_states": None, "strobes": None,
    "strobe_times": S,
}  # fmt: skip
PICTURE = {
    **{name: MOTION[name] for name in STATES}, "length": S, "residual": ONE, "settled": None,
    "strobes": None, "strobe_times": S, "fraction": ONE, "fraction_error": ONE, "exponent": ONE,
    "exponent_error": ONE, "escape_rate_below": ONE, "unsettled": ONE, "ended": ONE,
    "parameter": HERTZ, "eta": HERTZ, "special_value": HERTZ, "arclength": ONE, "leg_time": S,
}  # fmt: skip
CONTACT = {
    "contacts": ONE, "contact_share": ONE, "contact_duration": S, "shortest_contact": S,
    "longest_contact": S, "percentile": ONE,
}  # fmt: skip


@pytest.fixture(autouse=True)
def no_figures_left():
    yield
    plt.close("all")


def run_of(**options):
    return ns.simulate(SYSTEM, **{"periods": 40} | options)


def basins(data):
    """Basins on a grid that is fine enough, with labels put in by hand."""
    found = ns.basins_of_attraction(
        SYSTEM, {"x": np.linspace(-0.4, 1.4, 4), "y": np.linspace(-0.3, 0.3, 4)},
        samples=8, record=200,
    )  # fmt: skip
    return data(found)


def fine_labels():
    x, y = np.meshgrid(np.linspace(-1, 1, 64), np.linspace(-1, 1, 64))
    return 1 + (np.sin(9 * x) > y).astype(int) + (np.sin(9 * x) > y + 0.5)


def of_this_system(data):
    return data.assign_attrs(system=SYSTEM.to_toml())


def run_up():
    return ns.simulate(RIG.run_up(10.0, 14.0, 4.0), periods=40)


BRANCH = {"eta": HERTZ, "special_value": HERTZ, "arclength": ONE}


def speeds_of_orbits():
    return ns.continue_orbit(SYSTEM, "eta", (0.91, 0.915), steps=5)


def saddle_curves():
    """Unstable manifold of the orbit beyond a flip."""
    branch = ns.continue_orbit(SYSTEM, "eta", (1.1, 1.2), parameters={"eta": 1.12})
    last = branch.isel(point=int(np.argmax(branch["eta"].values)))
    at = SYSTEM.with_parameters(eta=float(last["eta"]))
    return ns.manifold(at, last, length=1e-3)


# names alone tell what numbers mean, so a system with two states of a rotor stands for it
ESCAPE = ns.System(
    name="escape", states=["x", "vx"], period="2*pi/eta",
    parameters={"eta": 0.85, "nu1": 0.05, "F": 0.2},
    equations={"x": "vx", "vx": "where(x < 1, -x, x - 2) - 2*nu1*vx + F*cos(eta*t)"},
)  # fmt: skip
SADDLE = {"length": 8.0, "side": "-"}


def on_the_hill():
    return ns.find_orbit(ESCAPE, {"x": 2.0})


# of each verb: a result, and of each number in it what one is worth; None for a table of states
RESULTS = {
    "simulate": (lambda: run_of(tangent=True),
                 MOTION | EVENTS | {"time": S, "phase": S, "tangent": None, "sensitivity": None,
                                    "digits": ONE}),
    "simulate slowly": (run_up, MOTION | EVENTS | {"time": S, "phase": S, "eta": HERTZ}),
    "stroboscopic_map": (lambda: ns.stroboscopic_map(SYSTEM, record=5), MOTION | {"time": S}),
    "poincare_section": (lambda: ns.poincare_section(SYSTEM, section="y", record=5),
                         MOTION | {"time": S, "phase": S}),
    "bifurcation_diagram": (lambda: ns.bifurcation_diagram(SYSTEM, "eta", [0.9, 1.0], **SHORT),
                            MOTION | {"events": ONE, "impacts": ONE, "parameter": HERTZ}),
    "regime": (lambda: ns.regime(SYSTEM),
               REGIME | dict.fromkeys(
                   ("multiplier_real", "multiplier_imag", "multiplier_modulus"), ONE)),
    "regime_map": (lambda: ns.regime_map(
                       SYSTEM, {"eta": [0.9, 1.0], "delta_x": [0.1, 0.2]}, transient=50),
                   REGIME | {"multiplier": ONE, "eta": HERTZ, "delta_x": MM}),
    "power_spectrum": (lambda: ns.power_spectrum(run_of(), "force"),
                       FREQUENCY | {"amplitude": N, "power_density": (NEWTON**2 / RATE, "N^2/Hz")}),
    "full_spectrum": (lambda: ns.full_spectrum(run_of(), "x", "y"), FREQUENCY | PLANE),
    "waterfall": (lambda: ns.waterfall(SYSTEM, "eta", [0.9, 1.0], ("x", "y"), **SHORT), WATERFALL),
    "order_tracking": (lambda: ns.order_tracking(run_up(), ("x", "y")), WATERFALL | {"time": S}),
    "order_tracking in time": (lambda: ns.order_tracking(run_of(), ("x", "y")),
                               WATERFALL | {"time": S, "parameter": S}),
    "contact_statistics": (lambda: ns.contact_statistics(
                               SYSTEM, "eta", [0.9, 1.0], contact="contact", of=["force", "vx"],
                               **SHORT),
                           CONTACT | {"parameter": HERTZ}
                           | {f"force_{key}": N for key in STATISTICS}
                           | {f"vx_{key}": MM_S for key in STATISTICS}),
    "period_statistics": (lambda: ns.period_statistics(
                              run_up(), ["x", "force"], contact="contact"),
                          {"begin": S, "eta": HERTZ, "contacts": ONE, "contact_share": ONE}
                          | {f"x_{key}": MM for key in ("min", "max", "amplitude")}
                          | {f"force_{key}": N for key in ("min", "max", "amplitude")}),
    "local_regimes": (lambda: ns.local_regimes(run_up(), most_period=3, window=20),
                      {"time": S, "eta": HERTZ, "from_time": S, "to_time": S,
                       "from_eta": HERTZ, "to_eta": HERTZ, "drift": ONE, "net_drift": ONE}),
    "return_map": (lambda: ns.return_map(SYSTEM, "x", (-0.4, 1.4), samples=7),
                   dict.fromkeys(("start", "image", "deviation", "border_start", "image_before",
                                  "image_after", "fixed_start", "fixed_deviation"), MM)
                   | dict.fromkeys(("start_state", "image_state", "fixed_state"))
                   | dict.fromkeys(("slope", "fixed_slope", "spread", "largest_spread"), ONE)
                   | {"return_time": S}),
    "return_map of phases": (lambda: ns.return_map(
                                 ns.PoincareMap(SYSTEM, "y"), "phase",
                                 points=ns.poincare_section(SYSTEM, section="y", record=20)),
                             dict.fromkeys(("start", "image", "deviation", "turn",
                                            "return_time"), S)
                             | dict.fromkeys(("start_state", "image_state"))
                             | dict.fromkeys(("slope", "spread", "largest_spread",
                                              "exponent_per_return"), ONE)),
    "find_orbit": (lambda: ns.find_orbit(SYSTEM), ORBIT),
    "orbits": (lambda: ns.orbits(SYSTEM, samples=4, guesses=8, record=100), ORBIT),
    "continue_orbit": (speeds_of_orbits, ORBIT | BRANCH),
    "continue_special": (lambda: ns.continue_special(
                             ns.continue_orbit(SYSTEM, "eta", (1.1, 1.2), parameters={"eta": 1.12}),
                             1, "delta_x", (0.19, 0.21), steps=3),
                         ORBIT | BRANCH | {"delta_x": MM, "special_value": MM}),
    "criticality": (lambda: ns.criticality(speeds_of_orbits()),
                    {"special_value": HERTZ, "rotation_angle": RAD}
                    | dict.fromkeys(("coefficient", "coefficient_error", "parameter_coefficient",
                                     "parameter_coefficient_error", "amplitude_factor",
                                     "amplitude_power", "reach"), ONE)),
    "orbit_samples": (lambda: ns.orbit_samples(ns.find_orbit(SYSTEM)),
                      MOTION | {"time": S, "length": S}),
    "best_point": (lambda: ns.best_point(speeds_of_orbits(), "x"),
                   ORBIT | {"eta": HERTZ, "best": MM}),
    "bifurcation_picture": (
        lambda: ns.bifurcation_picture(
            SYSTEM, "eta", (0.91, 0.915), {"x": (-0.4, 1.4)}, columns=2, searches=0, samples=2,
            record=100, steps=5, longest=1,
        ),
        PICTURE,
    ),
    "manifold": (
        saddle_curves,
        {name: MOTION[name] for name in STATES}
        | dict.fromkeys(("arclength", "border_gap", "first_length"), ONE)
        | {"border_turn": RAD, "first_deviation": ONE, "saddle": None, "saddle_direction": None},
    ),
    "edge_state": (lambda: of_this_system(ns.edge_state(ESCAPE, {"x": 0.0}, {"x": 2.5, "vx": 1.0})),
                   {"x": MM, "vx": MM_S, "time": S}
                   | dict.fromkeys(("residual", "exponent", "exponent_error", "width", "crossing",
                                    "distance"), ONE)
                   | dict.fromkeys(("mean", "deviation", "track", "start", "nearest"))),
    "homoclinic_points": (
        lambda: of_this_system(ns.homoclinic_points(ESCAPE, on_the_hill(), **SADDLE)),
        {"x": MM, "vx": MM_S, "crossing_angle": RAD}
        | dict.fromkeys(("sense", "place", "position_error"), ONE),
    ),
    "homoclinic_tangency": (
        lambda: of_this_system(ns.homoclinic_tangency(
            ESCAPE, "nu1", (0.05, 0.2), on_the_hill(), **SADDLE)),
        {"x": MM, "vx": MM_S, "nu1": KG_S, "value_error": KG_S, "place": ONE},
    ),
    "integrity": (lambda: basins(ns.integrity), INTEGRITY),
    "erosion_profile": (lambda: ns.erosion_profile(
                            SYSTEM, "eta", [0.9, 0.91],
                            {"x": np.linspace(-0.4, 1.4, 3), "y": np.linspace(-0.3, 0.3, 3)},
                            samples=3, record=100),
                        INTEGRITY | {"parameter": HERTZ, "x": MM, "y": MM, "ended": ONE,
                                     "unsettled": ONE}),
    "attractors": (lambda: ns.attractors(SYSTEM, {"x": (-0.4, 1.4)}, samples=8, record=200),
                   ATTRACTOR),
    "basins_of_attraction": (lambda: basins(lambda found: found), ATTRACTOR | {"x": MM, "y": MM}),
    "basin_fractions": (lambda: basins(ns.basin_fractions), {"fraction": ONE,
                                                             "fraction_error": ONE}),
    "basin_entropy": (lambda: of_this_system(ns.basin_entropy(fine_labels())), dict.fromkeys(
                          ("basin_entropy", "basin_entropy_error", "boundary_basin_entropy",
                           "boundary_basin_entropy_error"), ONE)),
    "uncertainty_exponent": (lambda: of_this_system(ns.uncertainty_exponent(fine_labels())),
                             dict.fromkeys(("uncertainty_exponent", "standard_error", "fit",
                                            "boundary_dimension", "uncertain_fraction",
                                            "distance"), ONE)),
    "wada_test": (lambda: of_this_system(ns.wada_test(fine_labels())), dict.fromkeys(
                      ("distance", "fraction_within", "largest_distance"), ONE)),
    "box_dimension": (lambda: ns.box_dimension(ns.stroboscopic_map(SYSTEM, record=300)),
                      dict.fromkeys(("box_dimension", "standard_error", "fit"), ONE)),
    "correlation_dimension": (lambda: ns.correlation_dimension(
                                  ns.stroboscopic_map(SYSTEM, record=300)),
                              dict.fromkeys(("correlation_dimension", "standard_error", "fit",
                                             "correlation_sum", "distance"), ONE)),
    "ensemble": (lambda: ns.ensemble(SYSTEM, {"x": [0.1, 1.2]}, parameters={"eta": [0.9, 1.0]},
                                     transient=3, record=2),
                 MOTION | {"end_time": S, "eta": HERTZ, "initial_state": None, "end_state": None}),
    "ensemble in time": (lambda: ns.ensemble(SYSTEM, {"x": [0.1]}, times=[0.0, 1.0]),
                         MOTION | {"end_time": S, "time": S, "initial_state": None,
                                   "end_state": None}),
    "lyapunov_spectrum": (lambda: ns.lyapunov_spectrum(SYSTEM, transient=20, record=20),
                          {"lyapunov_exponent": PER_S, "standard_error": PER_S, "time": S,
                           "running_exponent": PER_S, "exponent_sum": PER_S,
                           "kaplan_yorke_dimension": ONE}),
    "zero_one_test": (lambda: ns.zero_one_test(ns.stroboscopic_map(SYSTEM, **LONG), "x"),
                      {"p": MM, "q": MM}
                      | dict.fromkeys(("K", "K_low", "K_high", "K_of_c", "c"), ONE)),
    "snubber_ring": (lambda: snubber_ring(
                         [1.5], [0.3], [0.2], [0.1], nu2=RIG.parameters()["nu2"], **preloads()),
                     {name: unit for name, unit in MOTION.items()
                      if name not in ("gap", "vx", "vy")} | {"normal_force": N}),
    "snubber_boundaries": (lambda: snubber_boundaries(delta_x=0.2, delta_y=0.2),
                           {"x": MM, "y": MM}),
    "static_contact": (lambda: static_contact(eps_x=1.0, **preloads()),
                       {name: unit for name, unit in MOTION.items()
                        if name not in ("gap", "vx", "vy", "ring_vx", "ring_vy")}
                       | {"normal_force": N}),
}  # fmt: skip
NO_RESULTS = {  # verbs, and what else there is, that give no dataset of a motion of their own
    "structures", "Structure", "cluster",
    "PoincareMap", "StroboscopicMap", "System", "Exit", "Mode", "Signal", "excitation", "fatigue",
    "continuation", "measured", "models", "plot", "phase_word", "tie_parameters", "__version__",
    "Surface", "smoothed", "smoothing_report", "mirrored_orbit", "fit", "posterior", "explore",
    "use_device",
}  # fmt: skip


SLOW = {
    "best_point", "continue_special", "homoclinic_points", "homoclinic_tangency", "manifold",
    "order_tracking", "simulate slowly",
}  # fmt: skip


def preloads():
    return {name: RIG.parameters()[name] for name in ("K", "delta_x", "delta_y")}


@pytest.mark.few(4)
@pytest.mark.filterwarnings("ignore::nonsmooth.ResultWarning")
@pytest.mark.parametrize(
    "verb", [pytest.param(each, marks=[pytest.mark.slow] * (each in SLOW)) for each in RESULTS]
)
def test_each_number_by_its_scale(verb, tmp_path):
    make, expected = RESULTS[verb]
    data = make()
    si = RIG.to_si(data)
    numbers = {str(n) for n in si.variables if si[n].dtype.kind == "f"}
    assert numbers == set(expected)
    for name, what in expected.items():
        if what is None:
            continue
        factor, unit = what
        assert np.allclose(
            si[name], factor * data[name].values, rtol=1e-13, atol=0.0, equal_nan=True
        ), name
        assert si[name].attrs.get("units") in ((unit,) if unit else (None, "dimensionless")), name
    si.to_netcdf(tmp_path / "rig.nc")


def test_no_verb_is_left_out():
    errors = {name for name in ns.__all__ if name.endswith(("Error", "Warning"))}
    walked = {verb.split()[0] for verb in RESULTS}
    assert set(ns.__all__) - NO_RESULTS - errors <= walked


@pytest.mark.slow
def test_the_mirror_image_of_an_orbit():
    """Of a rotor in the middle of its ring, where all springs are alike: minus the orbit."""
    rig = dataclasses.replace(RIG, eccentricity_x=0.0)
    images = {state: f"-{state}" for state in STATES if state != "mu"}
    orbit = ns.find_orbit(dataclasses.replace(rig.system(), symmetry=images))
    image = ns.mirrored_orbit(orbit)
    assert image["symmetric"].item() == orbit["symmetric"].item()
    si = rig.to_si(image)
    for name in STATES:
        factor, unit = STATES[name]
        assert float(si[name]) == pytest.approx(factor * float(image[name]), rel=1e-13)
        assert si[name].attrs.get("units") in ((unit,) if unit else (None, "dimensionless"))


def test_tables_of_states():
    """Each column by its own scale, derivatives by those of both."""
    scales = np.array([0.5, 0.5, 0.5 * RATE, 0.5 * RATE, 0.5, 0.5, 1.0])
    run = run_of(periods=3, tangent=True)
    si = RIG.to_si(run)
    assert np.allclose(si["state_before"], scales * run["state_before"], rtol=1e-14)
    assert np.allclose(si["tangent"], run["tangent"] * scales[:, None] / scales, rtol=1e-13)
    # mm per Hz, kg/s, kg/s, N/m, kg, mm, ..., rad
    critical = 2 * np.sqrt(79e3 * 9.7)
    below = np.array([HZ, critical, critical, 79e3, 9.7, *[0.5] * 5, 1.0])
    expected = run["sensitivity"].values * scales[:, None] / below
    assert np.allclose(si["sensitivity"], expected, rtol=1e-13)
    assert list(si["state_units"].values) == ["mm", "mm", "mm/s", "mm/s", "mm", "mm", ""]
    one = RIG.to_si(run.isel(state=0))
    assert np.allclose(one["state_after"], 0.5 * run["state_after"][:, 0], rtol=1e-15)


def test_tables_of_states_on_a_border_and_of_a_region():
    """Positions by the gap of 0.5 mm, velocities by that times the rate."""
    edge = RESULTS["edge_state"][0]()
    si, scales = RIG.to_si(edge), np.array([0.5, 0.5 * RATE])
    for name in ("mean", "deviation", "track", "start", "nearest"):
        assert np.allclose(si[name], edge[name] * scales, rtol=1e-14, equal_nan=True), name
    alone = RIG.to_si(edge.isel(state=1))
    assert np.allclose(alone["start"], 0.5 * RATE * edge["start"][:, 1], rtol=1e-14)
    found = basins(ns.integrity)
    centres = RIG.to_si(found)["factor_centre"]
    assert np.allclose(centres, 0.5 * found["factor_centre"], rtol=1e-14, equal_nan=True)


def test_sensitivity_is_a_difference_quotient_in_millimetres_per_hertz():
    """Runs of two rigs that differ by 1e-4 Hz, at one time in s."""
    si = RIG.to_si(run_of(periods=2, tangent=True))
    time = si["time"].values[150]
    found = []
    for speed in (13.1 - 1e-4, 13.1 + 1e-4):
        rig = dataclasses.replace(RIG, speed=speed)
        times = [0.0, rig.from_si({"time": time})["time"]]
        found.append(float(rig.to_si(ns.simulate(rig.system(), times=times))["x"][-1]))
    slope = (found[1] - found[0]) / 2e-4
    assert float(si["sensitivity"].sel(state="x", parameter_0="eta")[150]) == pytest.approx(
        slope, rel=1e-5
    )


def test_unknown_numbers_are_refused():
    run = run_of(periods=1)
    strange = run.assign(power=run["force"] * run["vx"])
    with pytest.raises(ns.OptionError, match="the unit of 'power' is not known"):
        RIG.to_si(strange)
    strange["power"].attrs["units"] = "W"
    assert np.array_equal(RIG.to_si(strange)["power"], strange["power"])


BOTH = {"delta_x": "delta", "delta_y": "delta"}


@pytest.mark.slow
def test_two_preloads_as_one_parameter():
    """Tied parameters have the unit and the words of what follows them; grids go the other way."""
    tied = ns.tie_parameters(SYSTEM, BOTH, delta=0.2)
    grid = RIG.from_si({"eta": [12.0, 14.0], "delta": [0.05, 0.1]}, like={"delta": "delta_x"})
    assert grid["delta"] == [0.1, 0.2]
    si = RIG.to_si(ns.regime_map(tied, grid, transient=30))
    assert np.allclose(si["delta"], [0.05, 0.1], rtol=1e-15)
    ax = ns.plot.regime_map(si)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("speed of the rotor [Hz]", "preload [mm]")
    diagram = RIG.to_si(ns.bifurcation_diagram(tied, "delta", [0.1, 0.2], transient=5, record=2))
    assert ns.plot.bifurcation(diagram, "x").get_xlabel() == "preload [mm]"
    assert "rig_preload_x" not in diagram.attrs
    assert diagram.attrs["rig_gap"] == 0.5


@pytest.mark.slow
@pytest.mark.parametrize(
    ("ties", "unit"),
    [({"delta_y": "p"}, "mm"), ({"delta_y": "0.1 + 2*p"}, "mm"), ({"K": "p*pi"}, "N/m")],
)
def test_units_that_follow(ties, unit):
    tied = ns.tie_parameters(SYSTEM, ties, p=0.2 if unit == "mm" else 9.5)
    si = RIG.to_si(ns.bifurcation_diagram(tied, "p", [0.2, 0.3], transient=5, record=2))
    assert si["parameter"].attrs["units"] == unit
    factor = {"mm": 0.5, "N/m": 79e3}[unit]
    assert np.allclose(si["parameter"], factor * np.array([0.2, 0.3]), rtol=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize(
    "ties", [{"delta_y": "p*delta_x"}, {"delta_y": "p**2"}, {"delta_x": "p", "nu1": "p"}]
)
def test_units_that_do_not_follow_are_asked_for(ties):
    tied = ns.tie_parameters(SYSTEM, ties, p=0.2)
    diagram = ns.bifurcation_diagram(tied, "p", [0.2, 0.3], transient=5, record=2)
    with pytest.raises(ns.OptionError, match="the unit of 'p' does not follow from"):
        RIG.to_si(diagram)
    si = RIG.to_si(diagram, like={"p": None})
    assert si["parameter"].values.tolist() == [0.2, 0.3]
    assert ns.plot.bifurcation(si, "x").get_xlabel() == "p"
    assert RIG.to_si(diagram, like={"p": "nu2"})["parameter"].attrs["units"] == "kg/s"
    with pytest.raises(ns.OptionError, match="like: unknown new parameter 'q'"):
        RIG.to_si(diagram, like={"q": "nu2"})
    with pytest.raises(ns.OptionError, match="like: unknown parameter 'stiffness'"):
        RIG.to_si(diagram, like={"p": "stiffness"})
    with pytest.raises(ns.OptionError, match="'K' is a parameter of the rig"):
        RIG.from_si({"K": 1.0}, like={"K": "nu2"})


def test_ties_hide_no_other_rig():
    other = dataclasses.replace(RIG, rotor_damping=90.0)
    run = ns.simulate(ns.tie_parameters(SYSTEM, BOTH, delta=0.2), periods=1)
    with pytest.raises(ns.OptionError, match="not made with the system of this rig"):
        other.to_si(run)


def test_changed_parameters_in_their_units():
    """Attributes tell the machine that the numbers are of."""
    changed = {"delta_x": 0.3, "eta": 1.0}
    for data in (
        ns.bifurcation_diagram(SYSTEM, "nu2", [2e-3], transient=5, record=2, parameters=changed),
        ns.simulate(SYSTEM, periods=1, parameters=changed),
    ):
        si = RIG.to_si(data)
        assert si.attrs["changed_parameters"] == "delta_x = 0.15 mm, eta = 14.3631 Hz"
        assert si.attrs["rig_preload_x"] == 0.15
        assert si.attrs["rig_speed"] == pytest.approx(RIG.natural_frequency)
    diagram = RIG.to_si(ns.bifurcation_diagram(SYSTEM, "nu2", [2e-3], transient=5, record=2))
    assert float(diagram["parameter"][0]) == pytest.approx(4e-3 * np.sqrt(79e3 * 9.7))
    assert "rig_ring_damping" not in diagram.attrs


@pytest.mark.slow
def test_run_up_in_hertz_over_seconds():
    """10 to 14 Hz within 4 s: constant within a revolution, that at its beginning."""
    si = RIG.to_si(run_up())
    begin = si["time"] - si["phase"]
    inner = si["phase"].values > 0.0
    assert np.allclose(si["eta"][inner], 10.0 + begin[inner], rtol=1e-12)
    down = RIG.run_up(14.0, 10.0, 4.0)
    end = RIG.to_si(ns.simulate(down, t_end=RIG.from_si({"time": 4.0})["time"]))
    assert 4.0 - 0.011 / 10.0 < float(end["time"][-1]) <= 4.0  # a sample before the end
    assert float(end["eta"][-1]) == pytest.approx(10.0, abs=0.2)
    for bad in ((0.0, 10.0, 1.0), (10.0, -1.0, 1.0), (10.0, 20.0, 0.0), (10.0, 20.0, np.inf)):
        with pytest.raises(ns.OptionError, match="a positive number"):
            RIG.run_up(*bad)


def test_slow_preload():
    """Any parameter may vary slowly."""
    slow = dataclasses.replace(SYSTEM, slow={"delta_x": "0.1 + 0.001*t"})
    run = ns.simulate(slow, periods=3)
    si = RIG.to_si(run)
    assert si["delta_x"].attrs == {"long_name": "preload in x", "units": "mm"}
    assert np.allclose(si["delta_x"], 0.5 * run["delta_x"], rtol=1e-15)


def test_labels_of_pictures():
    attractors = RIG.to_si(ns.attractors(SYSTEM, {"x": (-0.4, 1.4)}, samples=8, record=200))
    ax = ns.plot.attractors(attractors, "x", "vx")
    assert ax.get_xlabel().split() == ["displacement", "of", "the", "rotor", "in", "x", "[mm]"]
    assert ax.get_ylabel().split() == ["velocity", "of", "the", "rotor", "in", "x", "[mm/s]"]
    up = RIG.to_si(ns.period_statistics(run_up(), "x"))
    ax = ns.plot.statistics(up, "x_amplitude")
    assert ax.get_xlabel() == "speed of the rotor [Hz]"
    assert ax.lines[0].get_label() == "speed of the rotor rises"
    assert ns.plot.statistics(up, "x_max", over="begin").get_xlabel().endswith("[s]")
    test = ns.zero_one_test(ns.stroboscopic_map(SYSTEM, **LONG), "force")
    assert ns.plot.translation(RIG.to_si(test)).get_ylabel() == "q [N]"
    assert ns.plot.translation(test).get_ylabel() == "q"


def test_verbs_on_runs_in_si_units():
    """What reads a run in SI units says the same as what is turned afterwards, or why it cannot."""
    run = run_of()
    si = RIG.to_si(run)
    one = ns.full_spectrum(si, "x", "y", transient=20)
    other = RIG.to_si(ns.full_spectrum(run, "x", "y", transient=20))
    for name in ("frequency", "amplitude", "power_density"):
        assert np.allclose(one[name], other[name].values, rtol=1e-9, atol=1e-15), name
        assert one[name].attrs == other[name].attrs, name
    with pytest.raises(ns.OptionError, match="does not say of which system it is"):
        ns.period_statistics(si, "x", contact="contact")
    with pytest.raises(ns.OptionError, match="does not say of which system it is"):
        ns.plot.phase_portrait(si, "x", "y", surfaces=True)
