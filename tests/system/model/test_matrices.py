"""Systems from arrays: no digit is lost, and every wrong array is told what is wrong."""

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest
import scipy.linalg
import scipy.sparse
from hypothesis import given
from hypothesis import strategies as st

import nonsmooth as ns
from effort import calls_at_most
from nonsmooth import Exit, Mode, ModelError, System
from nonsmooth.system.algebra.linear import Power, State
from nonsmooth.system.text.evaluate import constant_value

A = np.array([[0.0, 1.0], [-4.0, -0.5]])


def matrix_of(system: System, mode: str = "flow") -> np.ndarray:
    """Coefficients as the system understands its texts."""
    rates = system.structure.modes[mode].rates
    values = system.parameter_values
    return np.array(
        [
            [constant_value(rates[row].coefficient(State(column)), values) for column in rates]
            for row in rates
        ]
    )


def offset_of(system: System, mode: str = "flow") -> list[float]:
    rates = system.structure.modes[mode].rates.values()
    return [constant_value(rate.coefficient(Power(0)), system.parameter_values) for rate in rates]


# ---------------------------------------------------------------- what comes out

finite = st.floats(allow_nan=False, allow_infinity=False)


@given(st.integers(1, 4).flatmap(
    lambda n: st.tuples(
        st.lists(st.lists(finite, min_size=n, max_size=n), min_size=n, max_size=n),
        st.lists(finite, min_size=n, max_size=n),
    )
))  # fmt: skip
def test_every_number_arrives_bit_for_bit(arrays):
    matrix, offset = arrays
    system = System.from_matrices(matrix, offset)
    # a minus zero is a zero: it is left out
    assert np.array_equal(matrix_of(system), matrix)
    assert np.array_equal(offset_of(system), offset)
    assert System.from_toml(system.to_toml()) == system


def test_the_texts_are_as_a_person_would_write_them():
    system = System.from_matrices(
        [[0, 1, 0], [-2.5, -1, 1e-9], [0, 0, 0]],
        [0, "-F*cos(w*t) + 1", -3],
        parameters={"F": 1, "w": 2},
    )
    assert system.states == ("x1", "x2", "x3")
    assert system.modes == {
        "flow": Mode({"x1": "x2", "x2": "-2.5*x1 - x2 + 1e-09*x3 - F*cos(w*t) + 1", "x3": "-3.0"})
    }
    assert System.from_matrices([[0]]).modes["flow"].flow == {"x1": "0"}


@pytest.mark.parametrize(
    "text", ["-a + b", "--a", "+a", " a", "\n-a", "-(a)**2*b", "a", "0", "-2**2"]
)
def test_signs_of_offset_texts(text):
    values = {"a": 3.0, "b": 5.0}
    truth = eval(text.strip(), dict(values))  # texts from above
    for number, first in ((0.0, ""), (2.0, "2.0*x1"), (-2.0, "-2.0*x1")):
        system = System.from_matrices([[number]], [text], parameters=values)
        assert offset_of(system) == [truth], (first, system.modes)
        assert matrix_of(system) == [[number]]


SAME = {
    "lists": A.tolist(),
    "tuples": tuple(map(tuple, A.tolist())),
    "rows": list(A),
    "matrix of integers": [[0, 1], [-4, Fraction(-1, 2)]],
    "decimals": [[Decimal(0), Decimal(1)], [Decimal(-4), Decimal("-0.5")]],
    "float32": A.astype(np.float32),
    "objects": A.astype(object),
    "fortran order": np.asfortranarray(A),
    "view": np.kron(A, np.ones((2, 2)))[::2, ::2],
    "csr": scipy.sparse.csr_array(A),
    "csc": scipy.sparse.csc_matrix(A),
    "data frame": pd.DataFrame(A),
}


@pytest.mark.parametrize("kind", SAME)
def test_arrays_of_many_kinds(kind):
    assert System.from_matrices(SAME[kind]) == System.from_matrices(A)


def test_offsets_of_many_kinds():
    one = System.from_matrices(A, [1.0, -2.0])
    for offset in ((1, -2), np.array([1, -2]), iter([1, -2]), {"flow": [1, -2]}, ["1.0", "-2.0"],
                   np.array(["1.0", "-2.0"])):  # fmt: skip
        assert System.from_matrices(A, offset) == one
    assert (
        System.from_matrices(A) == System.from_matrices(A, None) == System.from_matrices(A, [0, 0])
    )


def test_modes_come_from_the_first_mapping():
    out = [Exit("x1", to="on")]
    system = System.from_matrices(
        {"off": A, "on": 2 * A}, {"on": [0, 1]}, exits={"off": out, "on": Exit("1 + x1", to="off")}
    )
    assert system.mode_names == ("off", "on")
    assert np.array_equal(matrix_of(system, "on"), 2 * A)
    assert offset_of(system, "off") == [0, 0]
    assert offset_of(system, "on") == [0, 1]
    assert system.modes["off"].exits == tuple(out)
    assert system.modes["on"].exits[0].to == "off"


