"""Code of Taylor modes: its values by a small interpreter, against the text itself."""

import mpmath
import numpy as np
import pytest
from mpmath import mp, mpf

from nonsmooth import Exit, Mode, System
from nonsmooth.engine import taylor_opcodes as op
from nonsmooth.engine.tables import EXACT, TAYLOR
from nonsmooth.errors import ModelError
from nonsmooth.system.text.evaluate import evaluate
from nonsmooth.system.text.grammar import parse
from system.compile.series_code import Series, column_values, tape_slots

PARAMETERS = {"a": 0.7, "b": -1.3, "k": 2.5, "w": 1.9, "p": 0.4}

TEXTS = [
    "x*v", "x**2", "x**3 - v**2", "x*(v + 1)", "x*t", "x*cos(w*t)", "t*cos(w*t)", "1/x", "v/x",
    "a/(1 + t)", "x**a", "x**0.5", "x**1.5", "x**-1", "x**-3", "2**x", "x**v", "t**7",
    "sin(x)", "cos(x*v) + sin(x*v)", "tan(v)", "tan(w*t + p)*x", "exp(-t)", "exp(x - v)",
    "log(1 + x**2)", "sqrt(x)", "tanh(x/a)", "sinh(v) - cosh(v)*x", "atan(x*k)", "asin(v/2)",
    "acos(v/2)", "atan2(v, x)", "atan2(1, x)", "atan2(v, a)", "-x*v", "a - x*v", "-(x*v) - x",
    "x*v - x*v + x*k", "cos(w*t + p)*v", "sin(p - w*t)*v", "cos(w*t)*cos(k*t)*x", "x*0 + v**2",
    "cos(t**2)", "sin(x + w*t)", "max(a, b)*x**2", "where(a > b, x**2, v)", "x**(1/2)*v**(4/2)",
    "cos(w*t - w*t)*x**2", "3", "k", "(x + v)**2/(x + v)", "exp(sin(x)*cos(v))**2", "5*x/v/2",
    "x**16", "abs(b)*x**2",
]  # fmt: skip


def system_of(text, **more):
    """Text as a rate beside a nonlinear one, which makes the mode a Taylor mode."""
    return System(
        states=["x", "v"],
        parameters=PARAMETERS,
        modes={"m": Mode({"x": text, "v": "x*v"}, **more.pop("mode", {}))},
        **more,
    )


def run_order_zero(system, states, t):
    program = system.compiled.program
    assert program.kinds[0] == TAYLOR
    slots = tape_slots(program, system.parameter_values.values())
    series = Series(program, 0, slots)
    series.order(0, column_values(program, slots, states, t))
    return series


@pytest.mark.parametrize("text", TEXTS)
def test_code_has_the_value_of_the_text(text):
    system = system_of(text)
    rng = np.random.default_rng(5)
    for _ in range(5):
        x, v, t = rng.uniform(0.1, 1.5, 3)
        series = run_order_zero(system, [x, v], t)
        direct = float(evaluate(parse(text), {**PARAMETERS, "x": x, "v": v, "t": t}))
        # some tens of operations of 1.1e-16; terms that cancel are of order 1
        assert series.outlet(0)[0] == pytest.approx(direct, rel=2e-14, abs=2e-14)
        assert series.outlet(1)[0] == pytest.approx(x * v, rel=1e-15)


SERIES = [
    ("x*v - x**3", lambda x, v: x * v - x**3),
    ("tan(x) + tanh(v)", lambda x, v: mp.tan(x) + mp.tanh(v)),
    ("exp(x)/sqrt(v)", lambda x, v: mp.exp(x) / mp.sqrt(v)),
    ("sin(x*v) + cos(x*v)", lambda x, v: mp.sin(x * v) + mp.cos(x * v)),
    ("sinh(x) + cosh(v)", lambda x, v: mp.sinh(x) + mp.cosh(v)),
    ("asin(x/4) + acos(v/4)", lambda x, v: mp.asin(x / 4) + mp.acos(v / 4)),
    ("atan(x) + atan2(v, x)", lambda x, v: mp.atan(x) + mp.atan2(v, x)),
    ("log(x)*x**a", lambda x, v: mp.log(x) * x ** mpf(0.7)),
    ("x**v", lambda x, v: x**v),
]


@pytest.mark.parametrize(("text", "function"), SERIES, ids=[row[0] for row in SERIES])
def test_series_of_the_code(text, function):
    # x = 0.9 + 0.3 s, v = 0.6 - 0.2 s + 0.5 s^2: coefficients of f(x(s), v(s)) by mpmath
    x = [0.9, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0]
    v = [0.6, -0.2, 0.5, 0.0, 0.0, 0.0, 0.0]
    program = system_of(text).compiled.program
    series = Series(program, 0, tape_slots(program, PARAMETERS.values()))
    for k in range(7):
        series.order(k, [x[k], v[k], 1.0 if k == 0 else 0.0])

    def along(s):
        return function(*(sum(c * s**i for i, c in enumerate(series)) for series in (x, v)))

    with mp.workdps(40):
        truth = mpmath.taylor(along, 0, 6)
    assert series.outlet(0) == pytest.approx([float(c) for c in truth], rel=1e-12, abs=1e-12)


