"""Crossings beside sign changes of densely sampled runs, for every ready-made model.

The samples come from runs of the system without a section in it. Times are short, so that
chaos has no time to tell the two trajectories apart.
"""

import warnings
from dataclasses import replace

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.models.ready_made import ready_made
from nonsmooth.system.section import with_section

MODELS = {name: make() for name, make in ready_made().items()}
SHARES = (0.123, 0.487, 0.871)  # of the range of a variable, where the section lies
# radius, gap and slip of a rotor have a kink at zero, where they are at rest
ROTORS = ("clearance_rotor", "massive_ring_rotor", "rotor", "rubbing_rotor", "snubber_rub")
START = {name: {"x": 1e-3} for name in ROTORS}
ANGLES = ("contact_angle",)  # which jumps by a whole turn where nothing happens
# A rotor in a ring has dozens of cells, which each section splits anew: seconds for each variable.
# A state, a force with kinks and a variable of contact tell what the others could.
RINGS = ("massive_ring_rotor", "rotor", "snubber_rub")
OF_RINGS = ("x", "normal_force", "force_y", "gap", "slip")


def case(name: str, variable: str):
    long = name in RINGS and variable not in OF_RINGS
    return pytest.param(name, variable, marks=[pytest.mark.slow] * long)


CASES = [
    case(name, v) for name, s in MODELS.items() for v in (*s.states, *s.outputs) if v not in ANGLES
]


def end_of(system: ns.System) -> float:
    return 6.0 * system.period_value if system.period_value else 25.0


def with_level(system: ns.System) -> ns.System:
    """The system with a parameter for sections, so that those of one variable share their cells."""
    return replace(system, parameters={**system.parameters, "level_of_section": 0.0})


@pytest.fixture(scope="module")
def sampled():
    return {
        name: ns.simulate(system, START.get(name), times=np.linspace(0.0, end_of(system), 30_011))
        for name, system in MODELS.items()
    }


@pytest.mark.few(6)
@pytest.mark.parametrize(("model", "variable"), CASES)
def test_crossings_are_sign_changes(sampled, model, variable):
    system, run = with_level(MODELS[model]), sampled[model]
    values, time = run[variable].values, run["time"].values
    for share in SHARES:
        level = float(np.nanmin(values) + share * np.ptp(values[np.isfinite(values)]))
        text = f"{variable} - level_of_section"
        with warnings.catch_warnings():
            # a force that only jumps crosses nothing, and the verb says so
            warnings.simplefilter("ignore", ns.RunWarning)
            points = ns.poincare_section(
                system, START.get(model), section=text, direction=0, t_end=time[-1],
                parameters={"level_of_section": level},
            )  # fmt: skip
        above = values >= level
        found = np.flatnonzero(above[1:] != above[:-1])
        # where an event lies between two samples, a jump may have changed the sign
        events = np.searchsorted(time, run["event_time"].values, side="left") - 1
        met = np.searchsorted(time, points["time"].values, side="left") - 1
        assert np.array_equal(np.setdiff1d(met, events), np.setdiff1d(found, events)), (
            f"{text}, {level}: {np.setxor1d(met, found)}"
        )
        smooth = ~np.isin(met, events)
        assert np.array_equal(above[met + 1][smooth], points["direction"].values[smooth] > 0)
        np.testing.assert_allclose(points[variable], level, atol=1e-12 * max(1, abs(level)))


@pytest.mark.few(4)
@pytest.mark.parametrize("model", MODELS)
def test_a_section_changes_no_trajectory(sampled, model):
    system, run = MODELS[model], sampled[model]
    state = system.states[0]
    section = with_section(system, f"{state} - {float(run[state].mean())!r}")
    times = run["time"].values[::1000]
    split = ns.simulate(section.system, START.get(model), times=times)
    for name in (*system.states, *system.outputs):
        scale = float(np.abs(run[name]).max()) or 1.0
        np.testing.assert_allclose(split[name], run[name][::1000], atol=1e-9 * scale)
    crossed = split["event_name"].values == "section"
    assert crossed.sum() > 0
    assert split.attrs["n_events"] == run.attrs["n_events"] + crossed.sum()
    origin = section.origin[split["mode"].values]
    assert np.array_equal(origin, run["mode"].values[::1000])