def test_what_is_no_mapping_holds_in_every_mode():
    exits = (Exit("9 - x1", to="stop") for _ in range(1))
    system = System.from_matrices({"a": A, "b": A}, [0, "cos(t)"], exits=exits)
    assert system.modes["a"] == system.modes["b"]
    assert len(system.modes["b"].exits) == 1
    system = System.from_matrices(A, {"a": [0, 1], "b": iter([0, -1])})
    assert system.mode_names == ("a", "b")
    assert np.array_equal(matrix_of(system, "a"), matrix_of(system, "b"))
    system = System.from_matrices(A, exits={"a": Exit("x1", to="b"), "b": Exit("-x1", to="a")})
    assert system.mode_names == ("a", "b")


def test_everything_else_goes_to_the_system():
    system = System.from_matrices(
        A,
        [0, "f"],
        states=["x", "v"],
        name="oscillator",
        parameters={"w": 2.0},
        definitions={"f": "cos(w*t)"},
        outputs={"a": "rate(v)"},
        period="2*pi/w",
        initial={"x": 1},
        describe={"x": "displacement [mm]"},
        require={"w > 0": "a frequency"},
    )
    assert system == System(
        states=["x", "v"],
        name="oscillator",
        parameters={"w": 2.0},
        definitions={"f": "cos(w*t)"},
        outputs={"a": "rate(v)"},
        period="2*pi/w",
        initial={"x": 1},
        describe={"x": "displacement [mm]"},
        require={"w > 0": "a frequency"},
        modes={"flow": Mode({"x": "v", "v": "-4.0*x - 0.5*v + f"})},
    )


@pytest.mark.parametrize("n", [8, 40, 59])
def test_dense_systems_are_built_at_once_and_are_exact(n):
    matrix = np.random.default_rng(n).normal(size=(n, n))
    # some 360 for each entry: with another power of n the largest would take 7 times as many
    with calls_at_most(1000 * n**2):
        system = System.from_matrices(matrix)
    assert np.array_equal(matrix_of(system), matrix)
    assert len(system.modes["flow"].flow["x1"]) < 3000


def test_a_dense_system_runs_as_the_matrix_exponential_says():
    random = np.random.default_rng(1)
    matrix = random.normal(size=(8, 8)) - 2.0 * np.eye(8)
    start = random.normal(size=8)
    system = System.from_matrices(matrix)
    run = ns.simulate(system, dict(zip(system.states, start, strict=True)), t_end=2.0)
    truth = scipy.linalg.expm(2.0 * matrix) @ start
    # rounding of both: condition of eight eigenvectors times some eps
    assert np.allclose(run["end_state"], truth, rtol=0, atol=1e-12 * np.abs(start).max())


# ---------------------------------------------------------------- what is refused

ENTRIES = [
    (np.nan, "is nan; every entry is finite"),
    (np.inf, "is inf; every entry is finite"),
    (-np.inf, "is -inf; every entry is finite"),
    (1 + 2j, "is the complex number (1+2j)"),
    (1 + 0j, "take .real"),
    (np.complex64(1), "take .real"),
    (True, "is the boolean True; write 1 or 0"),
    (np.bool_(False), "is the boolean False"),
    ("k", "is the text 'k'; a matrix holds numbers"),
    ("1.0", "is the text '1.0'"),
    (b"1", "is the text"),
    (None, "is None; every entry is a number"),
    (10**400, "is too large for a double"),
    (object, "every entry is a number"),
]


@pytest.mark.parametrize(("entry", "words"), ENTRIES, ids=[str(row[0])[:20] for row in ENTRIES])
def test_entries_that_are_no_numbers(entry, words):
    matrix = [[0, 1], [entry, -1]]
    for array in (matrix, np.array(matrix, dtype=object)):
        message = refused(array)
        assert message.startswith("matrix[1, 0] (rate of x2, column of x1) is")
        assert words in message
    if not isinstance(entry, str):
        message = refused(A, [0, entry])
        assert message.startswith("offset[1] (rate of x2) is")


def test_arrays_of_the_wrong_kind():
    assert "matrix[0, 0] (rate of x1, column of x1) is the complex" in refused(A + 0j)
    assert "is the boolean" in refused(A > 0)
    assert "is the text" in refused(A.astype(str))
    assert "dates or durations" in refused(A.astype("m8[ns]"))
    assert "masked entries" in refused(np.ma.masked_less(A, 0))
    assert "is nan" in refused(scipy.sparse.csr_array(np.where(A < -1, np.nan, A)))


