"""Motions that come to rest, also while they do: beside closed forms.

A linear flow keeps its multipliers all the way, so its exponent is that of its matrix however far
the motion has come. A spiral looks alike at any size, and the rounding that is left of it repeats
to no part of itself.
"""

import re

import numpy as np
import pytest
from scipy.optimize import brentq

import nonsmooth as ns
from nonsmooth import Exit, Mode, Surface, System


def flow(**equations: str) -> System:
    return System(states=list(equations), equations=equations)


def label(found) -> str:
    return found["regime"].item()


# windows end at exp(-0.0145 * 3200) and later, so that every one of these comes within 1e-6
@pytest.mark.parametrize("transient", [200, 2000, 20_000])
@pytest.mark.parametrize("damping", [0.029, 0.04, 0.06, 0.08, 0.1, 0.3])
def test_a_damped_oscillator_off_zero_rests(damping, transient):
    """At x = 0.5; its multipliers over a time of one have the modulus exp(-damping / 2)."""
    system = flow(x="v", v=f"-x - {damping}*v + 0.5")
    found = ns.regime(system, {"x": 0.3}, period=1.0, transient=transient)
    assert (label(found), found["period"].item()) == ("equilibrium", 1)
    assert found["exponent"].item() == pytest.approx(-damping / 2, abs=1e-9)
    assert found["residual"].item() < 1e-6


@pytest.mark.parametrize("rate", [0.02, 0.05, 0.25, 0.5])
def test_critical_damping_rests(rate):
    """A double eigenvalue splits by the root of rounding, which is 1.5e-8."""
    system = flow(x="v", v=f"-x*{rate}**2 - 2*{rate}*v + 1")
    found = ns.regime(system, {"x": 0.0}, period=1.0)
    assert label(found) == "equilibrium"
    assert found["exponent"].item() == pytest.approx(-rate, abs=1e-6)


@pytest.mark.parametrize("period", [0.1, 1.0, 30.0])
def test_a_bilinear_spring_rests_away_from_its_kink(period):
    """At x = 0.25 / 1.5; an interval of 30 forgets where it began, by exp(-19.5)."""
    system = flow(x="v", v="-x - 1.3*v - 0.5*max(x - 0.1, 0) + 0.2")
    found = ns.regime(system, {"x": 1.0}, period=period)
    assert (label(found), found["period"].item()) == ("equilibrium", 1)
    assert found["exponent"].item() == pytest.approx(-0.65, abs=1e-6)


@pytest.mark.parametrize("period", [1.0, 2.0, 7.0])
def test_a_bilinear_spring_rests_on_its_kink(period):
    """It passes the kink in every half turn, at any size, and shrinks with exp(-0.05 t)."""
    found = ns.regime(flow(x="v", v="-x - 0.1*v - 0.5*max(x, 0)"), {"x": 1.0}, period=period)
    assert (label(found), found["period"].item()) == ("equilibrium", 1)


def test_chua_between_its_scrolls_rests():
    """On an outer branch the matrix is constant; its largest eigenvalue is a pair."""
    system = ns.models.chua(alpha=6.0)
    beta, m1 = (system.parameter_values[name] for name in ("beta", "m1"))
    matrix = [[-6.0 * (1.0 + m1), 6.0, 0.0], [1.0, -1.0, 1.0], [0.0, -beta, 0.0]]
    slowest = np.linalg.eigvals(matrix).real.max()
    assert -0.1 < slowest < 0.0
    for start in ({"x": 0.1}, {"x": 1.0, "z": -1.0}):
        for transient in (200, 3000):
            found = ns.regime(system, start, period=1.0, transient=transient)
            assert label(found) == "equilibrium"
            assert found["exponent"].item() == pytest.approx(slowest, abs=1e-9)