def test_linear_modes_stay_exact():
    system = System(
        states=["x", "v"],
        modes={
            "free": Mode({"x": "v", "v": "-x"}, exits=[Exit("1 - x", to="hard")]),
            "hard": Mode({"x": "v", "v": "-x**3"}, exits=[Exit("x - 1", to="free")]),
        },
    )
    program = system.compiled.program
    assert list(program.kinds) == [EXACT, TAYLOR]
    assert set(program.flow["mode"]) == {0} and set(program.guards["mode"]) == {0}
    assert program.code_rows[0].tolist() == (0, 0, 0)


@pytest.mark.parametrize("place", ["guard", "reset"])
def test_one_nonlinear_text_makes_a_taylor_mode(place):
    guard = "1 - x**3" if place == "guard" else "1 - x**2"
    reset = "-v**2" if place == "reset" else "-v"
    flow = {"x": "v", "v": "-sin(x)" if place == "reset" else "-x"}
    system = System(
        states=["x", "v"], modes={"m": Mode(flow, exits=[Exit(guard, reset={"v": reset})])}
    )
    program = system.compiled.program
    assert list(program.kinds) == [TAYLOR] and len(program.flow) == 0
    series = run_order_zero(system, [0.3, 0.7], 0.0)
    assert series.outlet(2)[0] == pytest.approx(0.973 if place == "guard" else 0.91)
    assert program.outlets[0, 3] == -1  # x is not reset
    assert series.outlet(4)[0] == pytest.approx(-0.49 if place == "reset" else -0.7)


@pytest.mark.parametrize(
    ("guard", "reset"), [("1 - x**2", "-v"), ("1 - x", "-v**2"), ("x*v", "-v**3")]
)
def test_curved_exits_leave_a_linear_flow_in_closed_form(guard, reset):
    system = System(
        states=["x", "v"],
        modes={"m": Mode({"x": "v", "v": "-x"}, exits=[Exit(guard, reset={"v": reset})])},
    )
    program = system.compiled.program
    assert list(program.kinds) == [EXACT] and len(program.flow) == 2
    assert len(program.products) == guard.count("x**2") + guard.count("x*v")
    first, _, end = program.code_rows[0]
    assert end > first  # rows at an instant are made by series


def test_resets_come_after_what_runs_for_each_order():
    system = system_of("x**2", mode={"exits": [Exit("1 - x*v", reset={"v": "-v*exp(x)"})]})
    first, middle, end = system.compiled.program.code_rows[0]
    opcodes = system.compiled.program.code["opcode"]
    assert op.EXP not in opcodes[first:middle] and op.EXP in opcodes[middle:end]


def test_shared_parts_are_written_once():
    # written out, d8 has more than 2^8 parts
    chain = {f"d{i}": f"d{i - 1}*d{i - 1} + d{i - 1}" for i in range(1, 9)}
    system = system_of("d8", definitions={"d0": "x*v", **chain})
    program = system.compiled.program
    # x*v, which is the rate of v as well; then a sum of a square and a term for each
    assert program.code["opcode"].tolist() == [op.MULTIPLY, *[op.COMBINE] * 8]
    assert len(program.terms) == 2 * 8


def test_products_that_are_read_twice_stay_instructions():
    guard = {"exits": [Exit("9 - x*v", to="stop"), Exit("9 + v**2 - x", to="stop")]}
    program = system_of("3*x*v - 2*v**2", mode=guard).compiled.program
    # the rate of v and the guards share x*v and v^2 with the rate of x
    assert sorted(program.code["opcode"]) == [*[op.COMBINE] * 3, op.MULTIPLY, op.SQUARE]
    alone = system_of("3*x*v - 2*v**2 + x**2*v").compiled.program
    # x*v is the rate of v; v^2 and x^2*v stand in the sum only, x^2 in a product
    assert sorted(alone.code["opcode"]) == [op.COMBINE, op.MULTIPLY, op.SQUARE]
    first, last, middle = (int(alone.code[-1][name]) for name in ("a", "b", "c"))
    assert (middle - first, last - middle) == (1, 2)


def test_phases_and_frequencies():
    program = system_of("x*cos(w*t + p) + v*sin(w*t) + x*cos(-w*t)").compiled.program
    assert program.sizes[:3] == (2, 0, 1)
    assert system_of("x*t").compiled.program.sizes.powers == 1


# ---------------------------------------------------------------- names


