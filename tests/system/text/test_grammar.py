"""The grammar against Python's own, its bounds, and where the caret points.

Texts are generated here from a safe list of parts, so that Python may evaluate them; the
package itself never evaluates text.
"""

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from effort import calls_at_most
from nonsmooth.errors import ModelError
from nonsmooth.system.text.evaluate import constant_value, evaluate
from nonsmooth.system.text.expressions import Call, Name, Number, to_text, walk
from nonsmooth.system.text.grammar import MAX_DEPTH, MAX_LENGTH, parse, parse_condition

VALUES = {"x": 0.7, "y": -1.3, "E": 2.5, "e": 0.4, "I": -0.6}
SMOOTH = {
    "sin": math.sin, "cos": math.cos, "tanh": math.tanh, "atan": math.atan, "exp": math.exp,
    "abs": abs, "min": min, "max": max, "atan2": math.atan2,
}  # fmt: skip

numbers = st.sampled_from(["2", "3", "0.5", ".25", "1e-1", "2.5E+0", "7."])
leaves = st.one_of(numbers, st.sampled_from(sorted(VALUES)))


def _grow(inner):
    binary = st.tuples(inner, st.sampled_from(["+", "-", "*", "/", " + ", " * "]), inner)
    return st.one_of(
        binary.map("".join),
        inner.map("({})".format),
        inner.map("-{}".format),
        inner.map("+{}".format),
        st.tuples(inner, st.sampled_from(["2", "3", "-1", "-2", "2**1", "-1**2"])).map(
            lambda pair: "**".join(pair)
        ),
        st.tuples(st.sampled_from(["sin", "cos", "tanh", "atan"]), inner).map(
            lambda pair: f"{pair[0]}({pair[1]})"
        ),
        st.tuples(st.sampled_from(["min", "max", "atan2"]), inner, inner).map(
            lambda three: f"{three[0]}({three[1]}, {three[2]})"
        ),
    )


texts = st.recursive(leaves, _grow, max_leaves=12)


def python_value(text):
    return eval(text, {"__builtins__": {}}, {**SMOOTH, **VALUES})  # text is made above


@given(texts)
def test_precedence_is_that_of_python(text):
    # Same operations in the same order on the same doubles: equal up to the libm in use,
    # which numpy does not share with Python, so a few ulps per function remain.
    try:
        expected = python_value(text)
    except (ZeroDivisionError, OverflowError):
        return
    if isinstance(expected, complex) or not 1e-6 < abs(expected) < 1e12:
        return  # cancelled or overflowing: nothing to compare with
    with np.errstate(all="ignore"):
        found = float(evaluate(parse(text), VALUES))
    size = sum(_sizes(parse(text)))
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-12 * size)


def _sizes(tree):
    """Sizes of all parts: cancellation in one of them shows in the value."""
    with np.errstate(all="ignore"):
        parts = (abs(float(evaluate(node, VALUES))) for node in walk(tree))
        return [part for part in parts if math.isfinite(part)]


@pytest.mark.parametrize(
    "text",
    ["-2**2", "2**-1", "2**3**2", "-2**-2", "2*-3", "8/4/2", "8/4*2", "8-4-2", "1 - -1", "--3",
     "+-+3", "-(2)**2", "2**-2**2", "6/2*(1+2)", "1e3*2.e-1", "-3*-2", "2*3**2/-4"],
)  # fmt: skip
def test_precedence_of_known_traps(text):
    # all of these are exact in binary or a single division, so the doubles agree bit for bit
    assert float(evaluate(parse(text), {})) == eval(text)


@given(texts)
def test_text_of_a_tree_means_the_same(text):
    # The value must survive bit for bit: to_text is what derived systems and labels show.
    tree = parse(text)
    again = parse(to_text(tree))
    with np.errstate(all="ignore"):
        one, other = float(evaluate(tree, VALUES)), float(evaluate(again, VALUES))
    # sums in parentheses are flattened, which moves a rounding error between terms
    size = sum(_sizes(tree))
    assert one == pytest.approx(other, rel=1e-9, abs=1e-12 * size, nan_ok=True)


@given(texts)
def test_text_of_a_tree_is_stable(text):
    # one round trip reaches a text that the next one repeats
    shown = to_text(parse(text))
    assert to_text(parse(shown)) == shown


def test_numbers_and_names():
    # e, E and I are ordinary names; an exponent belongs to a number only after a digit
    assert parse("2e3") == Number(2000.0)
    assert parse("e3") == Name("e3")
    assert parse("E*e - I") == Call(
        "+", (Call("*", (Name("E"), Name("e"))), Call("neg", (Name("I"),)))
    )
    assert parse(3) == Number(3.0)
    assert parse(-0.1) == Number(-0.1)
    assert parse("a\n + b") == parse("a+b")


