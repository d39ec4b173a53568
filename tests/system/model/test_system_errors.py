"""Every reason for which a system is refused, once each, with the words that help."""

import math
import time

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth import Exit, Mode, ModelError, System


def oscillator(**changes):
    """A system that is right; tests change one thing."""
    words = {
        "states": ["x", "v"],
        "parameters": {"w": 2.0, "zeta": 0.1},
        "modes": {"free": Mode({"x": "v", "v": "-x - 2*zeta*v"})},
    }
    return System(**(words | changes))


def one_mode(flow=None, **mode):
    return {"free": Mode(flow or {"x": "v", "v": "-x"}, **mode)}


def test_the_base_of_these_tests_is_right():
    assert oscillator().states == ("x", "v")


def refused(words, **changes):
    with pytest.raises(ModelError) as caught:
        oscillator(**changes)
    message = str(caught.value)
    for word in words:
        assert word in message, message
    return message


# ---------------------------------------------------------------- names


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"modes": one_mode({"x": "v", "v": "-x - zet*v"})}, ["zet", "did you mean 'zeta'"]),
        ({"modes": one_mode({"x": "v", "v": "-x - Q*v"})}, ["unknown name 'Q'", "known: "]),
        ({"modes": one_mode({"x": "v", "u": "-x", "v": "0"})}, ["unknown state 'u'"]),
        ({"modes": one_mode(slaved={"u": "x"})}, ["unknown state 'u'"]),
        ({"modes": one_mode(definitions={"d": "x"})}, ["overrides definitions", "'d'"]),
        ({"modes": one_mode(exits=[Exit("x", to="fre")])}, ["exits[0].to", "did you mean 'free'"]),
        ({"modes": one_mode(exits=[Exit("x", to="sto")])}, ["did you mean 'stop'"]),
        ({"modes": one_mode(exits=[Exit("x", reset={"u": "0"})])}, ["reset", "unknown state 'u'"]),
        ({"modes": one_mode(exits=[Exit("x - gap")])}, ["exits[0].guard", "unknown name 'gap'"]),
        ({"drift": ["z"]}, ["drift", "unknown state 'z'"]),
        ({"initial": {"z": 1}}, ["initial", "unknown state 'z'"]),
        ({"describe": {"z": "position"}}, ["describe", "unknown name 'z'"]),
        ({"outputs": {"power": "F*v"}}, ["outputs['power']", "unknown name 'F'"]),
        ({"definitions": {"d": "k*x"}}, ["definitions['d']", "unknown name 'k'"]),
        ({"period": "2*pi/omega"}, ["period", "unknown name 'omega'"]),
        ({"modes": one_mode({"x": "v", "v": "rate(w)"})}, ["state or signal in rate()", "'w'"]),
    ],
)
def test_names_that_are_not_declared(changes, words):
    refused(words, **changes)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"states": ["x", "t"]}, ["'t' has a fixed meaning"]),
        ({"parameters": {"pi": 3}}, ["'pi' has a fixed meaning"]),
        ({"parameters": {"sin": 3}}, ["'sin' has a fixed meaning"]),
        ({"definitions": {"rate": "x"}}, ["'rate' has a fixed meaning"]),
        (
            {"modes": {"stop": Mode({"x": "v", "v": "0"})}},
            ["'stop' has a fixed meaning, the target of an exit that ends the run", "stop_"],
        ),
        ({"parameters": {"stop": 3}}, ["parameters: 'stop'", "an exit that ends the run", "stop_"]),
        ({"states": ["x", "in"]}, ["'in' is not a name", "as Python reads them", "write in_"]),
        ({"modes": {"in": Mode({"x": "v", "v": "0"})}}, ["modes: 'in'", "write in_"]),
        ({"parameters": {"lambda": 3}}, ["'lambda'", "not a reserved word"]),
        ({"parameters": {"2a": 3}}, ["'2a'", "letters, digits"]),
        ({"parameters": {"\u03c9": 3}}, ["letters, digits"]),
        ({"parameters": {"": 3}}, ["letters, digits"]),
        ({"states": ["x", 3]}, ["3 is not a name"]),
        ({"states": ["x", "x"]}, ["'x' is declared already in states"]),
        ({"parameters": {"x": 1}}, ["parameters: 'x' is declared already in states"]),
        ({"definitions": {"w": "1"}}, ["definitions: 'w' is declared already in parameters"]),
        ({"outputs": {"v": "x"}}, ["outputs: 'v' is declared already in states"]),
        ({"outputs": {"time": "x"}}, ["'time' is the name of a variable of results"]),
        ({"states": "xv"}, ["give a list of names", "'xv'"]),
        ({"states": []}, ["at least one state"]),
        ({"modes": {}}, ["at least one mode"]),
        ({"modes": {"free": {"x": "v"}}}, ["write Mode(flow, exits=...)"]),
        ({"describe": {"x": 3}}, ["describe['x']", "3 is not a text"]),
    ],
)
def test_names_that_cannot_be(changes, words):
    refused(words, **changes)


