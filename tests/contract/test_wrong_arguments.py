"""Whatever is given for an argument of a verb, the answer is a result or one clear error, at once.

The arguments are those of the signatures. Each of them is given every wrong value below, beside
small and right values for the others. What comes must be a result, or an error of this library
that names the argument, within a second of the processor. What is refused must be refused as fast
where the other values ask for long work, so it is looked at before the work begins.
"""

import inspect
import time
import warnings
from datetime import date
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns


class Odd:
    """A thing that no argument takes."""

    def __repr__(self):
        return "<odd>"


WRONG = {
    "a thing of another class": Odd(),
    "a text": "no_such",
    "an empty text": "",
    "bytes": b"ab",
    "a complex number": 1j,
    "nan": float("nan"),
    "infinity": float("inf"),
    "a negative count": -3,
    "a number between whole ones": 2.5,
    "a whole number beyond doubles": 10**400,
    "a truth value": True,
    "nothing": None,
    "an empty list": [],
    "an empty mapping": {},
    "a list of an unknown name": ["no_such"],
    "lists of different lengths": [[1], [2, 3]],
    "an unknown name": {"no_such": 1.0},
    "a name that is no text": {1: 2.0},
    "an empty array": np.array([]),
    "an array with nan": np.array([np.nan, 1.0]),
    "a matrix": np.zeros((2, 2)),
    "a range that runs backward": (1.0, -1.0),
    "an empty dataset": xr.Dataset(),
    "a function": len,
    "a date": date(2020, 1, 1),
    "a missing file": Path("no_such_folder/no_such_file"),
}
# Messages that name something nearer to the cause than the argument that was changed.
TOLD_OTHERWISE = {
    ("continue_orbit", "initial"): "orbit to begin with",
    ("full_spectrum", "y"): "variable",
    ("phase_word", "run"): "the dataset has no event log",
    ("wada_test", "leave_out"): "basins",
    ("zero_one_test", "data"): "variable",
    ("zero_one_test", "every"): "series",
    ("Surface", "function"): "no expression",
    ("System", "states"): "state",
    ("from_arrays", "displacements"): ": ",
    ("System", "equations"): "state",
    ("compare_stiffness_laws", "reference"): "crack = ",
    ("compare_stiffness_laws", "length"): "crack = ",
    ("count_cycles", "load"): "times: ",
    ("cubic_stiffness", "length"): "crack = ",
    ("Excitation", "acceleration"): "times: ",
    ("LoadBlock.from_record", "load"): "times: ",
    ("Differentiator.for_band", "step"): "samples 2.5 apart",
}
# Arguments that are functions of the caller, whose own errors go through.
FUNCTIONS = {"stress_intensity", "loads", "reference", "structure"}
STRUCK = ns.models.soft_impact()
RUBBING = ns.System(
    states=["x", "v"],
    parameters={"mu": 0.6, "omega": 0.5},
    period="2*pi/omega",
    equations={"x": "v", "v": "cos(omega*t) - x - mu*sign(v)"},
)
EVEN = ns.System(
    states=["x", "v"],
    parameters={"omega": 0.5},
    period="2*pi/omega",
    equations={"x": "v", "v": "cos(omega*t) - x - x**3 - 0.2*v"},
    symmetry={"x": "-x", "v": "-v"},
)
WELLS = ns.System(
    states=["x", "v"],
    period="2*pi",
    equations={"x": "v", "v": "where(abs(x) < 1, x, 2*sign(x) - x) - 0.2*v"},
)
HILL = ns.System(
    states=["x", "v"],
    parameters={"k": 1.0},
    period="2*pi",
    equations={"x": "v", "v": "k*x + cos(t)"},
)
REGION = {"x": (-1.0, 1.0), "v": (-1.0, 1.0)}
CELLS = {"x": np.linspace(-1.0, 1.0, 3), "v": np.linspace(-1.0, 1.0, 3)}
COLUMNS = {"parameter": "omega", "values": [0.8, 0.9], "transient": 2, "record": 4}
SEARCH = {"samples": 2, "record": 20, "longest": 50}
SHORT = {"transient": 5, "record": 4, "evidence": 20, "longest": 5, "confirm": 0}
SOON = 3.0  # seconds: what begins before arguments are read takes minutes here
LATE = {"transient": 100_000, "record": 1000, "evidence": 50_000, "longest": 200_000}