def refused(*arguments, **options) -> str:
    with pytest.raises(ModelError) as caught:
        System.from_matrices(*arguments, **options)
    return str(caught.value)


SHAPES = [
    ([[1, 2], [3]], "its rows have different lengths"),
    ([[1, 2], 3], "its rows have different lengths"),
    ([np.ones(2), np.ones(3)], "its rows have different lengths"),
    ([[1, 2, 3], [4, 5, 6]], "has 2 rows and 3 columns; it is square"),
    (np.ones((3, 2)), "has 3 rows and 2 columns; it is square"),
    ([], "is empty"),
    ([[]], "is empty"),
    (np.ones((0, 0)), "is empty"),
    ([1, 2], "has the shape (2,); it is square"),
    (np.ones((2, 2, 2)), "has the shape (2, 2, 2)"),
    (3.0, "is no array"),
    ("1 2; 3 4", "is no array"),
    ({1, 2}, "is no array"),
    (np.ones((512, 512)), "is 512 x 512; at most 511 states can run"),
    (scipy.sparse.eye_array(10**6), "is 1000000 x 1000000; at most 511 states"),
    (np.broadcast_to(0.0, (10**6, 10**6)), "at most 511 states"),
]


@pytest.mark.parametrize(("matrix", "words"), SHAPES, ids=[row[1] for row in SHAPES])
def test_matrices_of_the_wrong_shape(matrix, words):
    assert words in refused(matrix)
    assert refused(matrix).startswith("matrix")
    assert words in refused({"m": matrix})
    assert refused({"m": matrix}).startswith("matrix['m']")


def test_no_matrix_at_all():
    said = "matrix: there is none; give matrix= for x' = A x + b, or mass= and stiffness="
    assert refused().startswith(said)
    assert refused(None, [1.0, 2.0]).startswith(said)
    assert "matrix['m'] is no array" in refused({"m": None})


def test_modes_of_different_sizes():
    message = refused({"a": A, "b": [[1.0]]})
    assert message.startswith("matrix['b'] is 1 x 1 and matrix['a'] is 2 x 2; all modes have")


OFFSETS = [
    ([1], "has 1 entries; give 2, one for each state"),
    ([1, 2, 3], "has 3 entries; give 2"),
    ([], "has 0 entries; give 2"),
    ([[0], [1]], "[0] (rate of x1) is [0]; every entry is a number"),
    (np.zeros((2, 1)), "has the shape (2, 1); it is a list of 2 entries: take .ravel()"),
    (np.zeros((2, 2)), "has the shape (2, 2); it is a list of 2 entries"),
    (np.array(1.0), "has the shape ()"),
    ("cos(t)", "give a list of 2 numbers or texts, one for each state, not 'cos(t)'"),
    (1.0, "give a list of 2"),
    ({1.0, 2.0}, "give a list of 2"),
    ([0, "a) + (b"], "[1]: ')' does not belong here"),
    ([0, ""], "[1]: the expression ends"),
    ([0, "cos(t"], "[1]: this parenthesis is never closed"),
]


@pytest.mark.parametrize(("offset", "words"), OFFSETS, ids=[row[1] for row in OFFSETS])
def test_offsets_of_the_wrong_shape(offset, words):
    assert words in refused(A, offset)
    assert refused(A, offset).startswith("offset")
    assert refused({"m": A}, {"m": offset}).startswith("offset['m']")


def test_names_in_offset_texts():
    assert "unknown name 'f'" in refused(A, [0, "f"])


def test_states_and_modes_that_do_not_fit():
    assert "3 names for a matrix of 2 x 2; give 2" in refused(A, states=["x", "v", "a"])
    assert "states: give a list of 2 names, not 'xv'" in refused(A, states="xv")
    assert "states: give a list of 2 names, not 2" in refused(A, states=2)
    assert "declared already" in refused(A, states=["x", "x"])
    assert "declared already" in refused(A, parameters={"x1": 1})
    words = "unknown mode 'contct'; did you mean 'contact'? (known: contact, free); matrix names"
    modes = {"free": A, "contact": A}
    assert f"offset: {words}" in refused(modes, {"contct": [0, 0]})
    assert f"exits: {words}" in refused(modes, exits={"contct": []})
    assert "offset: the mapping is empty" in refused(A, {})
    assert "matrix: 3 is not the name of a mode" in refused({3: A})
    assert "'a b' is not a name" in refused({"a b": A})
    assert "from_matrices makes the modes" in refused(A, modes={})
    assert "exits is a list of Exit, not 3" in refused(A, exits=3)
    assert "write Exit(guard, to=...)" in refused(A, exits=["x1"])
    with pytest.raises(TypeError, match="novelty"):
        System.from_matrices(A, novelty=1)
