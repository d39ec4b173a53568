"""Values and sizes of expressions at many points, and what is told from them."""

import math

import numpy as np
import pytest

from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.algebra.identities import is_rounding, vanishes
from nonsmooth.system.algebra.points import COUNT, Points, put_on
from nonsmooth.system.algebra.value_tape import ValueTape, sizes_of, table
from nonsmooth.system.cells.attraction import may_attract
from nonsmooth.system.text.evaluate import evaluate
from nonsmooth.system.text.grammar import parse

TEXTS = [
    "2",
    "pi",
    "x",
    "-x + 2*x*y - x/y",
    "x**2 + y**-1 + x**y + 2**x",
    "sin(x)*cos(y) + tan(x) + atan2(y, x) + asin(x/2) + acos(x/2) + atan(x)",
    "exp(-x) + log(y) + sqrt(x*y) + sinh(x) + cosh(y) + tanh(x)",
    "where(x > 1, x, y) + abs(x - 1) + sign(y - 1) + min(x, y, 1) + max(x, y) + clip(x, 0.5, 1)",
    "heaviside(x - 1) + where(x <= y, 1, 2)",
]


def node(text, *states):
    return Graph(states).imported(parse(text))


@pytest.mark.parametrize("text", TEXTS)
def test_values_are_those_of_the_text(text):
    tree, points = parse(text), Points()
    found = table(ValueTape([tree, tree]).values(points), COUNT)
    for k in range(COUNT):
        direct = float(evaluate(tree, {name: points[name][k] for name in ("x", "y")}))
        assert found[:, k].tolist() == [direct, direct]


def test_what_has_no_value_is_no_number():
    below = {"x": np.array([-1.0, 0.0, 4.0])}
    (found,) = table(ValueTape([parse("sqrt(x)/x")]).values(below), 3)
    assert np.isnan(found[:2]).all()
    assert found[2] == 0.5


def test_shared_parts_are_worked_out_once():
    """Written out it has 2**200 products."""
    graph = Graph(["x"])
    power = graph.name("x")
    for _ in range(200):
        power = graph.multiply(power, power)
    tape = ValueTape([power])
    assert len(tape.calls) == 200
    assert tape.values({"x": -1.0}) == [1.0]


def test_the_rate_of_a_signal_is_a_name():
    tape = ValueTape([parse("u + 2*rate(u)")])
    assert set(tape.names) == {"u", "rate(u)"}
    assert tape.values({"u": 1.0, "rate(u)": 3.0}) == [7.0]


@pytest.mark.parametrize(
    ("text", "size"),
    [
        ("x - y", 5.0),
        ("x*(x - y)", 10.0),
        ("(x - y)/y", 5.0 / 3.0),
        ("sqrt((x - y)**2)", 5.0),
        ("log(y - x)", 5.0),  # log 1 = 0 is off by the rounding of its argument, which is 1
        ("1e-9*x", 2e-9),
        ("cos(x - y)", math.cos(1.0)),  # where cos is not zero, rounding stays small beside it
        ("sin(x - y)", 5.0),
    ],
)
def test_sizes_of_terms(text, size):
    tape = ValueTape([parse(text)])
    parts = tape.run({"x": 2.0, "y": 3.0})
    (found,) = sizes_of(tape, parts)
    assert float(found) == pytest.approx(size, rel=1e-15)


def test_points_do_not_depend_on_what_was_asked_before():
    one, other = Points(), Points()
    assert one["x"].tolist() != one["y"].tolist()
    assert other["y"].tolist() == one["y"].tolist()
    assert all(0.3 <= value <= 1.7 for value in one["x"])


@pytest.mark.parametrize(
    ("text", "answer"),
    [
        ("sin(x)**2 + cos(x)**2 - 1", True),
        ("(x + y)**2 - x**2 - 2*x*y - y**2", True),
        ("x - x", True),
        ("exp(log(x)) - x", True),
        ("x - y", False),
        ("1e-12*x", False),
        ("log(-x) - log(-x)", False),  # it has no values: nothing is told
        ("log(x - 1) + log(x - 1) - log((x - 1)**2)", True),  # values at some of the points
    ],
)
def test_identities(text, answer):
    assert vanishes([parse(text)]) is answer


def test_zero_beside_others():
    assert not vanishes([parse("1e-12*x")])
    assert vanishes([parse("1e-12*x")], [parse("y")])


@pytest.mark.parametrize(
    ("surface", "text", "answer"),
    [
        ("x**2 + y**2 - 1", "x**4 - (1 - y**2)**2", True),
        ("x**2 + y**2 - 1", "x - y", False),
        ("exp(x) - y", "log(y) - x", True),
        ("x**2 + y**2 + 1", "x - x", False),  # it has no points
    ],
)
def test_identities_on_curved_surfaces(surface, text, answer):
    graph = Graph(["x", "y"])
    points = put_on(graph, [graph.imported(parse(surface))], {})
    assert points.able.any() == (surface != "x**2 + y**2 + 1")
    # what Newton's method leaves is 1e-12, beside terms that are about 1
    assert vanishes([parse(text)], [parse("1")], points) is answer


def test_identities_on_surfaces_that_are_solved_for():
    graph = Graph(["x", "y"])
    points = put_on(graph, [], {"x": graph.imported(parse("2*y"))})
    assert points["x"].tolist() == (2.0 * points["y"]).tolist()
    assert vanishes([parse("x/y - 2")], points=points)


def test_rounding_is_told_from_small_values():
    """The terms of 14 differences of 10 x and 7 x have 17**14 x**14, 4e10 times the product."""
    product = parse("*".join(["(10*x - 7*x)"] * 14))
    assert vanishes([product])
    assert not is_rounding(product)
    assert is_rounding(parse("(x + y)**2 - x**2 - 2*x*y - y**2"))
    assert not is_rounding(parse("1e-9*x + y - y"))
    # a part that divides by what is left of x - x has no meaning, and hides what has one
    assert not is_rounding(parse("x + (x + y)/((x + 0.1) - x - 0.1 + 1e-20)"))


@pytest.mark.parametrize(
    ("rates", "answer"),
    [
        (["x", "x + 1"], True),  # -1 < x < 0
        (["2*x", "x"], False),
        (["2*exp(x)", "exp(x)"], False),  # no zero, but one is twice the other
        (["2*exp(x)", "exp(x) + x**2"], True),  # in doubt: no zeros are found
        (["x", "-y"], True),
        (["x*(1 + y**2)", "x", "2*x"], False),
        (["x*(1 + y**2)", "x", "x + 1"], True),
        (["2", "1"], False),
        (["2", "-1"], True),
        (["0", "1"], True),
        (["x*(x**2 + y**2)", "x*y**2"], True),  # in doubt: one touches zero
    ],
)
def test_signs_of_rates(rates, answer):
    assert may_attract([node(rate, "x", "y") for rate in rates]) is answer