@cache
def data(name):
    """What verbs work on."""
    make = {
        "run": lambda: ns.simulate(STRUCK, periods=20, samples_per_period=32),
        "points": lambda: ns.stroboscopic_map(STRUCK, transient=10, record=300),
        "orbit": lambda: ns.find_orbit(STRUCK, transient=300),
        "saddle": lambda: ns.find_orbit(STRUCK, {"x": -0.2032, "v": 1.011}),
        "even orbit": lambda: ns.find_orbit(EVEN),
        "branch": lambda: ns.continue_orbit(
            STRUCK, "omega", (0.7, 0.9), initial=data("orbit"), steps=3
        ),
        "special": lambda: ns.continue_orbit(ns.models.soft_impact(a=0.2), "a", (0.05, 0.6)),
        "grazing": lambda: data("special")["special_kind"].values.tolist().index("grazing"),
        "flip": lambda: data("special")["special_kind"].values.tolist().index("flip"),
        "basins": lambda: xr.Dataset(
            {"label": (("y", "x"), np.repeat([1, 2, 3], 20) * np.ones((60, 1), int))}
        ),
        "hilltop": lambda: ns.find_orbit(HILL, {"x": -0.5}),
        "cells": lambda: ns.basins_of_attraction(WELLS, CELLS, samples=4),
        "fit": lambda: ns.fit(SPRING, swing(), {"k": (1.0, 9.0)}, starts=1),
        "cloud": lambda: np.random.default_rng(0).normal(size=(3000, 2)),
    }
    return make[name]()


SPRING = ns.System(states=["x", "v"], parameters={"k": 3.0}, equations={"x": "v", "v": "-k*x"})


def swing():
    """A short record of a spring of stiffness 4."""
    times = np.linspace(0.0, 4.0, 40)
    noise = 0.01 * np.random.default_rng(1).standard_normal(times.size)
    return xr.Dataset({"x": ("time", np.cos(2.0 * times) + noise)}, {"time": times})