def stribeck_belt(vb: float) -> System:
    return System(
        name="belt", states=["x", "v"],
        parameters={"z": 0.02, "Fk": 0.5, "Fs": 1.0, "vs": 0.25, "vb": vb, "g": 1.35, "r": 0.6},
        modes={
            "run": Mode(
                {"x": "v", "v": "-x - 2*z*v - sign(s)*(Fk + (Fs - Fk)*exp(-abs(s)/vs))"},
                exits=[Exit("g - x", reset={"v": "-r*v"}, name="stop")],
            )
        },
        surfaces={"s": Surface("v - vb", below="lag", on="stick", above="lead")},
    )  # fmt: skip


@pytest.mark.parametrize("transient", [200, 1000, 3000])
@pytest.mark.parametrize("x", [0.0, 0.3, 0.9])
def test_a_block_on_a_fast_belt_stands_still(x, transient):
    """Friction that falls with the speed takes (Fs - Fk)/vs exp(-vb/vs) from the damping."""
    found = ns.regime(stribeck_belt(1.3), {"x": x}, period=1.0, transient=transient)
    assert label(found) == "equilibrium"
    rate = 0.5 * (2 * 0.02 - 0.5 / 0.25 * np.exp(-1.3 / 0.25))
    assert found["exponent"].item() == pytest.approx(-rate, abs=1e-8)


def test_a_start_at_rest_rests():
    """Rounding of sin(x) = 0.3 leaves a velocity that repeats to no part of itself."""
    x = brentq(lambda x: np.sin(x) - 0.3, 0.0, 1.0)
    found = ns.regime(flow(x="v", v="-sin(x) - 0.1*v + 0.3"), {"x": x}, period=1.0)
    assert label(found) == "equilibrium"
    assert found["exponent"].item() == pytest.approx(-0.05, abs=1e-9)


@pytest.mark.parametrize("radius", [1e-4, 1e-7])
def test_a_small_cycle_is_no_rest(radius):
    """The radius r around x = 1 has r' = 0.1 r (1 - (r / radius)^2): exponent -0.2."""
    grows = f"0.1*(1 - ((x - 1)**2 + y*y)/{radius}**2)"
    system = flow(x=f"(x - 1)*{grows} - y", y=f"y*{grows} + x - 1")
    found = ns.regime(system, {"x": 1.0 + 2.0 * radius}, period=1.0)
    assert label(found) == "limit-cycle"
    assert found["exponent"].item() == pytest.approx(-0.2, abs=1e-6)


@pytest.mark.parametrize("period", [0.1, 1.0, 30.0])
def test_creeping_is_no_rest(period):
    """x' = -1e-8 x hardly moves within the windows, and is as far from rest as it began."""
    found = ns.regime(flow(x="-1e-8*x"), {"x": 1.0}, period=period)
    assert label(found) == "unsettled"
    assert "a way to go: x by 1" in found.attrs["message"]


@pytest.mark.parametrize("period", [1.0, "sqrt(2)"])
def test_a_slow_decay_is_no_torus(period):
    """exp(-0.0025 t) is left: 3e-4 in the last window, and so unsettled; never a torus."""
    found = ns.regime(
        flow(x="v", v="-x - 0.005*v - 0.5*max(x, 0) + 0.2"), {"x": 1.0}, period=period
    )
    assert label(found) == "unsettled"
    assert "settles slowly, by a factor 0.99" in found.attrs["message"]
    later = ns.regime(
        flow(x="v", v="-x - 0.005*v - 0.5*max(x, 0) + 0.2"), {"x": 1.0}, period=period,
        longest=12_800,
    )  # fmt: skip
    assert label(later) == "equilibrium"
    assert later["exponent"].item() == pytest.approx(-0.0025, abs=1e-9)


