"""Guards that are flat where a search looks at them, and not flat where it does not.

Powers above the order of the Taylor series, and chains of integrators that start at zero to a high
order, against closed forms. Whatever is certified must be right, to 1e-12 of the time or to the
condition of the root; where a start has no term of its series at all, `estimated` says so.
"""

import mpmath
import pytest

import nonsmooth as ns

POWERS = [3, 10, 19, 20, 21, 22, 25, 30, 50, 77, 100]


def stopping(states, guard):
    mode = ns.Mode(states, exits=[ns.Exit(guard, to="stop")])
    return ns.System(states=list(states), modes={"m": mode})


def certified(run):
    return run.attrs["certified"] == 1 and bool(run["certified"].all())


@pytest.mark.parametrize("power", POWERS)
def test_a_power_that_is_flat_at_the_start(power):
    system = stopping({"x": "1"}, f"0.5 - x**{power}")
    for start in (0.0, 1e-3, 0.3):
        run = ns.simulate(system, {"x": start}, t_end=2.0)
        with mpmath.workdps(30):
            truth = mpmath.root(mpmath.mpf("0.5"), power) - mpmath.mpf(start)
        assert run.attrs["status"] == "stopped" and certified(run)
        assert abs(run["event_time"].values[-1] - truth) <= 1e-12


@pytest.mark.parametrize("power", [20, 50, 100])
def test_a_power_that_is_flat_on_the_way(power):
    """Steps become long in the flat part, where only the remainder tells what comes."""
    run = ns.simulate(stopping({"x": "1"}, f"0.5 - (x - 5)**{power}"), {"x": 4.1}, t_end=3.0)
    with mpmath.workdps(30):
        truth = 5 + mpmath.root(mpmath.mpf("0.5"), power) - mpmath.mpf(4.1)
    assert run.attrs["status"] == "stopped" and certified(run)
    assert abs(run["event_time"].values[-1] - truth) <= 1e-12


@pytest.mark.parametrize("power", [21, 25, 100])
def test_a_start_without_any_term_is_estimated(power):
    falls = ns.simulate(stopping({"x": "1"}, f"-x**{power}"), {"x": 0.0}, t_end=2.0)
    assert falls.attrs["status"] == "stopped" and not certified(falls)
    assert falls["event_time"].values[-1] <= 0.01  # it falls at once, where x**power is 1e-200
    assert falls.attrs["n_estimated"] > 0
    rises = ns.simulate(stopping({"x": "1"}, f"x**{power}"), {"x": 0.0}, t_end=2.0)
    assert rises.attrs["status"] == "completed" and not certified(rises)
    assert rises.attrs["n_estimated"] > 0


@pytest.mark.parametrize("more", [{}, {"z": "sin(z)"}], ids=["linear", "taylor"])
@pytest.mark.parametrize("links", [1, 2, 5, 6, 7, 9, 12, 19, 21, 25])
def test_chain_of_integrators(links, more):
    """s0 = t**k / k! - t**(k + 1) / (k + 1)!: zero to order k at the start, and at k + 1."""
    chain = {f"s{i}": f"s{i + 1}" for i in range(links)} | {f"s{links}": "-1"} | more
    start = dict.fromkeys(chain, 0.0) | {f"s{links}": 1.0}
    rises = ns.simulate(stopping(chain, "s0"), start, t_end=60.0)
    assert rises.attrs["status"] == "stopped"
    assert rises["event_time"].values[-1] == pytest.approx(links + 1, rel=1e-12)
    falls = ns.simulate(stopping(chain, "-s0"), start, t_end=60.0)
    assert falls.attrs["status"] == "stopped"
    assert falls["event_time"].values[-1] <= 1e-8
    seen = not more or links < 20  # a series has coefficients up to order 20
    assert certified(rises) == certified(falls) == seen


def test_product_of_two_chains():
    """The distance s0 * r0 is zero to order 8 at the start, in a mode in closed form."""
    chain = {f"{s}{i}": f"{s}{i + 1}" for s in "sr" for i in range(4)} | {"s4": "-1", "r4": "0"}
    start = dict.fromkeys(chain, 0.0) | {"s4": 1.0, "r4": 1.0}
    for guard, end in (("s0*r0", 5.0), ("-s0*r0", 0.0)):
        run = ns.simulate(stopping(chain, guard), start, t_end=60.0)
        assert run.attrs["status"] == "stopped"
        assert run["event_time"].values[-1] == pytest.approx(end, rel=1e-12)


def test_certificate_goes_along_where_a_run_is_cut():
    system = stopping({"x": "1"}, "x**25")
    first = ns.simulate(system, {"x": 0.0}, t_end=1e-9)
    later = ns.simulate(system, first, t_end=1.0)
    assert first.attrs["certified"] == later.attrs["certified"] == 0


@pytest.mark.parametrize("width", [0.1, 1e-2, 1e-3, 1e-4, 1e-5])
def test_two_crossings_beside_a_flat_minimum(width):
    """(x - c)**4 - w**4 has terms of 1e4 at the start, and is 1e-20 deep between its zeros.

    x is known to a rounding of 10, and so is the root.
    """
    flow, centre = {"x": "1"}, 10.123
    guard = f"(x - {centre})**4 - {width}**4"
    modes = {
        "before": ns.Mode(flow, exits=[ns.Exit(guard, to="within")]),
        "within": ns.Mode(flow, exits=[ns.Exit(f"-({guard})", to="behind")]),
        "behind": ns.Mode(flow),
    }
    run = ns.simulate(ns.System(states=["x"], modes=modes), {"x": 0.0}, t_end=20.0)
    assert run["event_time"].values[1:] == pytest.approx(
        [centre - width, centre + width], abs=1e-14
    )
    assert certified(run)


def test_no_crossing_above_a_flat_minimum():
    for depth in (1e-8, 1e-12, 1e-16, 1e-20):
        system = stopping({"x": "1"}, f"(x - 10.123)**4 + {depth}")
        run = ns.simulate(system, {"x": 0.0}, t_end=20.0)
        assert run.attrs["status"] == "completed" and certified(run)


@pytest.mark.parametrize("more", [{}, {"z": "sin(z)"}], ids=["linear", "taylor"])
def test_a_fall_through_a_triple_zero(more):
    """-(t - 1)**3: what rounding hides lasts (margin)**(1/3), and so is the time known, flagged.

    The margin is some 100 units of the terms, which add up to 8.
    """
    system = stopping({"x": "3*(t - 1)**2"} | more, "-x")
    run = ns.simulate(system, {"x": -1.0} | dict.fromkeys(more, 0.0), t_end=3.0)
    assert run.attrs["status"] == "stopped" and run.attrs["n_uncertain"] > 0
    resolution = (100 * 2.0**-52 * 8) ** (1 / 3)
    assert run["event_time"].values[-1] == pytest.approx(1.0, abs=resolution)