def cases():
    """Right values of each verb, and those of them that ask for long work."""
    section = ns.PoincareMap(STRUCK, "v")
    strobes = ns.StroboscopicMap(STRUCK)
    struck = {"system": STRUCK}
    many = np.linspace(0.5, 1.0, 4000)
    return {
        "simulate": (struck | {"periods": 1}, {"periods": 200_000}),
        "stroboscopic_map": (struck | {"record": 3}, {"record": 500_000}),
        "poincare_section": (struck | {"section": "v", "record": 3}, {"record": 500_000}),
        "bifurcation_diagram": (struck | COLUMNS, {"values": many, "record": 100}),
        "fit": (
            {"system": SPRING, "record": swing(), "free": {"k": (1.0, 9.0)}, "starts": 1},
            {},
        ),
        "posterior": (
            {"found": data("fit"), "draws": 10, "transient": 0},
            {"draws": 100_000, "transient": 100_000},
        ),
        "ensemble": (struck | {"initial": {"x": [0.0, 0.1]}, "record": 2}, {"record": 100_000}),
        "lyapunov_spectrum": (
            struck | {"transient": 2, "record": 4, "confirm": 0},
            {"transient": 20_000, "record": 100_000},
        ),
        "regime": (struck | SHORT, LATE),
        "regime_map": (struck | {"over": {"omega": [0.8, 0.9], "a": [0.6, 0.7]}} | SHORT, LATE),
        "waterfall": (struck | COLUMNS | {"variable": "x"}, {"values": many, "record": 60}),
        "contact_statistics": (struck | {"transient": 2, "record": 4}, {"record": 1_000_000}),
        "find_orbit": (struck | {"transient": 100}, {"transient": 500_000}),
        "continue_orbit": (
            struck | {"parameter": "omega", "between": (0.7, 0.9), "initial": data("orbit")}
            | {"steps": 2}, {},
        ),
        "continue_special": (
            {"branch": data("special"), "special": data("grazing"), "parameter": "omega"}
            | {"between": (0.7, 0.9), "steps": 2}, {},
        ),
        "criticality": ({"branch": data("special"), "special": data("flip")}, {}),
        "attractors": ({"system": strobes, "region": REGION} | SEARCH, {"samples": 10_000}),
        "basins_of_attraction": (
            {"system": strobes, "region": CELLS} | SEARCH, {"samples": 10_000},
        ),
        "erosion_profile": (
            {"system": strobes, "parameter": "omega", "values": [0.8], "region": CELLS} | SEARCH,
            {"samples": 10_000, "values": many},
        ),
        "integrity": ({"basins": data("cells")}, {}),
        "bifurcation_picture": (
            {"system": strobes, "region": REGION, "parameter": "omega", "between": (0.8, 0.9)}
            | {"columns": 2, "searches": 0, "samples": 2, "record": 20, "steps": 2},
            {"samples": 10_000},
        ),
        "edge_state": (
            {"system": WELLS, "start_a": {"x": -1.7}, "start_b": {"x": 2.3}, "iterates": 20},
            {"iterates": 1_000_000},
        ),
        "orbits": (struck | {"samples": 2, "record": 20, "guesses": 2}, {"samples": 10_000}),
        "manifold": (
            struck | {"orbit": data("saddle"), "length": 0.1, "largest_step": 0.02},
            {"length": 1e6, "largest_step": 1e-3, "steps": 10_000_000},
        ),
        "homoclinic_points": (
            {"system": HILL, "orbit": data("hilltop"), "length": 0.1, "largest_step": 0.02},
            {"length": 1e6, "largest_step": 1e-3, "steps": 10_000_000},
        ),
        "homoclinic_tangency": (
            {"system": HILL, "orbit": data("hilltop"), "length": 0.1, "largest_step": 0.02}
            | {"parameter": "k", "between": (1.0, 1.1)},
            {"length": 1e6, "largest_step": 1e-3, "steps": 10_000_000},
        ),
        "return_map": (
            {"system": section, "coordinate": "x", "between": (0.0, 1.0), "samples": 3},
            {"samples": 100_000},
        ),
        "smoothing_report": (
            {"system": RUBBING, "epsilons": (0.1, 0.01), "periods": 1, "samples": 20},
            {"samples": 1_000_000, "region": REGION, "parameter": "mu", "between": (0.5, 0.7)},
        ),
        "smoothed": ({"system": RUBBING, "epsilon": 0.1}, {}),
        "tie_parameters": (struck | {"ties": {"zeta": "0.1*a"}}, {}),
        "basin_entropy": ({"basins": data("basins")}, {}),
        "basin_fractions": ({"basins": data("basins")}, {}),
        "uncertainty_exponent": ({"basins": data("basins")}, {}),
        "wada_test": ({"basins": data("basins")}, {}),
        "best_point": ({"branch": data("branch"), "quantity": "length"}, {}),
        "box_dimension": ({"points": data("cloud")}, {}),
        "correlation_dimension": ({"points": data("cloud")[:300]}, {}),
        "full_spectrum": ({"run": data("run"), "x": "x", "y": "v"}, {}),
        "power_spectrum": ({"run": data("run"), "variable": "x"}, {}),
        "order_tracking": ({"run": data("run"), "variable": "x"}, {}),
        "period_statistics": ({"run": data("run")}, {}),
        "phase_word": ({"run": data("run")}, {}),
        "use_device": ({"name": "cpu"}, {}),
        "local_regimes": ({"data": data("points")}, {}),
        "zero_one_test": ({"data": data("points"), "variable": "x"}, {}),
        "mirrored_orbit": ({"orbit": data("even orbit")}, {}),
        "orbit_samples": ({"orbit": data("orbit")}, {}),
        "PoincareMap": (struck | {"section": "v"}, {}),
        "StroboscopicMap": (struck, {}),
        "Exit": ({"guard": "x"}, {}),
        "Mode": ({"flow": {"x": "v"}}, {}),
        "Structure": ({"mass": np.eye(2), "stiffness": np.eye(2)}, {}),
        "Surface": ({"function": "v"}, {}),
        "Signal": ({"times": [0.0, 1.0, 2.0, 3.0], "values": [0.0, 1.0, 0.0, 1.0]}, {}),
        "System": ({"states": ["x", "v"], "equations": {"x": "v", "v": "-x"}}, {}),
    }  # fmt: skip


@cache
def rig():
    """Right values of the functions that read and treat measured motions."""
    measured, t = ns.measured, np.arange(1200) / 2000
    record = measured.from_arrays(
        {"x": np.cos(90 * t), "y": np.sin(90 * t)}, times=t, pulse=np.cos(90 * t - 0.4)
    )
    moving = measured.velocities(record)
    return {
        "from_arrays": {"displacements": {"x": np.cos(90 * t)}, "times": t},
        "velocities": {"record": record},
        "section": {"record": moving},
        "diagram": {"records": [moving, moving]},
        "low_pass": {"data": record, "cutoff": 100.0},
        "displacements": {"data": record, "accelerations": "x", "lowest": 20.0},
        "dimensionless": {"record": record, "length": 1.0, "natural_frequency": 2.0},
        "synchronous": {"record": moving},
        "alarm": {"healthy": xr.Dataset({"a": ("window", np.sin(np.arange(400.0)))})},
        "roc": {
            "healthy": xr.Dataset({"a": ("window", np.sin(np.arange(400.0)))}),
            "faulty": xr.Dataset({"a": ("window", np.arange(9.0))}),
        },
        "indicators": {"record": record, "periods": 6, "most_period": 2},
        "Channel": {"column": "x"},
        "Differentiator": {"step": 0.1, "window": 11},
    }