@pytest.mark.parametrize("F", [0.6, 0.65])
def test_a_force_below_friction_lets_a_relay_rest(F):
    """Together they hold up to 0.5 + 0.2: x slides to zero, on both surfaces at last."""
    system = System(
        states=["x", "v"], period="2*pi/w",
        parameters={"u": 0.5, "f": 0.2, "a": 0.6, "F": F, "w": 1.1},
        equations={"x": "v", "v": "F*cos(w*t) - 0.3*x - u*sign(ctl) - f*sign(rub)"},
        surfaces={
            "ctl": Surface("x + a*v", below="neg", on="slide", above="pos"),
            "rub": Surface("v", below="back", on="stick", above="forth"),
        },
    )  # fmt: skip
    assert label(ns.regime(system, {"x": 2.0, "v": 0.5})) == "equilibrium"


def test_a_map_of_regimes_tells_rest():
    """The border between rest and a cycle of Van der Pol's oscillator off zero is mu = 0."""
    system = System(
        states=["x", "v"], parameters={"mu": 0.1, "w": 1.0}, period="1.0*w",
        equations={"x": "v", "v": "mu*(1 - (x - 0.5)**2)*v - x + 0.5"},
    )  # fmt: skip
    plane = {"mu": [-0.2, -0.06, -0.03, 0.1, 0.5], "w": [0.9, 1.0]}
    found = ns.regime_map(system, plane, initial={"x": 0.8})
    names = found["regime"].attrs["flag_meanings"].split()
    told = np.array(names)[found["regime"].transpose("mu", "w").values]
    assert np.all(told[:3] == "equilibrium")
    assert np.all(told[3:] == "limit-cycle")


def counter(length: int) -> System:
    """n counts the periods and begins anew: a perturbation is lost there, and not before."""
    return System(
        states=["n"], period="2*pi",
        modes={
            "first": Mode({"n": "0"}, exits=[Exit("sin(t)", to="second")]),
            "second": Mode(
                {"n": "0"},
                exits=[
                    Exit("-sin(t)", to="first", reset={"n": f"where(n > {length - 1.5}, 0, n + 1)"})
                ],
            ),
        },
    )  # fmt: skip


def test_a_locked_motion_of_a_long_period_asks_for_a_longer_record():
    found = ns.regime(counter(120), phase=0.25, longest=400)
    assert label(found) == "unsettled"
    assert "record=" in found.attrs["message"] and "nan" not in found.attrs["message"]
    longer = ns.regime(counter(120), phase=0.25, record=300)
    assert (label(longer), longer["period"].item()) == ("locked", 120)


def test_the_errors_of_quasi_periodic_motion_are_those_of_the_rule():
    """An elastic ball beside a pendulum: neighbours part linearly, and both exponents are told."""
    flight = {"x": "v", "v": "-1", "q": "p", "p": "-q"}
    ball = System(
        states=["x", "v", "q", "p"], initial={"x": 1.0, "q": 0.5},
        modes={"flight": Mode(flight, exits=[Exit("x", reset={"v": "-v"})])},
    )  # fmt: skip
    found = ns.regime(ball, period=1)
    assert label(found) == "quasi-periodic"
    message = found.attrs["message"]
    told = re.findall(r"(-?[\d.e-]+) \+- ([\d.e-]+)", message)
    assert len(told) == 2
    if "within three errors" in message:
        assert all(abs(float(rate)) <= 3.0 * float(error) for rate, error in told)
    else:
        assert abs(float(told[1][0])) < 0.75 * abs(float(told[0][0]))


def test_a_diagram_tells_rest():
    """Rounding that is left of a decay repeats after any number of strobes; rest has one point."""
    damped = System(
        states=["x", "v"], parameters={"c": 0.06}, period="1.0*c/c",
        equations={"x": "v", "v": "-x - c*v + 0.5"},
    )  # fmt: skip
    found = ns.bifurcation_diagram(
        damped, "c", [0.04, 0.06, 0.2, 1.0], initial={"x": 0.3}, transient=1000, record=60
    )
    assert np.all(found["period"] == 1)
    # exp(-0.03 * 20) of the start is left after 20 strobes: that is no rest yet
    early = ns.bifurcation_diagram(damped, "c", [0.06], initial={"x": 0.3}, transient=20, record=60)
    assert np.all(early["period"] == 0)
    outer = System(
        states=["x", "y", "z"], parameters={"beta": 100 / 7}, period="1.0*beta/beta",
        equations={
            "x": "6*(y - x + 5/7*x + 3/14*(abs(x + 1) - abs(x - 1)))",
            "y": "x - y + z", "z": "-beta*y",
        },
    )  # fmt: skip
    for start in ({"x": 0.1}, {"x": 1.0, "z": -1.0}):
        chua = ns.bifurcation_diagram(outer, "beta", [100 / 7], initial=start, transient=1000)
        assert np.all(chua["period"] == 1)


