"""Outputs in modes of every kind, from the recorded samples by numpy."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, System
from nonsmooth.errors import ModelError

W, P, K = 1.2, 0.3, 20.0


def value(outputs, equations, **words):
    system = System(
        states=["x", "v"],
        parameters={"w": W, "p": P, "k": K, "zero": 0},
        period="2*pi/w",
        outputs=outputs,
        equations=equations,
        **words,
    )
    run = ns.simulate(system, {"x": 0.4}, periods=3)
    assert run.attrs["status"] == "completed"
    return run, run["x"].values, run["v"].values, run["time"].values


def test_outputs_of_a_taylor_mode():
    run, x, v, t = value(
        {"acceleration": "rate(v)", "jerk_free": "2*acceleration + energy", "side": "sign(x)",
         "energy": "v**2/2 + x**4/4", "drive": "cos(w*t + p)", "late": "t",
         "chosen": "where(zero > 0, x/zero, v)"},
        {"x": "v", "v": "-x**3 - v/5 + drive"},
    )  # fmt: skip
    acceleration = -(x**3) - v / 5 + np.cos(W * t + P)
    expected = {
        "acceleration": acceleration,
        "jerk_free": 2 * acceleration + v**2 / 2 + x**4 / 4,
        "side": np.sign(x),
        "late": t,
        "chosen": v,
    }
    for name, values in expected.items():
        # a few operations on numbers of order 1
        assert np.allclose(run[name], values, rtol=1e-14, atol=1e-14), name


def test_outputs_in_cells_of_both_kinds():
    for force in ("k*max(x - p, 0)", "k*max(x - p, 0)**2"):
        run, x, v, t = value(
            {"acceleration": "rate(v)", "reaction": force, "size": "abs(v)"},
            {"x": "v", "v": f"cos(w*t) - x - v/10 - {force}"},
        )
        assert len(np.unique(run["mode"])) == 2
        reaction = K * np.maximum(x - P, 0) ** (2 if "**2" in force else 1)
        assert np.allclose(run["reaction"], reaction, rtol=1e-14, atol=1e-14)
        assert np.allclose(run["size"], np.abs(v), rtol=0, atol=0)
        expected = np.cos(W * t) - x - v / 10 - reaction
        assert np.allclose(run["acceleration"], expected, rtol=1e-13, atol=1e-13)


def test_the_side_of_a_cell_counts_on_its_surface():
    # sign(0) is zero for numpy, but the rate in a cell is that of its side
    system = System(states=["x"], equations={"x": "2 + sign(x)"}, outputs={"rate_of_x": "rate(x)"})
    run = ns.simulate(system, {"x": 0.0}, times=[0.0, 1.0])
    assert list(run["rate_of_x"].values) == [3.0, 3.0]


def test_rate_of_a_slaved_state_of_a_taylor_mode():
    # p = sin(x), x' = 1: p' = cos(x), and p is a variable of the run
    system = System(
        states=["x", "p"],
        outputs={"rate_of_p": "rate(p)"},
        modes={"m": Mode({"x": "1"}, slaved={"p": "sin(x)"})},
    )
    run = ns.simulate(system, {"x": 0.0}, times=[0.0, 0.5, 1.0])
    assert np.allclose(run["p"], np.sin(run["time"]), rtol=0, atol=1e-15)
    assert np.allclose(run["rate_of_p"], np.cos(run["time"]), rtol=0, atol=1e-15)


# ---------------------------------------------------------------- what refers to itself

CIRCLES = [
    ({"definitions": {"a": "b*x", "b": "a"}}, "a", "a -> b -> a"),
    ({"definitions": {"a": "abs(a)"}}, "a", "a -> a"),
    ({"outputs": {"o": "2*d"}, "definitions": {"d": "o*x"}}, "d", "circle"),
    ({"definitions": {"a": "rate(x)*v"}}, "a", "a -> rate(x) -> a"),
    ({"outputs": {"o": "rate(x)"}}, "o**2", "rate(x) -> o -> rate(x)"),
    ({"definitions": {"a": "where(v > rate(x), 1, 2)"}}, "a", "circle"),
]


@pytest.mark.parametrize(("words", "rate", "message"), CIRCLES)
def test_circles_are_refused_on_every_path(words, rate, message):
    with pytest.raises(ModelError) as caught:
        System(states=["x", "v"], equations={"x": rate, "v": "-x*v"}, **words)
    assert "goes in a circle" in str(caught.value)
    if message != "a -> rate(x) -> a":
        assert message in str(caught.value)


def test_a_circle_of_one_mode_only():
    with pytest.raises(ModelError, match="a -> b -> a goes in a circle"):
        System(
            states=["x"],
            definitions={"a": "b", "b": "x**2"},
            modes={
                "fine": Mode({"x": "-a"}, exits=[Exit("x", to="bad")]),
                "bad": Mode({"x": "-a"}, definitions={"b": "a"}),
            },
        )