RESULT_VARIABLES = [
    "event_time",
    "event_name",
    "certified",
    "guard_rate",
    "state_after",
    "end_state",
]


@pytest.mark.parametrize("kind", ["states", "outputs"])
@pytest.mark.parametrize("name", RESULT_VARIABLES)
def test_names_of_result_variables_are_refused(kind, name):
    flow = {"x": "v", "v": "-x"}
    if kind == "states":
        refused([name], states=["x", "v", name], modes=one_mode({**flow, name: "0"}))
    else:
        refused([name], outputs={name: "2*x"})


# ---------------------------------------------------------------- parts


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Exit("x", to="a b"), ["to='a b'", "letters, digits"]),
        (lambda: Exit("x", name="2nd"), ["name='2nd'"]),
        (lambda: Exit("x", reset="v = -v"), ["reset maps state names"]),
        (lambda: Exit("x", sticks="a b"), ["sticks='a b' is not a name"]),
        (lambda: Mode("x' = v"), ["flow maps names"]),
        (lambda: Mode({"x": "v"}, slaved=["x"]), ["slaved maps names"]),
        (lambda: Mode({"x": "v"}, definitions="d"), ["definitions maps names"]),
        (lambda: Mode({"x": "v"}, exits=["x"]), ["exits[0]", "write Exit(guard"]),
        (lambda: Mode({"x": "v"}, cells="+"), ["cells maps signs to names"]),
        (
            lambda: Mode({"x": "v"}, cells={"+": "a b"}),
            ["cells['+'] = 'a b'", "give names by signs"],
        ),
    ],
)
def test_parts_that_are_malformed(make, words):
    with pytest.raises(ModelError) as caught:
        make()
    for word in words:
        assert word in str(caught.value)


def test_missing_flow():
    refused(["state 'v' has neither a flow", 'flow["v"]'], modes=one_mode({"x": "v"}))


def test_flow_and_slaved():
    refused(["'v' has a flow and is slaved"], modes=one_mode(slaved={"v": "x"}))


# ---------------------------------------------------------------- circles


def test_circular_definitions():
    message = refused(
        ["goes in a circle"],
        definitions={"a": "b", "b": "c + 1", "c": "a"},
        modes=one_mode({"x": "v", "v": "-a"}),
    )
    assert "a -> b -> c -> a" in message


@pytest.mark.parametrize(
    "changes",
    [
        {"definitions": {"a": "b", "b": "a"}},
        {"outputs": {"a": "b", "b": "a"}},
        {"outputs": {"o": "rate(w)"}},
    ],
)
def test_faults_that_only_outputs_meet(changes):
    refused([], **changes)


def test_circular_rates():
    refused(
        ["rate(x) -> rate(v) -> rate(x) goes in a circle"],
        modes=one_mode({"x": "rate(v)", "v": "rate(x)"}),
    )


@pytest.mark.parametrize("slaved", [{"x": "x"}, {"x": "v", "v": "x"}, {"x": "x + v", "v": "0*x"}])
def test_slaved_states_that_leave_themselves_open(slaved):
    flow = {name: "0" for name in ("x", "v") if name not in slaved}
    refused(["slaved"], modes={"free": Mode(flow, slaved=slaved)})