REFUSED = [
    # text, column of the caret, words in the message
    ("__import__('os')", 11, "no strings"),
    ("x.real", 1, "no attributes"),
    ("np.cos(t)", 2, "write cos, not np.cos"),
    ("-c*x'", 4, "or rate(x)"),
    ("x.__class__", 1, "no attributes"),
    ("(x).y", 3, "no attributes"),
    ("lambda*x", 0, "write lambda_"),
    ("2*lambda", 2, "reserved word"),
    ("a + is", 4, "reserved word"),
    ("True", 0, "reserved word"),
    ("lamb(x)", 0, "unknown function 'lamb'"),
    ("2*sine(x)", 2, "did you mean 'sin'"),
    ("2*ln(x)", 2, "it is log here"),
    ("pow(x, 2)", 0, r"it is ** here"),
    ("0,5*x", 1, "a decimal point is a point"),
    ("where(x > 0 && y > 0, 1, 2)", 12, "join conditions by 'and'"),
    ("\N{MINUS SIGN}x", 0, "sign of the keyboard"),
    ("eval(x)", 0, "unknown function 'eval'"),
    ("2x", 1, "write products with *"),
    ("2 x", 2, "write products with *"),
    ("2(x)", 1, "write products with *"),
    ("(x)(y)", 3, "write products with *"),
    ("(x)y", 3, "write products with *"),
    ("1.2.3", 3, "operator is missing"),
    ("0x10", 1, "operator is missing"),
    ("1_000", 1, "operator is missing"),
    ("a^2", 1, "write a power as **"),
    ("a//2", 2, "value is expected"),
    ("(a + b", 0, "never closed"),
    ("a*(b - sin(x)", 2, "never closed"),
    ("a + b)", 5, "does not belong here"),
    ("()", 1, "value is expected"),
    ("", 0, "expression ends"),
    ("a +", 3, "expression ends"),
    ("a = b", 2, "right-hand side"),
    ("a > b", 2, "first argument of where; a guard is an expression that falls below 0"),
    ("where(a, 1, 2)", 7, "needs a comparison"),
    ("where(a > 1, 2)", 0, "takes 3"),
    ("sin", 0, "needs an argument"),
    ("sin()", 4, "value is expected"),
    ("sin(x, y)", 0, "takes 1"),
    ("min(x)", 0, "at least 2"),
    ("clip(x, 1, -1)", 0, "clip from 1 to -1: give the lower bound first"),
    ("rate(x + 1)", 0, "name of a state"),
    ("x[0]", 1, "no indexing"),
    ("x; y", 1, "one expression"),
    ("x y", 2, "operator is missing"),
    ("a@b", 1, "no meaning"),
    ("x\u00b2", 1, "no meaning"),
    ("\u03c9*t", 0, "no meaning"),
    ("a\\b", 1, "no meaning"),
    ("a\0b", 1, "no meaning"),
]


@pytest.mark.parametrize(("text", "column", "words"), REFUSED, ids=[row[0] for row in REFUSED])
def test_caret_stands_under_the_fault(text, column, words):
    with pytest.raises(ModelError) as caught:
        parse(text, where="here")
    message, shown, caret = str(caught.value).split("\n")
    assert message.startswith("here: ")
    assert words in message
    assert shown.rstrip() == ("    " + text.replace("\0", " ")).rstrip()
    assert caret.index("^") - 4 == column


def test_caret_in_a_long_text():
    # only a window around the fault is shown, and the caret stays under it
    text = "x + " * 100 + "y^2" + " + x" * 100
    with pytest.raises(ModelError) as caught:
        parse(text)
    _, shown, caret = str(caught.value).split("\n")
    assert shown[caret.index("^")] == "^"
    assert len(shown) < 100


ATTACKS = {
    "10 MB of sum": "1+" * 5_000_000 + "1",
    "10 MB of name": "a" * 10_000_000,
    "5000 parentheses": "(" * 5000 + "x" + ")" * 5000,
    "4000 parentheses": "(" * 4000 + "x" + ")" * 4000,
    "5000 minus signs": "-" * 5000 + "x",
    "4000 divisions": "1" + "/2" * 4000,
    "divisions and products": "x" + "*x/x" * 2000,
    "3000 powers": "x" + "**x" * 3000,
    "2000 signed powers": "x" + "**-x" * 2000,
    "2000 functions": "sin(" * 2000 + "x" + ")" * 2000,
    "unclosed": "(" * 9999,
    "spaces and a fault": "x" + " " * 9000 + "@",
    "commas": "min(" + "x," * 4000 + ")",
}


@pytest.mark.parametrize("name", ATTACKS)
def test_hostile_texts_are_refused_at_once(name):
    # up to 18 calls for a character; what is longer than MAX_LENGTH is not read
    with calls_at_most(50 * MAX_LENGTH), pytest.raises(ModelError):
        parse(ATTACKS[name])


@pytest.mark.parametrize("text", ["+".join(["x"] * 2500), "*".join(["x"] * 2500)])
def test_long_flat_texts_are_fine(text):
    # sums and products hold many terms in one node, so they are not deep
    tree = parse(text)
    assert len(text) <= MAX_LENGTH
    assert len(tree.arguments) == 2500
    assert parse(to_text(tree)) == tree