def test_outputs_and_definitions_stand_wherever_states_do():
    system = System(
        states=["x", "v"],
        definitions={"d": "force + 1"},
        outputs={"force": "x**2", "twice": "2*d"},
        modes={"m": Mode({"x": "v", "v": "-twice"}, exits=[Exit("9 - force", to="stop")])},
    )
    series = run_order_zero(system, [3.0, 0.0], 0.0)
    assert series.outlet(1)[0] == -20.0 and series.outlet(2)[0] == 0.0


def test_slaved_states_are_replaced_and_their_rates_derived():
    # p = x^2 v: p' = 2 x x' v + x^2 v' = 2 x v^2 - x^2 sin(p)
    system = System(
        states=["p", "x", "v", "z"],
        modes={
            "m": Mode({"x": "v", "v": "-sin(p)", "z": "rate(p) + q(p)".replace("q(p)", "p")},
                      slaved={"p": "x**2*v"})
        },
    )  # fmt: skip
    x, v = 0.7, 1.1
    series = run_order_zero(system, [99.0, x, v, 0.0], 0.0)
    p = x**2 * v
    assert series.outlet(0)[0] == pytest.approx(p, rel=1e-15)
    assert series.outlet(2)[0] == pytest.approx(-np.sin(p), rel=1e-15)
    assert series.outlet(3)[0] == pytest.approx(2 * x * v**2 - x**2 * np.sin(p) + p, rel=1e-14)
    rows = system.compiled.program.code
    others = rows[rows["opcode"] != op.COMBINE]
    registers = [*others["a"], *others["b"][others["opcode"] == op.MULTIPLY]]
    registers += [*system.compiled.program.terms["reg"]]
    assert 0 not in registers  # p itself is no operand


def test_linear_relations_are_solved_in_taylor_modes_too():
    system = System(
        states=["p", "q", "x"],
        modes={"m": Mode({"x": "-p*x"}, slaved={"p": "p + q = x", "q": "p - q = 1"})},
    )
    series = run_order_zero(system, [0.0, 0.0, 5.0], 0.0)
    assert [series.outlet(i)[0] for i in range(3)] == [3.0, 2.0, -15.0]


@pytest.mark.parametrize(
    ("slaved", "words"),
    [
        ({"p": "sin(q)", "q": "cos(p)"}, ["p -> q -> p", "circle"]),
        ({"p": "sin(p)", "q": "x"}, ["p -> p"]),
    ],
)
def test_relations_that_are_refused(slaved, words):
    with pytest.raises(ModelError) as caught:
        System(
            states=["p", "q", "x"],
            modes={
                "m": Mode({"x": "-x**2"} | ({} if "q" in slaved else {"q": "0"}), slaved=slaved)
            },
        )
    for word in words:
        assert word in str(caught.value)


# ---------------------------------------------------------------- checks on both kinds


def refused(word, **words):
    with pytest.raises(ModelError, match=word):
        System(**{"states": ["x", "v"]} | words)


def test_checks_hold_for_taylor_modes():
    flow = {"x": "v", "v": "-sin(v)"}
    System(states=["x", "v"], drift=["x"], modes={"m": Mode(flow)})
    refused("the rate of 'v' in mode 'm' depends on 'x'", drift=["x"],
            modes={"m": Mode({"x": "v", "v": "-sin(x)"})})  # fmt: skip
    refused("the reset of 'x'", drift=["x"],
            modes={"m": Mode(flow, exits=[Exit("1 - v", reset={"x": "x*v"})])})  # fmt: skip
    System(states=["x", "v"], drift=["x"],
           modes={"m": Mode(flow, exits=[Exit("1 - v", reset={"x": "x + v**2"})])})  # fmt: skip
    refused("'-1' depends on no state", modes={"m": Mode(flow, exits=[Exit("-1", to="stop")])})
    refused("is inf for the parameters", parameters={"e": 0}, modes={
        "m": Mode({"x": "v", "v": "tanh(x/e)"})})  # fmt: skip
    refused("of 'v' in mode 'm': a coefficient is inf; numbers go up to about 1.8e308",
            modes={"m": Mode({"x": "v", "v": "1e999*x"})})  # fmt: skip
    refused("1/0 is inf; write a finite number", modes={"m": Mode({"x": "v", "v": "x*(1/0)"})})
    refused("not a period of the equations", period="1",
            modes={"m": Mode({"x": "v", "v": "x*cos(t)"})})  # fmt: skip
    System(states=["x", "v"], period="2*pi",
           modes={"m": Mode({"x": "v", "v": "x*cos(t)*tan(t)"})})  # fmt: skip


def test_rest_state_of_the_program():
    system = system_of("x**2", initial={"v": "2*a"})
    program = system.compiled.program
    assert program.rest_slots[0] == -1
    slots = tape_slots(program, PARAMETERS.values())
    assert slots[program.rest_slots[1]] == 1.4


def test_explain_names_the_kind_and_the_reason(capsys):
    system_of("sin(x) - v").explain()
    shown = capsys.readouterr().out
    assert "mode m: Taylor series" in shown
    assert "sin(x)" in shown