# ---------------------------------------------------------------- slaved relations


def slaved_rate(relation, value, **parameters):
    """Rate of x' = -p with p slaved; p is ``value`` times x."""
    system = System(
        states=["x", "p"],
        parameters={"k": 4.0} | parameters,
        modes={"m": Mode({"x": "-p"}, slaved={"p": relation})},
    )
    run = ns.simulate(system, {"x": 1.0, "p": value}, times=[0.0, 1.0])
    return float(run["x"][-1]), float(run["p"][-1])


@pytest.mark.parametrize(
    ("relation", "value"),
    [
        ("x/4", 0.25),
        ("p = x/4", 0.25),
        ("4*p = x", 0.25),
        ("x = 4*p", 0.25),
        ("p + x = 2*x - 3*p", 0.25),
        ("p/2 - x/8 = 0", 0.25),
        ("k*p = x", 0.25),
        ("p = x - (k - 1)*p", 0.25),
    ],
)
def test_relations_are_solved_for_their_state(relation, value):
    # x' = -p, p = c x: both decay as exp(-c t); some ten operations of 1.1e-16
    x, p = slaved_rate(relation, value)
    assert x == pytest.approx(math.exp(-value), rel=1e-14)
    assert p == pytest.approx(value * math.exp(-value), rel=1e-14)


@pytest.mark.parametrize("order", [["x", "p", "q"], ["q", "p", "x"], ["p", "x", "q"]])
@pytest.mark.parametrize(
    "slaved",
    [
        {"p": "2*q", "q": "x"},
        {"p": "p + q = 3*x", "q": "p/2"},
        {"p": "p + q = 3*x", "q": "2*q = p"},
    ],
)
def test_slaved_states_that_depend_on_each_other(order, slaved):
    # all of them say q = x and p = 2 x; x' = -q
    system = System(states=order, modes={"m": Mode({"x": "-q"}, slaved=slaved)})
    run = ns.simulate(system, {"x": 1.0, "p": 2.0, "q": 1.0}, times=[0.0, 1.0])
    for name, factor in (("x", 1.0), ("q", 1.0), ("p", 2.0)):
        assert float(run[name][-1]) == pytest.approx(factor * math.exp(-1.0), rel=1e-14)


@pytest.mark.parametrize(
    ("relation", "words"),
    [
        ("p = x = v", ["one '='"]),
        ("p =", ["one '='"]),
        ("x = v", ["'p' does not appear"]),
        ("p - p = x", ["'p' does not appear"]),
        ("p = y", ["unknown name 'y'"]),
    ],
)
def test_relations_that_are_refused(relation, words):
    refused(
        words,
        states=["x", "v", "p"],
        modes=one_mode(slaved={"p": relation}),
    )


def test_comparisons_in_a_slaved_equation():
    system = System(
        states=["x", "p"],
        parameters={"k": 1.0},
        modes={"m": Mode({"x": "-x"}, slaved={"p": "where(k >= 1, 3, 4)*x"})},
    )
    assert float(ns.simulate(system, {"x": 1.0, "p": 3.0}, t_end=1.0)["p"][0]) == 3.0


def test_caret_at_an_unknown_name_of_a_relation():
    message = refused(
        ["unknown name 'y'"], states=["x", "v", "p"], modes=one_mode(slaved={"p": "p + 10*v = y"})
    )
    _, shown, caret = message.split("\n")
    assert shown[caret.index("^")] == "y"


# ---------------------------------------------------------------- drift and period


@pytest.mark.parametrize(
    ("modes", "place"),
    [
        (one_mode({"x": "v", "v": "-x"}), "the rate of 'v'"),
        (one_mode({"x": "v", "v": "-v"}, exits=[Exit("x - 1", to="stop")]), "the guard of 'stop'"),
        (
            one_mode({"x": "v", "v": "-v"}, exits=[Exit("v - 1", reset={"v": "x"})]),
            "the reset of 'v'",
        ),
    ],
)
def test_drift_that_something_depends_on(modes, place):
    refused([place, "depends on 'x'", "leave it out of drift="], modes=modes, drift=["x"])


