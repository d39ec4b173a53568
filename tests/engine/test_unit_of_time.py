"""The unit of time of a system without a period: some radians of its modes, where they hold.

Cells are written for one side of a surface. What their functions become on the other side, where
the rest state lies, is the rate of no motion.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.runs.runner import build_tables
from periodic_orbits.belts import cycle_of_belt, stiff_stop, stribeck


def unit(system):
    return build_tables(system).window


def expected(rate):
    """The power of two nearest to 32 radians."""
    return 2.0 ** round(math.log2(32.0 / rate))


def contact(law, gap):
    return ns.System(
        states=["x", "v"],
        parameters={"g": gap, "k": 10.0, "d": 0.01},
        surfaces={"c": ns.Surface("x - g")},
        equations={"x": "v", "v": f"-x - 0.1*sin(x) - heaviside(c)*({law})"},
    )


@pytest.mark.parametrize("v_b", [0.1, 0.6, 1.5, 2.5, 40.0])
def test_friction_on_a_belt_counts_in_its_cells(v_b):
    """Both cells oscillate at one radian; exp(v_b/v_s), 1e173 at last, is the rate of neither."""
    assert unit(stribeck(v_b)) == expected(1.0) == 32.0


def test_the_unit_is_that_of_a_rest_on_the_belt():
    for v_b in (0.3, 2.0):
        on_it = replace(stribeck(v_b), initial={"v": v_b})
        assert unit(stribeck(v_b)) == expected(1.0)
        assert unit(on_it) >= 8.0  # its rest state feels the slope 2 of the law itself


@pytest.mark.parametrize(
    "law",
    [
        "exp(-(s/v_s)**2)",
        "1/(1 + abs(s)/v_s)",
        "sqrt(abs(s))",
        "log(1 + abs(s)/v_s)",
        "abs(s)**0.3",
    ],
)
@pytest.mark.parametrize("v_b", [0.5, 2.0])
def test_laws_that_end_at_their_surface(law, v_b):
    assert unit(stribeck(v_b, law)) == 32.0


@pytest.mark.parametrize("gap", [0.1, 1.0, 20.0])
def test_a_contact_that_saturates(gap):
    """Its force has the slope k/d at the surface, fades behind it, and is e^(gap/d) at rest."""
    assert unit(contact("k*(1 - exp(-(x - g)/d))", gap)) >= expected(math.sqrt(1.1 + 10.0 / 0.01))


def test_a_contact_that_hardens_is_not_looked_at_deep_inside():
    assert unit(contact("k*(exp((x - g)/d) - 1)", 2.0)) == expected(math.sqrt(1.1))


@pytest.mark.parametrize("gap", [0.1, 2.0])
def test_linear_cells_count_wherever_the_rest_state_lies(gap):
    assert unit(contact("k*(x - g)", gap)) == expected(math.sqrt(1.1 + 10.0)) == 8.0


@pytest.mark.parametrize("gap", [1.0, 2.0])
def test_powers_are_as_fast_as_far_inside(gap):
    """A cubic spring as deep as the gap is wide has the slope 3 k gap^2."""
    fastest = math.sqrt(1.0 + 0.1 * math.cos(2.0 * gap) + 30.0 * gap**2)
    assert unit(contact("k*(x - g)**3", gap)) == expected(fastest)


def test_strong_damping_inside_a_cell_leaves_the_unit_alone():
    assert unit(stribeck(1.0, "exp(abs(s)/v_s)")) == 32.0


def test_a_cell_without_states_has_no_say():
    """Nothing is above one and below minus one, where both fading forces would be e^200."""
    system = ns.System(
        states=["x", "v"],
        surfaces={"up": ns.Surface("x - 1"), "down": ns.Surface("-1 - x")},
        equations={
            "x": "v",
            "v": "-x - heaviside(up)*(1 - exp(-(x - 1)/0.01))"
            " + heaviside(down)*(1 - exp(-(-1 - x)/0.01))",
        },
    )
    assert unit(system) >= expected(math.sqrt(1.0 + 100.0))


def test_a_cell_into_which_no_way_leads_from_rest():
    """The gradient of x^2 + v^2 - 1 vanishes at rest; the outer cell counts by its rates there."""
    system = ns.System(
        states=["x", "v"],
        surfaces={"s": ns.Surface("x**2 + v**2 - 1")},
        equations={"x": "v", "v": "-x - 15*heaviside(s)*x - 0.1*x**3"},
    )
    assert unit(system) == expected(4.0)


@pytest.mark.parametrize("k", [1e4, 1e6, 1e8, 1e12])
def test_a_stiff_stop_far_away_counts_by_its_oscillation(k):
    """Where it begins is a large constant by the units alone."""
    assert unit(stiff_stop(k)) == expected(math.sqrt(1.0 + k))


def test_the_unit_follows_parameters():
    for v_b in (0.2, 2.0):
        run = ns.simulate(stribeck(0.1), t_end=1.0, parameters={"v_b": v_b})
        assert run.attrs["window"] == 32.0


@pytest.mark.parametrize("v_b", [1.5, 2.5])
def test_stick_and_slip_on_a_fast_belt(v_b):
    """With a unit of 1e-9 a run of 20 units of time took hours."""
    run = ns.simulate(stribeck(v_b), {"x": 0.6, "v": v_b}, t_end=20.0, max_seconds=30.0)
    assert run.attrs["status"] == "completed"
    last_cycle = np.diff(run["event_time"].values)[-2:].sum()
    assert last_cycle == pytest.approx(cycle_of_belt(v_b), rel=1e-9)