def test_depth_just_inside_the_bound():
    inside = MAX_DEPTH - 1
    assert parse("(" * inside + "x" + ")" * inside) == Name("x")
    with pytest.raises(ModelError, match="nested deeper"):
        parse("(" * MAX_DEPTH + "x" + ")" * MAX_DEPTH)


@pytest.mark.parametrize("given", [None, True, b"x", ["x"], 1j])
def test_only_texts_and_numbers_are_expressions(given):
    with pytest.raises(ModelError, match="text or a number"):
        parse(given)


@given(st.text(max_size=40))
def test_any_text_parses_or_is_a_model_error(text):
    try:
        tree = parse(text)
    except ModelError:
        return
    to_text(tree)


@given(
    st.lists(st.sampled_from([*"()+-*/,<>=xt2. ", "**", "sin(", "where(", "rate("]), max_size=25)
)
def test_any_row_of_tokens_parses_or_is_a_model_error(row):
    try:
        tree = parse("".join(row))
    except ModelError:
        return
    assert to_text(parse(to_text(tree))) == to_text(tree)


@pytest.mark.parametrize(
    "text",
    [
        "(a + b) + c",
        "(a*b)*c",
        "a + (b + c)", "a*(b*c)", "a - (b - c)", "-(-a)", "a/(b/c)", "(a/b)/c", "(-2)**2",
        "-2**2", "(a**b)**c", "a**b**c", "a**(-b)", "a - (-2)", "a*(-2)", "-(a + b)*c",
    ],
)  # fmt: skip
def test_text_of_a_tree_parses_to_an_equal_tree(text):
    # what the docstring of to_text promises, on the shapes that parentheses make
    tree = parse(text)
    assert parse(to_text(tree)) == tree


JOINED = [
    "a > b and c > d",
    "a > b or c > d",
    "not a > b",
    "not (a > b or c <= d)",
    "a > b or c > d and b < c",
    "(a > b or c > d) and b < c",
    "(a + b)*2 > c and not (not d < a)",
    "((a > b)) or (a) < (b - c) and a < c < d",
    "a < b < c or not a < d",
]


@pytest.mark.parametrize("text", JOINED)
def test_joined_conditions_mean_what_python_means(text):
    # Python's own and, or, not judge every order of the four values, ties included
    choice = parse(f"where({text}, 1, 2)")
    condition = parse_condition(text, where="require")
    for values in product((-1.0, 0.0, 1.0), repeat=4):
        names = dict(zip("abcd", values, strict=True))
        truth = bool(eval(text, {}, names))
        assert constant_value(choice, names) == (1.0 if truth else 2.0)
        assert bool(constant_value(condition, names)) == truth


def test_joined_conditions_are_choices_in_a_row():
    assert parse("where(a > 1 and b > 2, x, y)") == parse("where(a > 1, where(b > 2, x, y), y)")
    assert parse("where(a > 1 or b > 2, x, y)") == parse("where(a > 1, x, where(b > 2, x, y))")
    assert parse("where(not a > 1, x, y)") == parse("where(a > 1, y, x)")


@pytest.mark.parametrize(
    ("text", "at", "message"),
    [
        ("where(a and b > 1, 1, 2)", 8, "needs a comparison"),
        ("where(a > 1 and b, 1, 2)", 17, "needs a comparison"),
        ("where(a > 1 and, 1, 2)", 15, "value is expected"),
        ("where((a), 1, 2)", 8, "needs a comparison"),
        ("where(a > 1 & b > 1, 1, 2)", 12, "join conditions by 'and'"),
        ("where(a > 1 | b > 1, 1, 2)", 12, "join conditions by 'or'"),
        ("-|a|*b", 1, "write a size as abs"),
        ("a if a > 0 else b", 2, "write a choice as where"),
        ("where(!(a > 1), 1, 2)", 6, "write not"),
        ("where(a == 0, 1, 2)", 8, "'==' has no meaning here; .* compare by <, <=, > or >="),
        ("where(a != 0, 1, 2)", 8, "'!=' has no meaning here; .* compare by <, <=, > or >="),
        ("a > 1 and b > 1", 2, "first argument of where"),
        ("a and b", 2, "first argument of where"),
        ("max(a or b, 1)", 6, "'or' joins comparisons"),
    ],
)
def test_faults_of_joined_conditions(text, at, message):
    with pytest.raises(ModelError, match=message) as caught:
        parse(text)
    assert str(caught.value).splitlines()[-1].index("^") - 4 == at


def test_many_joined_conditions_are_bounded_as_depth_is():
    # each comparison is one choice deeper, and every walk over trees goes as deep
    most = " and ".join(["a > b"] * 50)
    assert parse(f"where({most}, 1, 2)").size > 50
    with pytest.raises(ModelError, match="nested deeper than 60"):
        parse(f"where({most} and {most}, 1, 2)")
    with pytest.raises(ModelError, match="nested deeper than 60"):
        parse(f"where({most}, where({most}, 1, 2), 2)")
