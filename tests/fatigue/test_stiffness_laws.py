"""The two laws of the open stiffness: numbers, and texts that equal them inside a system."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from fatigue import truth
from nonsmooth.fatigue import cubic_stiffness, cubic_text, guinea_stiffness, guinea_text


def in_a_system(text, crack):
    """Value of a text as the equations of a system see it."""
    system = ns.System(
        name="beam",
        states=["u"],
        parameters={"crack": 1.0},
        equations={"u": f"-({text})"},
        outputs={"k": text},
    )
    run = ns.simulate(system, {"u": 0.0}, times=[0.0, 1.0], parameters={"crack": crack})
    # the flow -k, over a time of one, and the output
    return float(-run["u"][-1]), float(run["k"][0])


@pytest.mark.parametrize("crack", truth.LENGTHS)
@pytest.mark.parametrize("shape", [{}, {"width": 25.0, "span": 90.0, "thickness": 7.0}])
def test_guinea_text_is_the_law(crack, shape):
    expected = guinea_stiffness(crack, **shape)
    assert expected == pytest.approx(float(truth.stiffness(crack, **shape)), rel=1e-13)
    assert in_a_system(guinea_text(**shape), crack) == pytest.approx((expected,) * 2, rel=1e-13)


@pytest.mark.parametrize("crack", truth.LENGTHS)
def test_cubic_text_is_the_law(crack):
    expected = cubic_stiffness(crack)
    assert expected == pytest.approx(4.245e-3 * (20.0 - crack) ** 3, rel=1e-14)
    assert in_a_system(cubic_text(), crack) == pytest.approx((expected,) * 2, rel=1e-13)


def test_texts_take_names_and_expressions():
    text = guinea_text("2*crack", factor="1/(3 + crack)")
    assert in_a_system(text, 4.0)[0] == pytest.approx(guinea_stiffness(8.0) / 7.0, rel=1e-13)
    assert in_a_system(guinea_text(factor=2.0), 4.0)[0] == pytest.approx(
        2.0 * guinea_stiffness(4.0), rel=1e-13
    )
    text = cubic_text("crack - 1", factor="crack", length="6 + crack")
    assert in_a_system(text, 4.0)[0] == pytest.approx(4.0 * 7.0**3, rel=1e-13)


def test_texts_with_a_crack_that_grows_within_the_flow():
    """The crack as a definition in t: the mode is one of Taylor series then."""
    system = ns.System(
        name="beam",
        states=["u"],
        definitions={"crack": "4 + t"},
        equations={"u": guinea_text()},
    )
    found = float(ns.simulate(system, times=[0.0, 6.0])["u"][-1])
    expected = float(truth.mp.quad(truth.stiffness, [4, 7, 10]))
    assert found == pytest.approx(expected, rel=1e-12)


def test_cubic_law_at_its_ends():
    assert cubic_stiffness(20.0) == 0.0
    assert cubic_stiffness(5.0) == pytest.approx(14.327, abs=5e-4)
    np.testing.assert_allclose(cubic_stiffness([0.0, 10.0]), [33.96, 4.245])


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"crack": 20.1}, "crack = 20.1 mm is longer than the specimen's width = 20 mm"),
        ({"crack": -1.0}, "crack = -1 mm is negative"),
        ({"crack": math.nan}, "crack = nan is not finite"),
        ({"crack": 1.0, "factor": 0.0}, "factor = 0.0 must be one positive number"),
        ({"crack": 1.0, "length": -2.0}, "length = -2.0 must be one positive number"),
    ],
)
def test_bad_input_of_the_cubic_law(arguments, says):
    with pytest.raises(ns.OptionError, match=says):
        cubic_stiffness(**arguments)


@pytest.mark.parametrize(
    "text",
    ["", "  ", "a b", "(a", "a)", "a +", "a, b", "a < b", "a^2", "a # b", "a.b", "'a'", "a(", "a;b",
     "a = 1", "f(x=1)", "a if b else c", "(" * 6000, True, None, math.nan],
)  # fmt: skip
@pytest.mark.parametrize("argument", ["crack", "factor", "length", "time"])
def test_texts_of_what_is_no_expression(argument, text):
    laws = {
        "length": [cubic_text],
        "time": [lambda time: ns.fatigue.CrackCurve(5, 1, 2, 3).text(time)],
    }
    for law in laws.get(argument, [guinea_text, cubic_text]):
        with pytest.raises(ns.OptionError, match=f"{argument} = "):
            law(**{argument: text})


def test_a_law_is_one_factor_of_what_is_about_it():
    """Factors that are sums stay together; lines and blanks do no harm."""
    assert in_a_system(cubic_text(" crack\n", factor="1 + 1"), 4.0)[0] == pytest.approx(2 * 16**3)
    text = guinea_text("where(crack > 0, crack, 0)", factor="1 + 1e-3")
    assert in_a_system(text, 4.0)[0] == pytest.approx(1.001 * guinea_stiffness(4.0), rel=1e-13)
    assert cubic_text(4) == "0.004245*(20.0 - (4.0))**3"


def test_bad_input_of_the_texts():
    with pytest.raises(ns.ModelError, match=r"2\.5 times"):
        guinea_text(span=40.0)
    with pytest.raises(ns.OptionError, match="factor"):
        cubic_text(factor=-1.0)
    with pytest.raises(ns.OptionError, match="factor"):
        guinea_text(factor=math.nan)