def shared_map(folder):
    """Right values of the functions that share a map among workers."""
    over = {"omega": [0.8, 0.9], "a": [0.6, 0.7]}
    planned, begun = folder / "planned.zarr", {"store": folder / "map.zarr", "system": STRUCK}
    ns.cluster.plan_map(planned, STRUCK, over, **SHORT)
    return {
        "plan_map": (begun | {"over": over} | SHORT, {}),
        "forecast": ({"store": planned, "sample": 8, "threads": 1}, {}),
        "work": ({"store": planned, "threads": 1}, {}),
        "progress": ({"store": planned}, {}),
        "open_map": ({"store": planned}, {}),
    }


VERBS = sorted(set(ns.__all__) - {
    "ModelError", "NonsmoothError", "OptionError", "ResultWarning", "RunError", "RunWarning",
    "__version__", "cluster", "continuation", "explore", "excitation", "fatigue", "measured",
    "models", "plot", "structures",
})  # fmt: skip
RIG = ["alarm", "indicators", "roc", "from_arrays", "velocities", "section", "diagram", "low_pass",
       "displacements", "dimensionless", "synchronous", "Channel", "Differentiator"]  # fmt: skip


def plate(load, crack):
    """Stress intensity of a wide plate."""
    return load * np.sqrt(np.pi * crack * 1e-3)


@cache
def fatigue():
    """Right values of the functions of fatigue."""
    f, t = ns.fatigue, np.linspace(0.0, 1.0, 200)
    block, law = f.LoadBlock.constant_amplitude(50.0, 50.0, frequency=20.0), f.Paris(1e-8, 4.0)
    grown = {"stress_intensity": plate, "law": law, "initial": 2.0, "final": 10.0}
    tests = {"tests": f.chapter_tests().isel(test=slice(3)), "stress_intensity": plate, "law": law}
    wave = 100.0 * np.sin(40.0 * np.pi * t)
    return {
        "LoadTable": {"cracks": [6.0, 16.0], "blocks": [block, block]},
        "Specimen": {},
        "Paris": {"C": 1e-8, "m": 3.0},
        "bilinear_frequency": {"closed": 100.0, "opened": 50.0},
        "compare_lives": tests,
        "compare_stiffness_laws": {"crack": [5.0, 10.0]},
        "compare_stress_intensity": {"crack": [5.0, 10.0]},
        "count_cycles": {"load": wave, "times": t},
        "cubic_stiffness": {"crack": 5.0},
        "cubic_text": {},
        "effective_range": {"K_min": -10.0, "K_max": 10.0},
        "fit_law": tests,
        "growth_by_frequency": {
            "cycles": f.count_cycles(wave, t), "stress_intensity": plate, "law": law,
            "crack": 6.4, "edges": [50.0],
        },
        "guinea_stiffness": {"crack": 5.0},
        "guinea_text": {},
        "life": grown | {"loads": block},
        "life_by_cycle": grown
        | {"loads": f.LoadBlock.constant_amplitude(200.0, 200.0, frequency=20.0)},
        "life_ratio": grown | {"reference": block, "loads": block},
        "reversals": {"values": [0.0, 1.0, 2.0, 1.0, 3.0]},
    }  # fmt: skip


@cache
def excitation():
    """Right values of the functions of excitation."""
    x, t = ns.excitation, np.arange(400) / 400.0
    sine, noise = x.harmonic(20.0, 3.0, duration=1.0), x.band_noise(duration=2.0)
    rig = x.ShakenSpecimen(lambda crack: 1200.0 * (1.0 - crack / 20.0) ** 3, 1200.0)
    shaken = {
        "rig": rig, "reference": sine, "stress_intensity": plate, "cracks": [6.4, 10.0],
        "transient": 0.2,
    }  # fmt: skip
    return {
        "Excitation": {"times": t, "acceleration": np.sin(40.0 * t)},
        "band_noise": {"duration": 2.0},
        "equal_power": {"record": noise, "reference": sine},
        "harmonic": {"duration": 1.0},
        "power_ratio": {"record": noise, "reference": sine},
        "lives_under_shaking": shaken | {"record": noise, "law": ns.fatigue.Paris(1e-10, 3.0)},
        "spread_of_life_ratio": shaken
        | {"records": {"noise": noise}, "laws": {"Paris": ns.fatigue.Paris(1e-10, 3.0)},
           "mean_loads": (0.0,), "dampings": (0.014,), "measures": ("acceleration",)},
    }  # fmt: skip


