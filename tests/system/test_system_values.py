"""Systems are values: they compare, hash, pickle, change by copy, and write themselves."""

import copy
import dataclasses
import pickle
import tomllib

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, ModelError, System


def everything(**changes):
    """A system that uses every word of this version."""
    words = {
        "name": "hopper",
        "states": ["x", "v", "p", "s"],
        "parameters": {"w": 2.0, "r": "4/5", "gap": 0.1, "n": 3},
        "definitions": {"F": "cos(w*t)", "stiff": "n*w**2"},
        "outputs": {"force": "F", "power": "force*v"},
        "period": "2*pi/w",
        "drift": ["s"],
        "require": {"w > 0": 'the "forcing" needs a frequency', "gap >= 0": "no overlap\n"},
        "initial": {"x": "-gap", "p": 1},
        "describe": {"x": "displacement [mm]", "w": "frequency \u03c9 of \\sin"},
        "modes": {
            "free": Mode(
                {"x": "v", "v": "F - x", "p": "0", "s": "v"},
                exits=[
                    Exit("gap - x", reset={"v": "-r*v"}, name="impact"),
                    Exit("10 + v", to="held"),
                    Exit("1e3 - 2*x", to="stop"),
                ],
            ),
            "held": Mode(
                {"x": "0", "v": "0", "s": 1},
                slaved={"p": "p + x = 1 - gap"},
                definitions={"F": "0"},
            ),
        },
    }
    return System(**(words | changes))


def test_with_parameters_makes_another_system():
    system = everything()
    other = system.with_parameters(r=0.5, gap="1/4")
    assert system.parameter_values == {"w": 2.0, "r": 0.8, "gap": 0.1, "n": 3.0}
    assert other.parameter_values == {"w": 2.0, "r": 0.5, "gap": 0.25, "n": 3.0}
    assert other.rest_state["x"] == -0.25
    assert other != system
    assert other.with_parameters(r="4/5", gap=0.1) == system


def test_with_parameters_repeats_requirements_and_checks():
    system = everything()
    with pytest.raises(ModelError, match="gap >= 0 is required, gap = -1 was given: no overlap"):
        system.with_parameters(gap=-1)
    with pytest.raises(ModelError, match="unknown parameter 'gab'; did you mean 'gap'"):
        system.with_parameters(gab=1)
    with pytest.raises(ModelError, match="not a finite number"):
        system.with_parameters(r="1/0")
    fixed = everything(period=3.141592653589793)  # pi: right for w = 2, half a turn for w = 1
    with pytest.raises(ModelError, match="not a period"):
        fixed.with_parameters(w=1)


def test_definitions_follow_parameters():
    # x starts at -gap, read through the modes of motion, hence the ulp
    run = ns.simulate(everything(), periods=1, parameters={"gap": 0.5})
    assert float(run["x"][0]) == pytest.approx(-0.5, rel=1e-15)
    assert float(run["force"][0]) == 1.0


def test_equality_and_hash():
    assert everything() == everything()
    assert hash(everything()) == hash(everything())
    assert len({everything(), everything(), everything(name="other")}) == 2
    assert everything() != "hopper"
    for change in (
        {"name": "other"},
        {"initial": {}},
        {"outputs": {}},
        {"drift": []},
        {"describe": {}},
        {"require": {}},
        {"period": None},
    ):
        assert everything() != everything(**change), change


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda s: pickle.loads(pickle.dumps(s))]
)
def test_copies_are_equal_and_run(copied):
    system = everything()
    _ = system.compiled  # caches must not travel, or must not matter
    other = copied(system)
    assert other == system
    assert hash(other) == hash(system)
    one, two = (ns.simulate(s, periods=2) for s in (system, other))
    assert one.identical(two)


def test_pickle_of_a_changed_system():
    system = everything().with_parameters(r=0.25)
    assert pickle.loads(pickle.dumps(system)).parameter_values["r"] == 0.25


def test_fields_are_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        everything().name = "other"
    with pytest.raises(dataclasses.FrozenInstanceError):
        Mode({"x": "0"}).flow = {}
    with pytest.raises(dataclasses.FrozenInstanceError):
        Exit("x").guard = "y"


def test_mappings_are_frozen():
    system = everything()
    with pytest.raises(TypeError):
        system.parameters["r"] = 0.1
    with pytest.raises(TypeError):
        system.modes["free"].flow["v"] = "0"


