"""Smoothed systems against closed forms, call by call and in motion."""

import math

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns

KINDS = ("tanh", "arctan", "logistic", "sqrt")
SIGN = {
    "tanh": np.tanh,
    "arctan": lambda u: 2 / np.pi * np.arctan(u),
    "logistic": lambda u: 2 / (1 + np.exp(-u)) - 1,
    "sqrt": lambda u: u / np.sqrt(1 + u * u),
}
# u with sign(u) = s
INVERSE = {
    "tanh": math.atanh,
    "arctan": lambda s: math.tan(math.pi * s / 2),
    "logistic": lambda s: 2 * math.atanh(s),
    "sqrt": lambda s: s / math.sqrt(1 - s * s),
}
EPS = 0.25
X = np.linspace(-3.0, 3.0, 61)


def size(kind, u):
    """The smooth absolute value."""
    u = np.asarray(u, float)
    return np.sqrt(u * u + EPS**2) if kind == "sqrt" else u * SIGN[kind](u / EPS)


def above(kind, u):
    return (1 + SIGN[kind](u / EPS)) / 2


def greater(kind, a, b):
    return (a + b + size(kind, a - b)) / 2


def less(kind, a, b):
    return (a + b - size(kind, a - b)) / 2


CALLS = {
    "sign(x - 0.5)": lambda k, x: SIGN[k]((x - 0.5) / EPS),
    "heaviside(x + 1)": lambda k, x: above(k, x + 1),
    "abs(x)": lambda k, x: size(k, x),
    "abs(2*x - 1)": lambda k, x: size(k, 2 * x - 1),
    "abs(-x)": lambda k, x: size(k, x),
    "max(x, 0)": lambda k, x: greater(k, x, 0),
    "max(0, x)": lambda k, x: greater(k, x, 0),
    "min(x, x**2)": lambda k, x: less(k, x, x**2),
    "max(c, 1, x)": lambda k, x: greater(k, 2.0, x),
    "max(x, 1, -x)": lambda k, x: greater(k, greater(k, x, 1), -x),
    "clip(x, -1, c)": lambda k, x: (-1 + 2 + size(k, x + 1) - size(k, x - 2)) / 2,
    "where(x > c, x**2, 3)": lambda k, x: x**2 * above(k, x - 2) + 3 * above(k, 2 - x),
    "where(x <= 1, x, -1)": lambda k, x: x * above(k, 1 - x) - above(k, x - 1),
    "where(x > 0, where(x < 1, x, x**3), sign(x))": lambda k, x: (
        above(k, x) * (x * above(k, 1 - x) + x**3 * above(k, x - 1))
        + above(k, -x) * SIGN[k](x / EPS)
    ),
    "where(abs(x) > 1, x, 0)": lambda k, x: x * above(k, size(k, x) - 1),
    "where(c > 1, sign(x), x)": lambda k, x: SIGN[k](x / EPS),
    "2*where(x > 0, 1, -1)*max(x - 1, 0)": lambda k, x: 2 * SIGN[k](x / EPS) * greater(k, x - 1, 0),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("text", CALLS)
def test_calls_against_closed_forms(text, kind):
    """Some tens of roundings of numbers up to 27."""
    system = ns.System(
        states=["x"], parameters={"c": 2.0}, outputs={"y": text}, equations={"x": "1"}
    )
    soft = ns.smoothed(system, EPS, kind=kind)
    run = ns.simulate(soft, {"x": -3.0}, times=X + 3.0)
    assert soft.mode_names == ("flow",)
    assert run["y"].values == pytest.approx(CALLS[text](kind, X), abs=1e-12, rel=0)


# largest distance from abs: of x (1 - s(x)) over x > 0, by mpmath.findroot of its derivative
FARTHEST = {"tanh": 0.278464542761, "logistic": 0.556929085522, "arctan": 2 / math.pi, "sqrt": 1.0}


@pytest.mark.parametrize("kind", KINDS)
def test_how_far_the_smooth_absolute_value_is_off(kind):
    """2e-4: the grid around the largest value, and how slowly that of arctan is reached."""
    soft = ns.smoothed(
        ns.System(states=["x"], outputs={"y": "abs(x)"}, equations={"x": "1"}), EPS, kind=kind
    )
    run = ns.simulate(soft, {"x": -20.0}, times=np.linspace(0, 40, 40_001))
    off = (run["y"] - abs(run["x"])).values
    assert np.abs(off).max() / EPS == pytest.approx(FARTHEST[kind], abs=2e-4)
    assert np.all(off * (1 if kind == "sqrt" else -1) >= -1e-15)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("eps", [0.1, 1e-2, 1e-3])
def test_a_sliding_point_rests_beside_the_surface(kind, eps):
    """Where s(x/eps) = 0.3; the slowest relaxation is over by a factor exp(-20/eps)."""
    exact = ns.System(states=["x"], equations={"x": "0.3 - sign(x)"})
    run = ns.simulate(ns.smoothed(exact, eps, kind=kind), {"x": 0.5}, t_end=20.0)
    assert run.attrs["status"] == "completed"
    assert float(run["x"][-1]) == pytest.approx(eps * INVERSE[kind](0.3), rel=1e-10)
    assert float(ns.simulate(exact, {"x": 0.5}, t_end=20.0)["x"][-1]) == 0.0


@pytest.mark.parametrize("kind", KINDS)
def test_a_block_on_an_incline_creeps(kind):
    """With s(v/eps) = tan(a)/mu; exactly it stays where it came to rest."""
    block = ns.System(
        states=["x", "v"],
        parameters={"a": 0.4, "mu": 0.7},
        equations={"x": "v", "v": "sin(a) - mu*cos(a)*sign(v)"},
    )
    soft = ns.smoothed(block, "eps", kind=kind).with_parameters(eps=1e-3)
    run = ns.simulate(soft, {"v": 0.2}, times=[50.0, 150.0])
    rate = 1e-3 * INVERSE[kind](math.tan(0.4) / 0.7)
    assert float(run["x"][1] - run["x"][0]) == pytest.approx(100.0 * rate, rel=1e-10)
    stays = ns.simulate(block, {"v": 0.2}, times=[50.0, 150.0])
    assert float(stays["x"][1] - stays["x"][0]) == 0.0


def test_the_width_as_a_parameter_has_derivatives():
    """The rest point is eps*artanh(0.3), so its derivative is artanh(0.3)."""
    exact = ns.System(states=["x"], equations={"x": "0.3 - sign(x)"})
    run = ns.simulate(ns.smoothed(exact, "eps"), {"x": 0.1}, t_end=5.0, tangent=["eps"])
    assert float(run["sensitivity"][-1, 0, 0]) == pytest.approx(math.atanh(0.3), rel=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_a_switch_of_time(kind):
    """sign(sin(2 t)) of time alone, integrated by mpmath."""
    system = ns.System(states=["x"], period="pi", equations={"x": "sign(sin(2*t))"})
    run = ns.simulate(ns.smoothed(system, 0.05, kind=kind), times=[1.0])
    with mpmath.workdps(30):
        sign = {
            "tanh": mpmath.tanh,
            "arctan": lambda u: 2 / mpmath.pi * mpmath.atan(u),
            "logistic": lambda u: mpmath.tanh(u / 2),
            "sqrt": lambda u: u / mpmath.sqrt(1 + u * u),
        }[kind]
        truth = mpmath.quad(
            lambda t: sign(mpmath.sin(2 * t) / mpmath.mpf(0.05)), [0, 0.1, 0.3, 0.6, 1]
        )
    assert float(run["x"][0]) == pytest.approx(float(truth), abs=1e-13)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("eps", [1e-2, 1e-4, 1e-6])
def test_nothing_overflows(kind, eps):
    """u/eps up to 1e6: x' = sign(x - 3 t + 1) jumps at t = 1/2, where x = 1/2.

    Through the switch s falls from 1 to -1 while u does at the rate s - 3, so of time eps/2 times
    the integral of 1/(3 - s) - 1/(3 - sign) over u/eps is lost; far less than eps times 20.
    """
    system = ns.System(states=["x"], equations={"x": "sign(x - 3*t + 1)"})
    run = ns.simulate(ns.smoothed(system, eps, kind=kind), t_end=1.0)
    assert run.attrs["status"] == "completed"
    assert float(run["x"][-1]) == pytest.approx(0.0, abs=20 * eps)


def test_a_smoothed_motion_against_another_integrator():
    """scipy at 1e-12 in short steps; its error stays below 1e-9 over the few seconds."""
    system = ns.System(
        states=["x", "v"],
        parameters={"k": 8.0, "gap": 0.5, "mu": 0.2},
        equations={"x": "v", "v": "cos(1.3*t) - x - k*(x - clip(x, -gap, gap)) - mu*sign(v)"},
    )
    eps, times = 0.05, np.linspace(0.0, 10.0, 21)
    run = ns.simulate(ns.smoothed(system, eps), {"x": 1.0}, times=times)

    def rates(t, z):
        x, v = z
        inside = ((x + 0.5) * np.tanh((x + 0.5) / eps) - (x - 0.5) * np.tanh((x - 0.5) / eps)) / 2
        return [v, np.cos(1.3 * t) - x - 8 * (x - inside) - 0.2 * np.tanh(v / eps)]

    other = solve_ivp(
        rates, (0, 10), [1.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-13, t_eval=times,
        max_step=0.01,
    )  # fmt: skip
    assert run["x"].values == pytest.approx(other.y[0], abs=1e-9)


def test_parameters_alone_keep_their_calls():
    texts = {"x": "max(a, b)*x + where(a > b, x, 2*x) + abs(a)", "v": "sign(x)"}
    system = ns.System(states=["x", "v"], parameters={"a": 1.0, "b": 2.0}, equations=texts)
    soft = ns.smoothed(system, 0.1)
    assert soft.equations["x"] == texts["x"]
    assert soft.equations["v"] == "tanh(x/0.1)"


def test_a_definition_that_moves_in_one_mode_only():
    """In the mode where ``c`` is a parameter its sign stays a number."""
    stays, moves = (
        ns.Mode({"x": "sign(c) - x"}, exits=[ns.Exit("2 - x", to="moves")]),
        ns.Mode({"x": "sign(c) - 3*x"}, exits=[ns.Exit("x", to="stays")], definitions={"c": "x"}),
    )
    system = ns.System(
        states=["x"], parameters={"p": 0.5}, definitions={"c": "p"},
        modes={"stays": stays, "moves": moves},
    )  # fmt: skip
    soft = ns.smoothed(system, 0.1)
    assert soft.modes["stays"].flow["x"] == "sign(c) - x"
    assert soft.modes["moves"].flow["x"] == "tanh(c/0.1) - 3*x"
    assert soft.mode_names == ("stays", "moves")
    assert [way.to for way in soft.modes["stays"].exits] == ["moves"]


def test_surfaces_become_definitions():
    belt = ns.System(
        states=["x", "v"],
        parameters={"v_b": 0.3},
        outputs={"friction": "-0.4*sign(slip)"},
        equations={"x": "v", "v": "friction - x"},
        surfaces={"slip": ns.Surface("v - v_b", below="lag", on="stick", above="lead")},
    )
    soft = ns.smoothed(belt, "eps")
    assert not soft.surfaces
    assert soft.definitions["slip"] == "v - v_b"
    assert soft.outputs["friction"] == "(-0.4)*tanh(slip/eps)"
    assert soft.parameter_values["eps"] == 0.01


def test_slaved_states_and_guards():
    """y + 2 max(y, 0) = x by Newton's method, and a guard abs(x) - 1."""
    mode = ns.Mode(
        {"x": "-x"},
        slaved={"y": "y + 2*max(y, 0) = x"},
        exits=[ns.Exit("abs(x) - 1", to="stop")],
        cells={"++": "right"},
    )
    system = ns.System(states=["x", "y"], modes={"m": mode})
    soft = ns.smoothed(system, 0.05)
    run = ns.simulate(soft, {"x": 3.0, "y": 1.0}, t_end=3.0)
    x, y = run["x"].values, run["y"].values
    assert run.attrs["status"] == "stopped"
    assert y + y * (1 + np.tanh(y / 0.05)) == pytest.approx(x, abs=1e-13)
    assert x[-1] * np.tanh(x[-1] / 0.05) >= 1.0 - 1e-12


@pytest.mark.parametrize("kind", KINDS)
def test_round_trip_of_long_texts(kind):
    """Parts that are needed several times get names, so that texts stay short."""
    deep = "x"
    for k in range(1, 4):
        deep = f"max({deep}, {k}*v, min(x, v - {k}, sign(x*v)))"
    system = ns.System(states=["x", "v"], equations={"x": "v", "v": "-x"}, outputs={"y": deep})
    soft = ns.smoothed(system, "eps", kind=kind)
    assert soft.definitions
    assert max(map(len, [*soft.definitions.values(), *soft.outputs.values()])) < 1000
    again = ns.System.from_toml(soft.to_toml())
    assert again == soft
    run = ns.simulate(again, {"x": 1.0}, t_end=1.0)
    assert np.isfinite(run["y"].values).all()


def test_contact_with_a_broken_power():
    """(max(x, 0))**1.5 has a value with sqrt only, which never falls below zero."""
    hertz = ns.System(
        states=["x", "v"],
        definitions={"push": "-max(x - 1, 0)"},
        equations={"x": "v", "v": "-x - 5*(-push)**1.5"},
    )
    with pytest.raises(ns.ModelError, match=r"goes through zero.*kind='sqrt'"):
        ns.smoothed(hertz, 0.01)
    run = ns.simulate(ns.smoothed(hertz, 1e-3, kind="sqrt"), {"x": -2.0}, t_end=10.0)
    assert run.attrs["status"] == "completed"
    energy = run["v"] ** 2 / 2 + run["x"] ** 2 / 2 + 2 * np.maximum(run["x"] - 1, 0) ** 2.5
    # off by eps times the force at most
    assert float(abs(energy - 2).max()) < 1e-3


def test_whole_powers_of_smoothed_calls_are_allowed():
    system = ns.System(states=["x"], equations={"x": "-abs(x)**3 - sqrt(abs(x) + 1)"})
    assert "tanh" in ns.smoothed(system, 0.1).equations["x"]


SIMPLE = ns.System(states=["x"], parameters={"p": 1.0}, equations={"x": "-sign(x)"})


@pytest.mark.parametrize(
    ("epsilon", "kind", "match"),
    [
        (0.0, "tanh", "positive and finite"),
        (-1.0, "tanh", "positive and finite"),
        (math.inf, "tanh", "positive and finite"),
        (math.nan, "tanh", "positive and finite"),
        (True, "tanh", "neither a positive number nor a name"),
        (None, "tanh", "neither a positive number nor a name"),
        ("2 eps", "tanh", "neither a positive number nor a name"),
        ("p", "tanh", "has this name already"),
        ("x", "tanh", "has this name already"),
        (0.1, "cosh", "one of tanh, arctan, logistic, sqrt"),
        (0.1, None, "one of tanh, arctan, logistic, sqrt"),
    ],
)
def test_bad_options(epsilon, kind, match):
    with pytest.raises(ns.OptionError, match=match):
        ns.smoothed(SIMPLE, epsilon, kind=kind)


def test_a_name_with_a_fixed_meaning_is_refused():
    with pytest.raises(ns.ModelError, match="fixed meaning"):
        ns.smoothed(SIMPLE, "tanh")


def test_what_is_no_system_is_refused():
    with pytest.raises(ns.OptionError, match="not a System"):
        ns.smoothed("x", 0.1)


def test_the_width_must_stay_positive():
    soft = ns.smoothed(SIMPLE, "eps")
    with pytest.raises(ns.ModelError, match="width of the smooth switches"):
        soft.with_parameters(eps=0.0)


def ball(**words):
    way = ns.Exit("x", reset={"v": "-0.5*v"}, name="impact", **words)
    return ns.System(states=["x", "v"], modes={"flight": ns.Mode({"x": "v", "v": "-1"}, [way])})


@pytest.mark.parametrize(
    ("system", "match"),
    [
        (
            ball(),
            r"modes\['flight'\].exits\[0\] \(impact\): its reset of v cannot.*spring and a damper",
        ),
        (ball(sticks="rest"), "its reset of v and the rest as 'rest' cannot.*spring and a damper"),
        (
            ns.System(
                states=["v"], equations={"v": "-sign(s)"}, surfaces={"s": ns.Surface("v", hold=2)}
            ),
            r"surfaces\['s'\]: hold='2'.*leave hold= out",
        ),
        (ns.System(states=["x"], equations={"x": "-x"}), "nothing to smooth"),
    ],
)
def test_what_cannot_be_smoothed(system, match):
    with pytest.raises(ns.ModelError, match=match):
        ns.smoothed(system, 0.1)