def test_drift_may_be_reset_relative_to_itself():
    flow = {"x": "v", "v": "-v"}
    exits = [Exit("v - 1", reset={"x": "x + 1"})]
    assert oscillator(modes=one_mode(flow, exits=exits), drift=["x"]).drift_states == ("x",)


@pytest.mark.parametrize("text", ["2*x", "0", "-x"])
def test_resets_that_break_the_drift(text):
    # shifting x must shift the whole motion: only x plus something else does
    exits = [Exit("v - 1", reset={"x": text})]
    refused([], modes=one_mode({"x": "v", "v": "-v"}, exits=exits), drift=["x"])


FORCED = one_mode({"x": "v", "v": "cos(w*t) - x"})


@pytest.mark.parametrize("period", ["2*pi/w", "4*pi/w", "pi", 2 * math.pi, "3*(2*pi/w)"])
def test_periods_that_are_right(period):
    # sixteen digits: a literal may be off by an ulp
    assert oscillator(modes=FORCED, period=period).period_value > 0.0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"period": 1, "modes": FORCED},
            ["not a period of the equations", "turns 0.31831 times"],
        ),
        ({"period": "pi/w", "modes": FORCED}, ["turns 0.5 times"]),
        ({"period": 0}, ["positive and finite"]),
        ({"period": "-2*pi/w"}, ["positive and finite"]),
        ({"period": "1/(w - 2)"}, ["period"]),
        ({"period": "x"}, ["only parameters"]),
        ({"period": "2*t"}, ["only parameters"]),
        ({"initial": {"x": "t"}}, ["initial['x']", "only parameters"]),
        ({"initial": {"x": "1/(w - 2)"}}, ["initial['x']"]),
    ],
)
def test_periods_and_rest_states_that_are_wrong(changes, words):
    refused(words, **changes)


def test_a_period_of_ten_digits_is_refused_or_harmless():
    # The user rounded 2 pi. If that is taken, forcing must still be cos(t), not a cosine
    # that jumps by 1.8e-10 rad each period: x = sin t to 1e-12 after 1000 periods.
    try:
        system = oscillator(
            modes=one_mode({"x": "cos(t)", "v": "0"}), period=6.283185307, parameters={}
        )
    except ModelError:
        return
    run = ns.simulate(system, times=[0.0, 6283.0])
    assert float(run["x"][-1]) == pytest.approx(math.sin(6283.0), abs=1e-11)


# ---------------------------------------------------------------- guards and values


@pytest.mark.parametrize("guard", ["x - x", "v - 1 - v", "x - w - x"])
def test_guards_that_are_constant_and_not_positive(guard):
    refused(["guard is the constant"], modes=one_mode(exits=[Exit(guard, to="stop")]))


@pytest.mark.parametrize("guard", ["-1", "w - 3", "0", "-w", -2, 0.5, "w", "wall", "3*wall + pi"])
def test_guards_in_which_nothing_changes(guard):
    """The place of a wall instead of the distance from it: a motion would go through the wall."""
    words = [f"modes['free'].exits[0].guard: '{guard}' depends on no state and not on the time",
             "write a distance such as "]  # fmt: skip
    way = Exit(guard, reset={"v": "-v"}, name="hit")
    refused(words, modes=one_mode(exits=[way]), definitions={"wall": "w + 1", "far": "x"})


def test_a_guard_that_names_the_wall_is_told_the_distance_from_it():
    way = Exit("w", reset={"v": "-v"}, name="hit")
    refused(["write a distance such as w - x,"], modes=one_mode(exits=[way]))


@pytest.mark.parametrize("guard", ["far + 2", "t - 9", "w + s", "shown", "own - w"])
def test_guards_that_change_by_what_they_name(guard):
    system = oscillator(
        modes=one_mode(exits=[Exit(guard, to="stop")], definitions={"own": "2 - x"}),
        definitions={"far": "x", "own": "w"},
        signals={"s": ns.Signal([0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 2.0, 3.0])},
        outputs={"shown": "far + 2"},
    )
    assert system.states == ("x", "v")


