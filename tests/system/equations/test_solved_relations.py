"""Slaved states by equations that are not linear, solved by the engine."""

import math

import mpmath
import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, ModelError, System


def cubic(**rest):
    """x' = -p where p solves p^3 + p = x: 3/2 p^2 + log p falls with time."""
    mode = Mode({"x": "-p"}, slaved={"p": "p**3 + p = x"})
    return System(states=["x", "p"], modes={"m": mode}, initial={"p": 1.0}, **rest)


def cubic_root(x):
    roots = np.roots([1.0, 0.0, 1.0, -x])
    near = float(roots[np.argmin(np.abs(roots.imag))].real)
    return float(mpmath.findroot(lambda p: p**3 + p - x, near))


def test_a_cubic_follows_its_equation_and_its_closed_form():
    run = ns.simulate(cubic(), {"x": 10.0, "p": 2.0}, times=np.linspace(0.0, 6.0, 61))
    x, p, t = run["x"].values, run["p"].values, run["time"].values
    np.testing.assert_allclose(p**3 + p, x, rtol=4e-16 * 4)
    # p' = -p/(3 p^2 + 1), so 3/2 p^2 + log p = 6 + log 2 - t
    np.testing.assert_allclose(1.5 * p**2 + np.log(p) + t, 6.0 + math.log(2.0), rtol=2e-15)


def test_derivatives_live_on_the_relation():
    run = ns.simulate(cubic(), {"x": 10.0, "p": 2.0}, times=[0.0, 4.0], tangent=True)
    p = float(run["p"][-1])
    # (3 p + 1/p) dp = (3 p0 + 1/p0) dp0 and dx = (3 p^2 + 1) dp
    by_p0 = (3 * 2.0 + 0.5) / (3 * p + 1 / p)
    by_x0 = by_p0 / (3 * 2.0**2 + 1)
    columns = run["tangent"].isel(time=-1).sel(state_0="x")
    assert float(columns.sel(state="p")) == pytest.approx(by_x0, rel=1e-13)
    assert float(columns.sel(state="x")) == pytest.approx(by_x0 * (3 * p**2 + 1), rel=1e-13)


@pytest.mark.parametrize("x", [0.1, 10.0, -300.0])
def test_what_a_start_leaves_out_is_solved_for(x):
    run = ns.simulate(cubic(), {"x": x}, times=[0.0, 0.1])
    assert float(run["p"][0]) == pytest.approx(math.copysign(cubic_root(abs(x)), x), rel=1e-14)
    lanes = ns.ensemble(cubic(), {"x": [x, 2.0 * x]}, times=[0.0])
    assert float(lanes["p"][0, 0]) == pytest.approx(float(run["p"][0]), rel=1e-14)


def test_a_start_that_does_not_agree_is_told_what_would():
    with pytest.raises(ns.OptionError, match=r"give p = 2 by"):
        ns.simulate(cubic(), {"x": 10.0, "p": 1.9}, times=[0.0, 1.0])


def test_the_present_value_chooses_among_solutions():
    mode = Mode({"x": "1"}, slaved={"p": "p**2 = x"})
    system = System(states=["x", "p"], modes={"m": mode})
    for p in (1.0, -1.0):
        run = ns.simulate(system, {"x": 1.0, "p": p}, times=[0.0, 3.0])
        assert float(run["p"][-1]) == pytest.approx(2.0 * p, rel=1e-15)


def test_a_fold_of_the_equation_ends_the_run():
    mode = Mode({"x": "-1"}, slaved={"p": "p**2 = x"})
    system = System(states=["x", "p"], modes={"m": mode})
    with pytest.warns(ns.RunWarning):
        run = ns.simulate(system, {"x": 1.0, "p": 1.0}, times=[0.0, 0.5, 2.0])
    assert run.attrs["status"] == "singular"
    assert float(run["p"][1]) == pytest.approx(math.sqrt(0.5), rel=1e-14)