def test_the_user_may_change_what_was_given():
    # the system keeps copies, so later changes of the caller's dicts do not reach it
    parameters, flow, exits = {"a": 1.0}, {"x": "-a*x"}, [Exit("2 - x", to="stop")]
    system = System(states=["x"], parameters=parameters, modes={"m": Mode(flow, exits)})
    before = system.to_toml()
    parameters["a"], flow["x"] = 2.0, "0"
    exits.clear()
    assert system.parameter_values == {"a": 1.0}
    assert system.with_parameters().to_toml() == before


def test_toml_holds_the_same_words():
    system = everything()
    words = tomllib.loads(system.to_toml())
    assert words["format"] == 1
    assert words["name"] == "hopper"
    assert words["states"] == list(system.states)
    assert words["drift"] == list(system.drift)
    for key in ("parameters", "definitions", "outputs", "require", "initial", "describe"):
        assert words[key] == getattr(system, key)
    assert words["period"] == system.period
    assert list(words["modes"]) == list(system.modes)
    for name, mode in system.modes.items():
        told = words["modes"][name]
        assert told["flow"] == mode.flow
        assert told.get("slaved", {}) == mode.slaved
        assert told.get("definitions", {}) == mode.definitions
        for shown, way in zip(told.get("exits", []), mode.exits, strict=True):
            assert shown["guard"] == way.guard
            assert shown.get("to") == way.to
            assert shown.get("name") == way.name
            assert shown.get("reset", {}) == way.reset


def test_toml_of_an_angle():
    system = System(states=["a"], drift={"a": "2*pi"}, modes={"m": Mode({"a": "1"})})
    assert tomllib.loads(system.to_toml())["drift"] == {"a": "2*pi"}
    assert system.drift_states == ("a",)


@pytest.mark.parametrize(
    "label",
    [
        "quote \" and ' and \\",
        "two\nlines\tand tabs",
        "\u00b5m \u03c9 \u4e2d",
        "math italic \U0001d714",
    ],
)
def test_labels_of_any_text_survive_toml(label):
    system = everything(describe={"x": label})
    assert tomllib.loads(system.to_toml())["describe"]["x"] == label


def test_the_period_of_an_angle_is_an_expression():
    with pytest.raises(ModelError):
        System(states=["a"], drift={"a": "2*("}, modes={"m": Mode({"a": "1"})})


def test_the_name_is_a_text():
    with pytest.raises(ModelError):
        everything(name=5)


def test_equal_values_make_equal_systems():
    assert everything(parameters={"w": 2, "r": 0.8, "gap": 0.1, "n": 3}) == everything(
        parameters={"w": 2.0, "r": 0.8, "gap": 0.1, "n": 3.0}
    )


def test_repr_is_short():
    assert repr(everything()) == "<System 'hopper': states x v p s; w=2, r=0.8, gap=0.1, n=3>"


def test_a_model_called_again_shares_its_structure():
    """A machine made in a loop is parsed once; another text is another structure."""
    first, second = ns.models.moling(b=0.1), ns.models.moling(b=0.2)
    assert first.structure is second.structure and first.compiled is second.compiled
    assert first != second
    one, other = (
        ns.System(states=["x"], parameters={"a": a}, equations={"x": f"-a*{k}*x"})
        for a, k in ((1.0, 1), (2.0, 2))
    )
    assert one.structure is not other.structure
    assert float(ns.simulate(other, {"x": 1.0}, t_end=0.25)["x"][-1]) == pytest.approx(np.exp(-1))


def test_other_equations_of_a_system_of_one_mode():
    falls = System(states=["x"], equations={"x": "-x"}, parameters={"k": 2.0})
    faster = dataclasses.replace(falls, equations={"x": "-k*x"})
    assert faster.modes["flow"].flow["x"] == faster.equations["x"] == "-k*x"
    assert faster == System(states=["x"], equations={"x": "-k*x"}, parameters={"k": 2.0})
    with pytest.raises(ModelError, match="leave modes= out"):
        System(states=["x"], equations={"x": "-x"}, modes={"m": Mode({"x": "1"})})


def test_other_modes_in_the_place_of_equations_and_the_reverse():
    falls = System(states=["x"], equations={"x": "-x"})
    rises = {"rise": Mode({"x": "1"})}
    with pytest.raises(ModelError, match=r"written with equations=.*modes=\.\.\., equations=None"):
        dataclasses.replace(falls, modes=rises)
    other = dataclasses.replace(falls, modes=rises, equations=None)
    assert other.mode_names == ("rise",)
    with pytest.raises(ModelError, match=r"written with modes= \(rise\).*modes=\{\}"):
        dataclasses.replace(other, equations={"x": "-x"})
    assert dataclasses.replace(other, equations={"x": "-x"}, modes={}) == falls