def test_a_guard_of_a_slow_parameter_changes():
    """From period to period w falls by one."""
    system = oscillator(
        modes=one_mode(exits=[Exit("w - 0.5", to="stop")]), period=1.0, slow={"w": "2 - t"}
    )
    assert system.slow["w"] == "2 - t"


def test_a_guard_that_becomes_constant_with_a_parameter():
    system = oscillator(modes=one_mode(exits=[Exit("x + w - 1 - x", to="stop")]))
    with pytest.raises(ModelError, match=r"guard is the constant -0\.5"):
        system.with_parameters(w=0.5)


def test_a_guard_that_moves_at_rest_may_be_constant_in_flight():
    """The force of the floor is 1 + cos(2 t)/2 at rest, and zero in flight."""
    weak = Exit("rate(v) + 1 + cos(w*t)/2 - 0.8", to="stop", name="weak")
    bounce = Exit("x", reset={"v": "-v/2"}, sticks="rest", name="impact")
    flow = {"x": "v", "v": "-1 - cos(w*t)/2"}
    system = oscillator(modes={"flight": Mode(flow, exits=[bounce, weak])})
    run = ns.simulate(system, {"x": 0.0, "v": 0.0}, t_end=5.0)
    assert run.attrs["status"] == "stopped"
    assert float(run["event_time"][-1]) == pytest.approx(math.acos(-0.4) / 2, rel=1e-14)


def test_a_guard_that_is_constant_at_rest_too():
    bounce = Exit("x", reset={"v": "-v/2"}, sticks="rest", name="impact")
    flow = {"x": "v", "v": "-1"}
    late = Exit("x + w - 3 - x", to="stop", name="late")
    with pytest.raises(ModelError, match="guard is the constant"):
        oscillator(modes={"flight": Mode(flow, exits=[bounce, late])})


NOT_FINITE = [
    "1e999",
    "1/0",
    "log(-1)",
    "0/0",
    *(value for value in (math.inf, -math.inf, math.nan)),
]


@pytest.mark.parametrize("value", NOT_FINITE)
def test_parameters_that_are_not_finite(value):
    refused(["parameters['w']", "not a finite number"], parameters={"w": value, "zeta": 0.1})


@pytest.mark.parametrize("value", ["2*zeta", "x", "t"])
def test_parameters_that_are_not_constant(value):
    refused(
        ["parameters['w']", "constant expression", "definitions"],
        parameters={"w": value, "zeta": 0.1},
    )


@pytest.mark.parametrize("value", [None, True, [1.0], "two", 1j])
def test_parameters_that_are_not_numbers(value):
    refused(["parameters['w']"], parameters={"w": value, "zeta": 0.1})


@pytest.mark.parametrize(
    "value", [np.int64(2), np.float32(2.0), np.float64(2.0), np.array(2.0), xr.DataArray(2)]
)
def test_parameters_from_numpy(value):
    assert oscillator(parameters={"w": value, "zeta": 0.1}).parameter_values["w"] == 2.0


def test_coefficients_that_are_not_finite():
    refused(
        ["the rate of 'v' in mode 'free'", "is -inf", "forbid such values in require="],
        modes=one_mode({"x": "v", "v": "-x/(w - 2)"}),
    )


# ---------------------------------------------------------------- requirements


@pytest.mark.parametrize(
    ("condition", "given"),
    [
        ("w > 3", "w = 2"),
        ("w**2 <= 3*zeta", "w = 2, zeta = 0.1"),
        ("w < zeta", "w = 2, zeta = 0.1"),
        ("w > 1 and zeta > 1", "w = 2, zeta = 0.1"),
        ("not (w > 1 or zeta < 0)", "w = 2, zeta = 0.1"),
        ("0 < w < 1", "w = 2"),
    ],
)
def test_requirements_fail_with_reason_and_value(condition, given):
    refused([condition, given, "because so"], require={condition: "because so"})