def test_a_reset_that_names_a_slaved_state_lets_it_jump():
    """From free fall onto p^2 = x, by the first guess on the side where the reset puts it."""
    for guess in ("0.5", "-0.5"):
        exits = [Exit("1 - x", to="held", reset={"p": guess}, name="caught")]
        modes = {
            "free": Mode({"x": "1", "p": "0"}, exits=exits),
            "held": Mode({"x": "1"}, slaved={"p": "p**2 = x"}),
        }
        run = ns.simulate(System(states=["x", "p"], modes=modes), times=[0.5, 3.0])
        assert float(run["p"][0]) == 0.0
        assert float(run["p"][1]) == pytest.approx(math.copysign(math.sqrt(3.0), float(guess)))
    modes["free"] = Mode({"x": "1", "p": "0"}, exits=[Exit("1 - x", to="held")])
    with pytest.warns(ns.RunWarning, match="name it in the exit's reset="):
        run = ns.simulate(System(states=["x", "p"], modes=modes), times=[0.5, 3.0])
    assert run.attrs["status"] == "inadmissible"


def test_equations_are_solved_together_and_rates_are_theirs():
    """A point on a circle beside one that moves outside: r - s = d n, |r - s| = 1, s = k d."""
    slaved = {"s": "2*s = m*(x - s)", "r": "2*r = m*(y - r)", "m": "(x - s)**2 + (y - r)**2 = 1"}
    modes = {"on": Mode({"x": "-y", "y": "x"}, slaved=slaved)}
    system = System(
        states=["x", "y", "s", "r", "m"], modes=modes, outputs={"speed": "rate(s)", "w": "rate(m)"}
    )
    run = ns.simulate(system, {"x": 1.5, "y": 0.0}, times=np.linspace(0.0, 6.0, 13))
    t = run["time"].values
    np.testing.assert_allclose(run["s"], 0.5 * np.cos(t), atol=4e-15)
    np.testing.assert_allclose(run["r"], 0.5 * np.sin(t), atol=4e-15)
    np.testing.assert_allclose(run["m"], 1.0, rtol=4e-15)
    np.testing.assert_allclose(run["speed"], -0.5 * np.sin(t), atol=1e-14)
    np.testing.assert_allclose(run["w"], 0.0, atol=1e-14)


SUM = "(" + " + ".join(f"p{i}" for i in range(7)) + ")**3"


def test_twenty_equations_in_a_chain():
    """Each is solved with the one before it known: p_i**3 + p_i = p_(i-1), from x on."""
    count = 20
    slaved = {f"p{i}": f"p{i}**3 + p{i} = {f'p{i - 1}' if i else 'x'}" for i in range(count)}
    last = f"p{count - 1}"
    order = list(slaved)[::-1]  # the order of the states plays no part
    system = System(
        states=["x", *order],
        modes={"m": Mode({"x": "-x"}, slaved={name: slaved[name] for name in order})},
        outputs={"speed": f"rate({last})"},
    )
    run = ns.simulate(system, {"x": 1000.0}, times=[0.0, 2.0])
    value, slope = 1000.0 * math.exp(-2.0), -1000.0 * math.exp(-2.0)
    for i in range(count):
        value = cubic_root(value)
        slope /= 3.0 * value**2 + 1.0
        assert float(run[f"p{i}"][-1]) == pytest.approx(value, rel=1e-13)
    assert float(run["speed"][-1]) == pytest.approx(slope, rel=1e-12)


def test_ten_equations_side_by_side_and_a_ring_of_three():
    slaved = {f"p{i}": f"p{i}**3 + p{i} = {i + 1}*x" for i in range(10)}
    ring = {"a": "a + 0.1*b**3 = p9", "b": "b + 0.1*c**3 = p8", "c": "c + 0.1*a**3 = p7"}
    system = System(
        states=["x", *slaved, *ring],
        modes={"m": Mode({"x": "-x"}, slaved=slaved | ring)},
        outputs={"speed": "rate(a)"},
    )
    run = ns.simulate(system, {"x": 0.5}, times=np.linspace(0.0, 1.0, 101))
    x, last = run["x"].values, {name: run[name].values for name in run.data_vars}
    for i in range(10):
        np.testing.assert_allclose(last[f"p{i}"] ** 3 + last[f"p{i}"], (i + 1) * x, rtol=1e-14)
    for one, other, given in (("a", "b", "p9"), ("b", "c", "p8"), ("c", "a", "p7")):
        left = last[one] + 0.1 * last[other] ** 3
        np.testing.assert_allclose(left, last[given], rtol=1e-14)
    # the slope of a cubic through neighbours, off by the fourth power of their distance
    a, h = last["a"], 0.01
    by_neighbours = (a[:-4] - 8 * a[1:-3] + 8 * a[3:-1] - a[4:]) / (12 * h)
    np.testing.assert_allclose(last["speed"][2:-2], by_neighbours, atol=1e-7)


