"""Whatever is given to a plot function, the answer is a picture or a clear error."""

import inspect
import warnings
from functools import cache

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from contract.test_wrong_arguments import (
    HILL,
    RUBBING,
    STRUCK,
    WELLS,
    WRONG,
    data,
    fatigue,
    structures,
    swing,
)
from nonsmooth.arguments import allowed_arguments

# What a message may say in place of the argument: which variable or kind of dataset is missing.
TOLD = ("unknown variable", "unknown state", "the dataset", "variable = ", "has no suffix")
LINE, SQUARE = np.linspace(-1.0, 1.0, 5), {"x": (-1.0, 1.0), "v": (-1.0, 1.0)}
FEW = {"samples": 2, "record": 20, "longest": 50}
BRIEF = {"transient": 5, "record": 4, "evidence": 20, "longest": 5, "confirm": 0}
SPEEDS = {"parameter": "omega", "values": [0.8, 0.9], "transient": 2, "record": 4}
HEALTHY = xr.Dataset({"a": ("window", np.sin(np.arange(400.0)))})
MAKE = {
    "animate": lambda: {"run": data("run")},
    "alarm": lambda: {"found": ns.measured.alarm(HEALTHY, HEALTHY, rate=0.05)},
    "attractors": lambda: {"data": ns.attractors(ns.StroboscopicMap(STRUCK), SQUARE, **FEW)},
    "basins": lambda: {
        "data": ns.basins_of_attraction(
            ns.StroboscopicMap(STRUCK), {"x": LINE, "v": LINE}, **FEW
        )
    },
    "bifurcation": lambda: {
        "diagram": ns.bifurcation_diagram(STRUCK, **SPEEDS), "variable": "x",
    },
    "bifurcation_picture": lambda: {
        "picture": ns.bifurcation_picture(
            STRUCK, "omega", (0.8, 0.9), SQUARE, columns=2, searches=0, samples=2, record=20,
        ),
        "y": "x",
    },
    "branch": lambda: {"branches": data("branch"), "y": "x"},
    "campbell": lambda: {"data": of_structures("campbell")},
    "cobweb": lambda: {"data": returns()},
    "comparison": lambda: {
        "computed": data("run"), "measured": data("run"), "x": "time", "y": "x",
    },
    "contact_regions": lambda: {"boundaries": ns.models.snubber_boundaries(points=21)},
    "corner": lambda: {"data": data("fit")},
    "crack_lengths": lambda: {
        "curve": ns.fatigue.CrackCurve(5.0, 1e-3, 426925.0, 54734.0), "times": [0.0, 4e5],
    },
    "edge_state": lambda: {
        "data": ns.edge_state(WELLS, {"x": -1.7}, {"x": 2.3}, iterates=20),
    },
    "erosion_profile": lambda: {
        "profile": ns.erosion_profile(
            STRUCK, "omega", [0.8, 0.9], {"x": LINE, "v": LINE}, **FEW
        ),
    },
    "event_markers": lambda: {
        "run": data("run"), "variable": "x", "ax": ns.plot.print_figure()[1][0],
    },
    "exponents": lambda: {
        "spectrum": ns.lyapunov_spectrum(STRUCK, transient=2, record=4, confirm=0)
    },
    "fit": lambda: {"data": data("fit")},
    "fit_spectra": lambda: {"data": data("fit")},
    "growth_curve": lambda: {
        "curve": xr.Dataset({"crack": ("time", 6.0 + LINE)}, {"time": LINE}),
        "sections": {6.0: data("points")}, "x": "x", "y": "v",
    },
    "homoclinic_points": lambda: {
        "data": ns.homoclinic_points(HILL, data("hilltop"), length=0.1),
    },
    "lives": lambda: {"compared": ns.fatigue.compare_lives(**fatigue()["compare_lives"])},
    "load_cycles": lambda: {
        "cycles": ns.fatigue.count_cycles(np.sin(6.0 * LINE), np.arange(5.0))
    },
    "manifold": lambda: {"data": ns.manifold(STRUCK, data("saddle"), length=0.1)},
    "multipliers": lambda: {"data": data("branch")},
    "orbit": lambda: {"run": data("run"), "x": "x", "y": "v"},
    "orbit_history": lambda: {"samples": ns.orbit_samples(data("orbit")), "variables": "x"},
    "periodic_orbit": lambda: {
        "samples": ns.orbit_samples(data("orbit")), "x": "x", "y": "v",
    },
    "phase_portrait": lambda: {"run": data("run"), "x": "x", "y": "v"},
    "phase_portrait_3d": lambda: {"runs": {0.8: data("run")}, "x": "x", "y": "v"},
    "phases": lambda: {"run": data("run"), "variables": "x"},
    "print_figure": dict,
    "quality": lambda: {
        "record": swing(), "found": ns.measured.check(swing()), "channel": "x",
    },
    "regime_map": lambda: {
        "grid": ns.regime_map(STRUCK, over={"omega": [0.8, 0.9], "a": [0.6, 0.7]}, **BRIEF)
    },
    "return_map": lambda: {"data": returns()},
    "save_animation": lambda: {
        "film": ns.plot.animate(data("run"), slow_down=1.0), "path": "a.gif",
    },
    "roc": lambda: {"data": ns.measured.roc(HEALTHY, HEALTHY)},
    "save_figure": lambda: {"figure": ns.plot.print_figure()[0], "path": "a.png"},
    "profiles": lambda: {"data": data("fit")},
    "section": lambda: {"points": data("points"), "x": "x", "y": "v"},
    "shaking": lambda: {
        "record": ns.excitation.harmonic(20.0, 3.0, duration=1.0).to_dataset(),
    },
    "frequency_response": lambda: {"data": of_structures("frequency_response")},
    "mode_shapes": lambda: {"data": of_structures("natural_modes")},
    "reduction": lambda: {
        "data": ns.structures.reduce(
            structures()["reduce"]["structure"], ["1x"], frequency_range=(0.0, 100.0)
        ).estimate
    },
    "root_locus": lambda: {"data": of_structures("root_locus")},
    "unbalance_response": lambda: {"data": of_structures("unbalance_response")},
    "smoothing": lambda: {
        "data": ns.smoothing_report(RUBBING, epsilons=(0.1, 0.01), periods=1, samples=20)
    },
    "spectrum": lambda: {"data": ns.power_spectrum(data("run"), "x")},
    "statistics": lambda: {
        "data": ns.contact_statistics(STRUCK, **SPEEDS), "variable": "contacts",
    },
    "stiffness_laws": lambda: {"data": ns.fatigue.compare_stiffness_laws(crack=[5.0, 10.0])},
    "stress_intensity": lambda: {
        "data": ns.fatigue.compare_stress_intensity(crack=[5.0, 10.0])
    },
    "time_history": lambda: {"run": data("run"), "variables": "x"},
    "transient_section": lambda: {"points": data("points"), "x": "x", "y": "v"},
    "translation": lambda: {"test": ns.zero_one_test(data("points"), "x")},
    "uncertainty": lambda: {"data": ns.uncertainty_exponent(data("basins"))},
    "waterfall": lambda: {"data": ns.waterfall(STRUCK, variable="x", **SPEEDS)},
}  # fmt: skip


