"""Any Python value in any argument makes a system or a ModelError, and nothing else."""

import datetime
import decimal
import io
import pathlib

import numpy as np
import pytest
import scipy.sparse
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth import Exit, Mode, ModelError, System

BOUNCE = Exit("1 - x", reset={"v": "-v"})
RIGHT = {
    "states": ["x", "v"],
    "parameters": {"w": 2.0},
    "modes": {"m": Mode({"x": "v", "v": "cos(w*t) - x"}, exits=[BOUNCE])},
}


def values():
    """Values of every kind; made anew, as some can be gone through only once."""
    return [
        None, True, 0, -1, 2.5, float("nan"), 10**400, 1j, "", "x", "a b", "t", "sin", "\ud800",
        "x = v", "1/0", b"x", [], ["x"], ["x", "v"], ["x", 3], [["x"]], {}, {"x": "v"}, {3: 4},
        {"x": 1}, {"x": {}}, {None: None}, {"x"}, np.array([1, 2]), np.eye(2), np.float64(2),
        np.array(3.0), np.array(["x", "v"]), np.bool_(True), decimal.Decimal("1.5"), object,
        datetime.date(2020, 1, 1), len, iter([1, 2]), Mode({"x": "v", "v": "0"}), BOUNCE, [BOUNCE],
        {"m": Mode({"x": "v", "v": "0"})}, {"m": BOUNCE}, {"a": np.eye(2)}, scipy.sparse.eye(2),
        pathlib.Path("x"), [[0, 1], [1]], [0, "cos(t)"], {"m": [0, "cos(t)"]}, ..., "x" * 20_000,
    ]  # fmt: skip


indices = st.integers(0, len(values()) - 1)


def some(*keys: str):
    """One or two of the arguments with any value."""
    return st.dictionaries(st.sampled_from(keys), indices, min_size=1, max_size=2).map(
        lambda chosen: {key: values()[i] for key, i in chosen.items()}
    )


def answered(make) -> None:
    try:
        system = make()
    except ModelError as fault:
        assert str(fault)
        return
    assert System.from_toml(system.to_toml()) == system
    system.explain(io.StringIO())
    assert repr(system)


@given(some("states", "modes", "parameters", "definitions", "outputs", "period", "drift", "require",
            "initial", "describe", "name", "equations", "slow", "signals"))  # fmt: skip
def test_any_word_of_a_system(words):
    answered(lambda: System(**(RIGHT | words)))


@given(some("flow", "exits", "slaved", "definitions", "cells"))
def test_any_word_of_a_mode(words):
    flow = {"flow": {"x": "v", "v": "0"}}
    answered(lambda: System(**RIGHT | {"modes": {"m": Mode(**(flow | words))}}))


@given(some("guard", "to", "reset", "name", "sticks"))
def test_any_word_of_an_exit(words):
    way = {"guard": "1 - x", "reset": {"v": "-v"}}
    answered(
        lambda: System(
            **RIGHT | {"modes": {"m": Mode({"x": "v", "v": "0"}, [Exit(**way | words)])}}
        )
    )


@given(some("matrix", "offset", "exits", "states"))
def test_any_arrays(words):
    answered(lambda: System.from_matrices(**({"matrix": np.eye(2)} | words)))


@pytest.mark.parametrize("i", range(len(values())))
def test_any_value_of_a_parameter_and_any_source(i):
    answered(lambda: System(**RIGHT).with_parameters(w=values()[i]))
    answered(lambda: System.from_toml(values()[i]))