@cache
def structures():
    """Right values of the functions of structures."""
    s = ns.structures
    shaft = s.shaft([s.Beam(0.2, 0.05)] * 2, bearings=[s.Bearing(["0x", "0y"], 1e7, 10.0)])
    held = shaft.fixed(["2x", "2y"])
    return {
        "Beam": {"length": 0.2, "diameter": 0.05},
        "Bearing": {"coordinates": ["1x"], "stiffness": 1e6},
        "Disc": {"node": 1, "mass": 2.0, "diametral_inertia": 0.1, "polar_inertia": 0.2},
        "Structure": {"mass": np.eye(2), "stiffness": np.eye(2)},
        "campbell": {"structure": held, "speeds": [0.0, 100.0]},
        "frequency_response": {"structure": held, "frequencies": [1.0, 2.0]},
        "natural_modes": {"structure": held},
        "BaseMotion": {"direction": "x", "acceleration": 1.0},
        "DryFriction": {"coordinate": "1x", "force": 1.0},
        "Force": {"coordinate": "1x", "force": 1.0},
        "GapSpring": {"coordinate": "1x", "gap": 0.1, "stiffness": 2.0},
        "ReducedStructure": {
            "structure": held,
            "keep": ("1x",),
            "basis": np.ones((10, 1)),
            "squares": np.ones(1),
            "method": "free-interface",
        },
        "RubRing": {"x": "1x", "y": "1y", "gap": 0.1, "stiffness": 2.0, "radius": 0.1},
        "SnubberRing": {"x": "1x", "y": "1y", "gap": 0.1, "stiffness": 2.0, "damping": 0.1},
        "Stop": {"coordinate": "1x", "gap": 0.1, "restitution": 0.5},
        "Unbalance": {"x": "1x", "y": "1y", "moment": 0.1},
        "Weight": {"direction": "x"},
        "machine": {"structure": held, "Omega": 1.0},
        "reduce": {"structure": held, "keep": ["1x"], "modes": 2},
        "root_locus": {"structure": held, "values": [0.0, 100.0]},
        "shaft": {"elements": [s.Beam(0.2, 0.05)]},
        "static_deflection": {"structure": held, "load": {"1x": 1.0}},
        "unbalance_response": {"structure": held, "speeds": [10.0], "unbalance": (1, 1e-3)},
    }


def methods():
    """Methods of these packages, with right values."""
    f, measured, x = ns.fatigue, ns.measured, ns.excitation
    block = f.LoadBlock.constant_amplitude(50.0, 50.0, frequency=20.0)
    calibration, specimen = f.Calibration(2.0), f.Specimen()
    filter_ = measured.Differentiator(0.1, 11)
    laws = (f.Paris(1e-8, 4.0), f.Walker(1e-8, 3.0, 0.5), f.Forman(1e-8, 3.0, 2000.0))
    table, sine = f.LoadTable([6.0, 16.0], [block, block]), x.harmonic(20.0, 3.0, duration=1.0)
    rig = excitation()["lives_under_shaking"]["rig"]
    bent = {"specimen": specimen, "crack": 6.0}
    held, s = structures()["campbell"]["structure"], ns.structures
    film = s.Bearing(["1x", "1y"], [1e6, 2e6], speeds=[0.0, 9.0])
    wave, t = fatigue()["count_cycles"].values()
    return [
        (f.CrackCurve(5.0, 1e-3, 426925.0, 54734.0).time, {"length": 6.0}),
        (f.LoadBlock.from_cycles, {"cycles": f.count_cycles(wave, t)}),
        (f.LoadBlock.from_record, {"load": wave, "times": t}),
        (f.NewmanClosure().opening, {"R": 0.1}),
        *((law.rate, {"delta_K": 100.0, "R": 0.1}) for law in laws),
        (calibration.load, bent | {"voltage": 1.0}),
        (calibration.voltage, bent | {"load": 1.0}),
        (specimen.stress_intensity, {"load": 100.0, "crack": 6.0}),
        (table.at, {"crack": 7.0}),
        (table.weights, {"lengths": np.array([7.0])}),
        (filter_.bias, {"frequency": 1.0}),
        (filter_.highest, {}),
        (filter_.truncation, {"derivative": 3, "size": 1.0}),
        (measured.Channel("x").displacement, {"readings": [1.0, 2.0]}),
        (measured.Differentiator.for_band, {"step": 0.001, "highest": 20.0}),
        (rig.load, {"excitation": sine, "crack": 6.0, "transient": 0.2}),
        (rig.parameters, {"crack": 6.0}),
        (rig.system, {"excitation": sine, "crack": 6.0}),
        (film.at, {"coordinates": [0]}),
        (film.at_speed, {"speed": 1.0}),
        (film.scaled, {"stiffness": 2.0, "damping": 2.0}),
        (held.at_speed, {"speed": 1.0}),
        (held.fixed, {"coordinates": ["1x"]}),
        (held.index, {"name": "1x"}),
        (s.Disc.from_geometry, {"node": 1, "width": 0.1, "diameter": 0.2}),
        (sine.power, {}),
        (sine.scaled, {"factor": 2.0}),
        (sine.as_signal, {}),
    ]