def test_every_annotation_of_a_picture_has_a_check():
    """Otherwise a new kind of argument would pass unseen."""
    drawn = [name for name in ns.plot.__all__ if hasattr(getattr(ns.plot, name), "__wrapped__")]
    assert set(MAKE) == set(drawn)
    open_ = {
        (name, argument)
        for name in drawn
        for argument, kind in allowed_arguments(getattr(ns.plot, name)).items()
        if kind is None
    }
    assert open_ == {("phase_portrait_3d", "ax")}  # axes in space, which the function looks at


@cache
def of_structures(name):
    return getattr(ns.structures, name)(**structures()[name])


@cache
def returns():
    section = ns.PoincareMap(STRUCK, "v")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ns.ResultWarning)
        return ns.return_map(section, coordinate="x", between=(0.0, 1.0), samples=20)


@pytest.fixture(autouse=True)
def aside(tmp_path, monkeypatch):
    """No windows, and files that a text names lie in a folder of the test."""
    monkeypatch.chdir(tmp_path)
    with matplotlib.rc_context({"backend": "Agg"}):
        yield
    plt.close("all")


@pytest.mark.few(1)
@pytest.mark.parametrize("name", MAKE)
def test_a_wrong_argument_of_a_picture_is_refused_by_its_name(name):
    draw, right = getattr(ns.plot, name), MAKE[name]()
    draw(**right)
    for argument in inspect.signature(draw).parameters:
        for kind, wrong in {**WRONG, "another dataset": xr.Dataset({"q": ("k", [1.0])})}.items():
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                try:
                    draw(**{**right, argument: wrong})
                except ns.NonsmoothError as fault:
                    said = str(fault)
                    named = argument in said or argument.removesuffix("s") in said
                    assert named or any(words in said for words in TOLD), (
                        f"{name}({argument}={kind}) says: {said}"
                    )
            plt.close("all")