TICKING = ns.System(
    name="ticking tent",
    states=["x", "tau"],
    parameters={"a": 0.3},
    initial={"x": 0.3},
    period=1.0,
    modes={
        "wait": ns.Mode(
            {"x": "0", "tau": "1"},
            exits=[ns.Exit("1 - tau", reset={"x": "a*min(x, 1 - x)", "tau": "0"}, name="tick")],
        )
    },
)


@pytest.mark.parametrize("forcing", ["0", "0.2*x*cos(t)"])
@pytest.mark.parametrize("start", ["restart", "follow up", "follow down"])
def test_what_decays_to_zero_has_the_period_one_in_a_diagram(forcing, start):
    """Without forcing, and with a forcing that acts on the displacement alone (Mathieu).

    Multiplied over a period the damping takes more from a motion than the forcing can give:
    exp(-2 pi c/2) beside exp(0.1 * 2 pi) at most.
    """
    system = ns.System(
        states=["x", "v"],
        parameters={"c": 0.4},
        initial={"x": 1.0},
        period="2*pi",
        equations={"x": "v", "v": f"-x - c*v - x**3 + {forcing}"},
    )
    diagram = ns.bifurcation_diagram(system, "c", [0.4, 0.6, 1.0], start=start)
    assert diagram["period"].values.ravel().tolist() == [1, 1, 1]


def test_a_map_that_decays_to_zero_has_the_period_one_in_a_diagram():
    """x -> a x below a = 1; above, the tent map stretches every distance by a, and is chaotic."""
    diagram = ns.bifurcation_diagram(TICKING, "a", [0.3, 0.9, 1.5])
    assert diagram["period"].values.ravel().tolist() == [1, 1, 0]


@pytest.mark.parametrize(("a", "modulus"), [(3.2, 0.16), (3.5, 0.0304998), (3.83, 0.3298818)])
def test_multipliers_where_a_clock_ticks_at_the_strobes(a, modulus):
    """The logistic map by resets: of period two 4 + 2 a - a^2; others iterated by hand."""
    clock = ns.System(
        states=["x", "tau"],
        parameters={"a": a},
        initial={"x": 0.3},
        period=1.0,
        modes={
            "wait": ns.Mode(
                {"x": "0", "tau": "1"},
                exits=[ns.Exit("1 - tau", reset={"x": "a*x*(1 - x)", "tau": "0"}, name="tick")],
            )
        },
    )
    x, product = 0.3, 1.0
    for _ in range(5000):
        x = a * x * (1.0 - x)
    period = {3.2: 2, 3.5: 4, 3.83: 3}[a]
    for _ in range(period):
        product *= a * (1.0 - 2.0 * x)
        x = a * x * (1.0 - x)
    assert abs(product) == pytest.approx(modulus, abs=1e-6)
    found = ns.regime(clock)
    assert found["period"].item() == period
    assert float(found["multiplier_modulus"][0]) == pytest.approx(abs(product), abs=1e-9)


def test_chaos_where_a_clock_ticks_at_the_strobes():
    """The tent map's exponent is log a."""
    found = ns.regime(TICKING, parameters={"a": 1.9})
    assert found["regime"].item() == "chaotic"
    assert float(found["exponent"]) == pytest.approx(np.log(1.9), abs=1e-9)