def refusal(verb, given):
    """What a verb says of its arguments, or nothing where it takes them; and how long it took."""
    began = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            verb(**given)
            said = None
        except ns.NonsmoothError as fault:
            said = str(fault)
    return said, time.process_time() - began


def check(name, verb, right, long):
    """Give each argument of a verb each of the wrong values."""
    assert refusal(verb, right)[0] is None
    for argument in inspect.signature(verb).parameters:
        for kind, wrong in WRONG.items():
            if argument in FUNCTIONS and callable(wrong):
                continue
            case = f"{name}({argument}={kind})"
            said, took = refusal(verb, right | {argument: wrong})
            if said is None:
                continue
            assert took < SOON, f"{case} took {took:.1f} s to refuse"
            other = TOLD_OTHERWISE.get((name, argument), argument)
            nearer = argument.removesuffix("s")  # an error of one of several
            assert argument in said or nearer in said or other in said, f"{case} says: {said}"
            if argument not in long and long:
                later, took = refusal(verb, right | long | {argument: wrong})
                assert later is not None and took < SOON, f"{case} is refused late: {took:.1f} s"


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """Folders that a text names are made here."""
    monkeypatch.chdir(tmp_path)


@pytest.mark.few(2)
@pytest.mark.parametrize("name", VERBS)
def test_a_wrong_argument_is_refused_at_once_and_by_its_name(name):
    right, long = cases()[name]
    check(name, getattr(ns, name), right, long)


@pytest.mark.parametrize("name", RIG)
def test_a_wrong_argument_of_measured_motions_is_refused(name):
    check(name, getattr(ns.measured, name), rig()[name], {})


@pytest.mark.parametrize("name", fatigue())
def test_a_wrong_argument_of_fatigue_is_refused(name):
    check(name, getattr(ns.fatigue, name), fatigue()[name], {})


@pytest.mark.few(1)
@pytest.mark.parametrize("name", excitation())
def test_a_wrong_argument_of_excitation_is_refused(name):
    check(name, getattr(ns.excitation, name), excitation()[name], {})


@pytest.mark.few(9)
@pytest.mark.parametrize("name", structures())
def test_a_wrong_argument_of_structures_is_refused(name):
    check(name, getattr(ns.structures, name), structures()[name], {})


@pytest.mark.few(2)
@pytest.mark.parametrize("name", ["plan_map", "forecast", "work", "progress", "open_map"])
def test_a_wrong_argument_of_a_map_in_tiles_is_refused(name, tmp_path):
    verb, (right, long) = getattr(ns.cluster, name), shared_map(tmp_path)[name]
    check(name, verb, right, long)


def test_a_wrong_argument_of_a_method_is_refused():
    for method, right in methods():
        check(method.__qualname__, method, right, {})


@pytest.mark.parametrize("law", [ns.fatigue.guinea_stiffness, ns.fatigue.guinea_text])
@pytest.mark.parametrize("wrong", [{"span": 1e300}, {"width": 1e-300}])
def test_sizes_whose_powers_no_double_holds_are_refused(law, wrong):
    given = {"crack": 5.0} if law is ns.fatigue.guinea_stiffness else {}
    with pytest.raises(ns.ModelError, match=f"{next(iter(wrong))} = 1e.300 is no size of anything"):
        law(**given, **wrong)