@pytest.mark.parametrize("condition", ["w", "w > 1 and zeta", "w = 2", "", "w > 1, 2"])
def test_requirements_that_are_no_conditions(condition):
    refused(["require"], require={condition: "because so"})


@pytest.mark.parametrize("condition", ["W > 1", "w > x", "t > 0", "d > 0"])
def test_requirements_with_other_names(condition):
    refused(["require"], require={condition: "because so"}, definitions={"d": "w"})


def test_a_requirement_with_pi_that_fails():
    refused(["w > pi", "w = 2", "because so"], require={"w > pi": "because so"})


# ---------------------------------------------------------------- sizes


def test_too_many_coordinates():
    names = [f"x{i}" for i in range(511)]
    system = System(states=names, modes={"m": Mode(dict.fromkeys(names, "0"))})
    assert ns.simulate(system, t_end=1.0).attrs["status"] == "completed"
    forced = System(states=names, modes={"m": Mode(dict.fromkeys(names, "cos(t)"))})
    with pytest.raises(ModelError, match="at most 512"):
        ns.simulate(forced, t_end=1.0)


def test_too_many_states():
    names = [f"x{i}" for i in range(512)]
    with pytest.raises(ModelError, match="512 states; at most 511 can run"):
        System(states=names, modes={"m": Mode(dict.fromkeys(names, "0"))})
    with pytest.raises(ModelError, match="at most 511"):
        System(states=names, modes={"m": Mode({}, slaved=dict.fromkeys(names, "0"))})


def test_thousands_of_names_take_no_quadratic_time():
    """As many names in one system as in a hundred.

    Where a set of all names was made for each of them, the one took a hundred times as long. Sets
    are made in C, so no calls could be counted; the two ways are measured in turn, and take about
    the same on any machine.
    """

    def processor_time(systems, names):
        began = time.process_time()
        for _ in range(systems):
            System(
                states=["x"],
                parameters={f"p{i}": i for i in range(names)},
                outputs={f"o{i}": "x" for i in range(names)},
                modes={"m": Mode({"x": f"p{names - 1}"})},
            )
        return time.process_time() - began

    rounds = [(processor_time(1, 10_000), processor_time(100, 100)) for _ in range(3)]
    one, hundred = map(min, zip(*rounds, strict=True))
    assert one < 10.0 * hundred


def test_many_exits_keep_their_names():
    # guards 1 - x, 2 - x, ..., declared from the last to be reached to the first
    exits = [Exit(f"{n} - x", to="end", name=f"at_{n}") for n in range(60, 0, -1)]
    system = System(states=["x"], modes={"go": Mode({"x": "1"}, exits), "end": Mode({"x": "0"})})
    run = ns.simulate(system, t_end=2.0)
    assert run["event_name"].values[-1] == "at_1"
    assert run["event_path"].values[-1] == "at_1"


def ladder(n):
    """Modes m0, m1, ... of which each is left at the instant when it is entered."""
    modes = {"m0": Mode({"x": "-1"}, [Exit("x", to="m1")])}
    modes |= {f"m{i}": Mode({"x": "0"}, [Exit("x - 1", to=f"m{i + 1}")]) for i in range(1, n)}
    modes |= {f"m{n}": Mode({"x": "0"})}
    return System(states=["x"], modes=modes)


@pytest.mark.parametrize("n", [2, 10, 59, 90])
def test_many_modes_within_one_instant(n):
    run = ns.simulate(ladder(n), {"x": 1.0}, t_end=2.0)
    assert run.attrs["status"] == "completed"
    assert run.attrs["phase_word"] == f"m0 m{n}"
    assert run["event_path"].values[-1].startswith("m1>m2")


def test_more_modes_or_exits_than_can_be_told_apart():
    with pytest.raises(ModelError, match="modes: 1001 modes; at most 1000"):
        ladder(1000)
    # exits of a path are bits of one integer
    exits = [Exit("x", to="stop")] * 61
    with pytest.raises(ModelError, match="61 exits; at most 60"):
        System(states=["x"], modes={"m": Mode({"x": "0"}, exits)})
