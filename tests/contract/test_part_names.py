"""A state, an output or a parameter is never lost behind a part of a result with its name."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.runs import part_names
from nonsmooth.system.model.name_checks import _RESULT_NAMES


def driven(state="x", output="power", w="w"):
    return ns.System(
        states=[state, "v"],
        parameters={w: 2.6, "r": 0.8},
        period=f"2*pi/{w}",
        outputs={output: f"{state}*v"},
        modes={
            "free": ns.Mode(
                {state: "v", "v": f"-{state} - 0.3*v + cos({w}*t)"},
                exits=[ns.Exit(f"0.1 - {state}", reset={"v": "-r*v"}, name="hit")],
            )
        },
    )


def hill(state="x"):
    rates = {state: "v", "v": f"{state} + cos(t)"}
    return ns.System(states=[state, "v"], equations=rates, period="2*pi")


def lozi(state="x", a="a"):
    still = {state: "0", "y": "0"}
    kick = {state: f"1 - {a}*abs({state}) + y", "y": f"b*{state}"}
    return ns.System(
        states=[state, "y"],
        parameters={a: 1.8, "b": 0.3},
        period=1.0,
        modes={
            "before": ns.Mode(still, exits=[ns.Exit("cos(2*pi*t)", to="after", reset=kick)]),
            "after": ns.Mode(still, exits=[ns.Exit("-cos(2*pi*t)", to="before")]),
        },
    )


def wells(state="x"):
    rates = {state: "v", "v": f"{state} - {state}**3 - 0.5*v"}
    return ns.System(states=[state, "v"], equations=rates, period=1.0)


def saddles(system, state="x"):
    return ns.find_orbit(system, {state: 0.4}), ns.find_orbit(system, {state: -0.9})


def crossings(system, both):
    return ns.homoclinic_points(
        system, both[0], length=2.0, side="+", to_side="-", largest_step=0.2
    )


def tangencies(system, both, parameter):
    return ns.homoclinic_tangency(
        system, parameter, (1.84, 1.88), *both, side="-", to_side="+", length=2.0,
        largest_step=0.2, bumps=1,
    )  # fmt: skip


def edge(system, state):
    return ns.edge_state(system, {state: -0.7}, {state: 1.2}, iterates=50)


def diagram(system, parameter="w"):
    return ns.bifurcation_diagram(system, parameter, [2.7, 2.8], transient=20, record=10)


MADE = {
    "OF_ORBITS": [
        lambda: ns.find_orbit(driven()),
        lambda: ns.find_orbit(ns.models.moling()),
        lambda: ns.find_orbit(ns.models.clearance_rotor(omega=0.2, zeta=0.5)),
        lambda: ns.orbits(driven(), longest=1, samples=3, guesses=3),
    ],
    "OF_BRANCHES": [
        lambda: ns.continue_orbit(driven(), "w", (2.55, 2.65), steps=4),
        lambda: ns.continue_orbit(ns.models.moling(b=0.15), "b", (0.149, 0.151), steps=3),
    ],
    "OF_SAMPLES": [
        lambda: ns.orbit_samples(ns.find_orbit(driven())),
        lambda: ns.orbit_samples(ns.find_orbit(ns.models.moling())),
    ],
    "OF_DIAGRAMS": [
        lambda: diagram(driven()),
        lambda: ns.bifurcation_diagram(ns.models.moling(), "b", [0.1], transient=20, record=10),
    ],
    "OF_EDGES": [lambda: edge(wells(), "x")],
    "OF_MANIFOLDS": [lambda: ns.manifold(hill(), ns.find_orbit(hill(), {"x": -0.5}), length=1.0)],
    "OF_CROSSINGS": [lambda: crossings(lozi(), saddles(lozi()))],
    "OF_TANGENCIES": [lambda: tangencies(lozi(), saddles(lozi()), "a")],
}


def refuses(verb):
    """Whether a name is refused where a system is declared, or by a function of it."""
    with pytest.raises((ns.ModelError, ns.OptionError), match=r"also the name of|the name of a"):
        verb()


@pytest.mark.parametrize(
    ("kind", "k"), [(kind, k) for kind, made in MADE.items() for k in range(len(made))]
)
def test_all_parts_of_a_result_are_known(kind, k):
    data = MADE[kind][k]()
    system = ns.System.from_toml(data.attrs["system"])
    own = {*map(str, data.variables), *map(str, data.dims)}
    own -= {*system.states, *system.outputs, *system.parameters}
    own -= {f"{name}{end}" for name in system.drift_states for end in part_names._OF_DRIFTS}
    assert own <= {*getattr(part_names, kind), *_RESULT_NAMES}


def test_all_parts_of_a_run_are_known():
    system = driven()
    data = ns.simulate(system, periods=2, tangent=["w"])
    own = {*map(str, data.variables), *map(str, data.dims)} - {*system.states, *system.outputs}
    assert own <= _RESULT_NAMES


@pytest.mark.parametrize("name", sorted(part_names.OF_BRANCHES))
def test_orbits_and_branches(name):
    if name in part_names.OF_ORBITS:
        refuses(lambda: ns.find_orbit(driven(name)))
        refuses(lambda: ns.orbits(driven(name), longest=1, samples=3, guesses=3))
    refuses(lambda: ns.continue_orbit(driven(name), "w", (2.55, 2.65)))
    refuses(lambda: ns.continue_orbit(driven(w=name), name, (2.55, 2.65)))
    refuses(lambda: ns.bifurcation_picture(driven(w=name), name, (2.55, 2.65), {"x": (-1, 0)}))


@pytest.mark.parametrize("name", sorted(part_names.OF_DIAGRAMS))
def test_diagrams(name):
    refuses(lambda: diagram(driven(name)))
    refuses(lambda: diagram(driven(output=name)))


@pytest.mark.parametrize("name", sorted(part_names.OF_SAMPLES - {"drift", "drift_state"}))
def test_samples_of_an_orbit(name):
    refuses(lambda: ns.orbit_samples(ns.find_orbit(driven(output=name))))


@pytest.mark.parametrize("name", sorted(part_names.OF_EDGES))
def test_edges(name):
    refuses(lambda: edge(wells(name), name))


@pytest.mark.parametrize("name", sorted(part_names.OF_MANIFOLDS))
def test_manifolds(name):
    refuses(lambda: ns.manifold(hill(name), None))


@pytest.mark.parametrize("name", sorted(part_names.OF_CROSSINGS | part_names.OF_TANGENCIES))
def test_crossings_and_tangencies(name):
    if name in part_names.OF_CROSSINGS:
        refuses(lambda: crossings(lozi(name), (None, None)))
    if name in part_names.OF_TANGENCIES:
        refuses(lambda: tangencies(lozi(name), (None, None), "a"))
        refuses(lambda: tangencies(lozi(a=name), (None, None), name))


def test_what_a_drifting_state_does_has_its_name():
    cart = ns.System(
        states=["x", "v"], outputs={"x_per_period": "2*v"}, drift=["x"], period=1.0,
        equations={"x": "v", "v": "cos(2*pi*t) - v"}, parameters={"a": 1.0},
    )  # fmt: skip
    refuses(lambda: ns.bifurcation_diagram(cart, "a", [1.0], transient=5, record=5))


@pytest.mark.parametrize("name", ["tangent", "sensitivity", "digits", "estimated", "state_0"])
def test_runs(name):
    refuses(lambda: driven(name))
    refuses(lambda: driven(output=name))


def test_other_parameters_may_have_any_name():
    """A parameter that does not vary stands in the attributes alone."""
    orbit = ns.find_orbit(driven(w="length"))
    same = ns.find_orbit(driven())
    assert float(orbit["length"]) == float(same["length"])
    assert np.array_equal(diagram(driven(w="period"), "period")["x"], diagram(driven())["x"])