@pytest.mark.parametrize(
    ("slaved", "words"),
    [
        ({"p": "q**2 = x", "q": "q**3 = x"}, ["cannot be solved"]),
        ({f"p{i}": f"p{i} + {SUM} = x" for i in range(7)}, ["7 equations", "at most 6"]),
    ],
)
def test_equations_that_tell_nothing_are_refused(slaved, words):
    with pytest.raises(ModelError) as caught:
        System(states=["x", *slaved], modes={"m": Mode({"x": "1"}, slaved=slaved)})
    for word in words:
        assert word in str(caught.value)


def test_relations_round_trip_and_explain(capsys):
    system = cubic()
    assert System.from_toml(system.to_toml()) == system
    system.explain()
    assert "p**3 + p = x" in capsys.readouterr().out


@pytest.mark.parametrize("slaved", [False, True])
def test_a_jump_onto_a_relation_may_lead_back_where_it_came_from(slaved):
    """Touch and off again at one instant, with p ahead by one: no circle."""
    flow = {"x": "1", "v": "0"}
    touch = Exit("p - x", to="hold", reset={"p": "x + 1"}, name="touch")
    off = [Exit("v", to="free", name="off")]
    hold = Mode(flow, slaved={"p": "x + 1"}, exits=off) if slaved else Mode(flow | {"p": "1"}, off)
    modes = {"free": Mode(flow | {"p": "0"}, exits=[touch]), "hold": hold}
    system = System(states=["x", "v", "p"], modes=modes)
    run = ns.simulate(system, {"p": 0.5, "v": -1.0}, t_end=3.0, mode="free")
    assert run.attrs["status"] == "completed"
    assert float(run["end_state"].sel(state="p")) == 3.5
    paths = run["event_path"].values.astype(str).tolist()
    assert paths[1:] == ["touch>off"] * 3


def test_modes_that_hand_over_without_a_change_are_undecided():
    touch = Exit("p - x", to="hold", reset={"p": "x"}, name="touch")
    modes = {
        "free": Mode({"x": "1", "v": "0", "p": "0"}, exits=[touch]),
        "hold": Mode({"x": "1", "v": "0"}, slaved={"p": "x"}, exits=[Exit("v", to="free")]),
    }
    system = System(states=["x", "v", "p"], modes=modes)
    with pytest.warns(ns.RunWarning):
        run = ns.simulate(system, {"p": 0.5, "v": -1.0}, t_end=3.0, mode="free")
    assert run.attrs["status"] == "undecided"


@pytest.mark.parametrize(
    ("relation", "closed"),
    [
        ("x + 5*max(x, 0)", lambda x: x + 5 * np.maximum(x, 0)),
        ("where(x > 0, x, 2*x)", lambda x: np.where(x > 0, x, 2 * x)),
        ("F + 0.5*abs(F) = x", lambda x: np.where(x > 0, x / 1.5, x / 0.5)),
    ],
)
def test_piecewise_relations_through_the_origin(relation, closed):
    mode = Mode({"x": "v", "v": "-x"}, slaved={"F": relation})
    system = System(states=["x", "v", "F"], modes={"m": mode})
    for v in (1.0, 0.3, 7.7):
        run = ns.simulate(system, {"v": v}, times=np.linspace(0.0, 20.0, 101))
        assert run.attrs["status"] == "completed"
        np.testing.assert_allclose(run["F"], closed(v * np.sin(run["time"])), atol=1e-13)


def test_equations_that_are_not_solved_say_so():
    mode = Mode({"x": "1"}, slaved={"p": "p**2 = -1 - x**2"})
    system = System(states=["x", "p"], modes={"m": mode}, initial={"p": 0.5})
    with pytest.raises(ns.OptionError, match=r"does not solve 'p\*\*2 = -1 - x\*\*2'"):
        ns.simulate(system, {"x": 1.0}, t_end=1.0)
