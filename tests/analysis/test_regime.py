"""What motions settle to, beside closed forms."""

import re

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

import nonsmooth as ns
from analysis.test_bifurcation_diagram import ball
from analysis.walls import damped, kicked, rigid_wall, stick_and_slip
from nonsmooth import Exit, Mode, OptionError, System
from nonsmooth.analysis.regimes.closed_curves import Rotation, closed_curves
from nonsmooth.analysis.regimes.window import cyclic_word


def label(found) -> str:
    return found["regime"].item()


def free(zeta: float, **options) -> System:
    """Linear oscillator that nothing drives."""
    return System(
        name="free",
        states=["x", "v"],
        parameters={"zeta": zeta},
        initial={"x": 1.0},
        equations={"x": "v", "v": "-x - 2*zeta*v"},
        **options,
    )


def test_multipliers_of_a_linear_motion():
    """Below the stop the soft impact oscillator is linear: exp((-zeta +- i omega_d) T)."""
    zeta, omega = 0.03, 0.4
    found = ns.regime(ns.models.soft_impact(omega=omega, zeta=zeta, a=0.5), transient=300)
    period = 2 * np.pi / omega
    expected = np.exp((-zeta + 1j * np.sqrt(1 - zeta**2)) * period)
    assert (label(found), found["period"].item(), found["word"].item()) == ("periodic", 1, "free")
    assert found["multiplier_real"].values == pytest.approx([expected.real] * 2, abs=1e-12)
    assert np.abs(found["multiplier_imag"].values) == pytest.approx(
        [abs(expected.imag)] * 2, abs=1e-12
    )
    assert found["exponent"].item() == pytest.approx(-zeta, abs=1e-12)
    assert found["residual"].item() < 1e-6
    assert found["events"].item() == found["impacts"].item() == 0.0
    assert np.isnan(found["K"].item())


@pytest.mark.parametrize("omega", [0.83, 0.87, 0.95])
def test_damping_is_the_product_of_the_multipliers(omega):
    """Through any number of contacts: nothing jumps, so the area shrinks by the damping."""
    found = ns.regime(ns.models.soft_impact(omega=omega))
    assert label(found) == "periodic"
    p = found["period"].item()
    assert found["events"].item() * p >= 2
    expected = np.exp(-2 * 0.01 * p * 2 * np.pi / omega)
    assert float(found["multiplier_modulus"].prod()) == pytest.approx(expected, rel=1e-8)


def test_a_period_that_does_not_divide_the_record():
    """The words of both windows begin in different turns of the motion unless that is heeded."""
    found = ns.regime(ns.models.gear_pair(Omega=0.96, zeta=0.08), record=100)
    assert label(found) == "periodic"
    assert 100 % found["period"].item() != 0
    run = ns.simulate(ns.models.gear_pair(Omega=0.96, zeta=0.08), periods=400, samples_per_period=1)
    events = np.count_nonzero(run["event_time"].values > 310 * run.attrs["period"]) / 90
    assert found["events"].item() == pytest.approx(events, abs=0.02)


def test_words_that_begin_elsewhere():
    assert cyclic_word("free hit free out free") == cyclic_word("hit free out free hit")
    assert cyclic_word("free hit free out free") != cyclic_word("free hit free hit free")
    assert cyclic_word("free") == ("free",)
    assert cyclic_word("") == ()


def test_a_bouncing_ball_doubles_its_period():
    """At the doubling of one impact per period the multipliers are -1 and -r^2."""
    r = 0.8
    doubling = np.hypot(np.pi * (1 - r) / (1 + r), 2 * (1 + r**2) / (1 + r) ** 2)
    before, after = (ns.regime(ball(doubling + d), transient=800) for d in (-0.005, 0.02))
    assert (label(before), before["period"].item()) == ("periodic", 1)
    assert (label(after), after["period"].item()) == ("periodic", 2)
    for found in (before, after):
        assert found["impacts"].item() == 1.0
        p = found["period"].item()
        assert float(found["multiplier_modulus"].prod()) == pytest.approx(r ** (2 * p), rel=1e-7)
    largest = before["multiplier_real"].values[0]
    assert -1.0 < largest < -0.9
    assert np.all(before["multiplier_imag"] == 0.0)


def test_chaos_with_a_known_exponent():
    """Once per period x becomes 1 - 2 x^2: the exponent is ln 2 per period."""
    half = Mode({"x": "0"}, exits=[Exit("sin(t)", to="second")])
    second = Mode({"x": "0"}, exits=[Exit("-sin(t)", to="first", reset={"x": "1 - 2*x**2"})])
    system = System(
        states=["x"], period="2*pi", initial={"x": 0.3}, modes={"first": half, "second": second}
    )
    found = ns.regime(system, phase=0.25)
    assert label(found) == "chaotic"
    assert (found["period"].item(), found["impacts"].item()) == (0, 1.0)
    away = found["exponent"].item() - np.log(2) / (2 * np.pi)
    assert abs(away) < 3 * found["exponent_error"].item() < 0.02
    assert found["K"].item() > 0.9
    assert np.all(np.isnan(found["multiplier_modulus"]))


def test_chaos_of_the_soft_impact_oscillator():
    assert label(ns.regime(ns.models.soft_impact(omega=0.905))) == "chaotic"


@pytest.mark.parametrize("system", [rigid_wall(), ns.models.duffing()], ids=["wall", "duffing"])
def test_other_chaos(system):
    found = ns.regime(system)
    assert label(found) == "chaotic"
    assert found["exponent"].item() > 10 * found["exponent_error"].item()


def test_weak_chaos_in_narrow_bands():
    """Four bands of a fiftieth of the motion; a plain 0-1 test of their strobes finds nothing."""
    system = ns.models.soft_impact(omega=0.8842, a=0.6684)
    found = ns.regime(system)
    assert label(found) == "chaotic"
    assert found["residual"].item() < 0.05
    points = ns.stroboscopic_map(system, transient=1500, record=1000)
    assert ns.zero_one_test(points["x"].values)["K"].item() < 0.1


def test_a_ball_that_comes_to_rest_is_absorbed():
    """On a table at half the acceleration of gravity it cannot leave the table again."""
    found = ns.regime(ball(0.9).with_parameters(gamma=0.5), {"x": 1.0, "v": 0.0})
    assert label(found) == "absorbed"
    assert "event_limit" in found.attrs["message"]
    for name in ("exponent", "exponent_error", "K", "impacts"):
        assert np.isnan(found[name].item())


def test_a_motion_that_stops_is_absorbed():
    """The speed of v' = 1 + cos t passes 100 within the sixteenth period."""
    system = System(
        states=["v"],
        period="2*pi",
        modes={"m": Mode({"v": "1 + cos(t)"}, exits=[Exit("100 - v", to="stop")])},
    )
    found = ns.regime(system)
    assert label(found) == "absorbed"
    assert found["transient_used"].item() == 15


def test_a_motion_that_diverges():
    system = System(states=["x"], period="2*pi", equations={"x": "x + cos(t)"})
    assert label(ns.regime(system)) == "diverged"


def test_undamped_motion_of_two_frequencies_is_quasi_periodic():
    """Strobes of cos t and cos(sqrt(3) t) at multiples of sqrt(2) never repeat."""
    equations = {"x": "v", "v": "-x", "y": "w", "w": "-3*y"}
    both = System(states=["x", "v", "y", "w"], initial={"x": 1.0, "y": 1.0}, equations=equations)
    found = ns.regime(both, period="sqrt(2)")
    assert label(found) == "quasi-periodic"
    # neighbours keep within sqrt(3) of their distance, over 250 strobes at least
    assert abs(found["exponent"].item()) < np.log(np.sqrt(3)) / (250 * np.sqrt(2))
    assert found["K"].item() < 0.1
    assert found.attrs["strobe_period"] == np.sqrt(2)


def test_undamped_motion_of_one_frequency_attracts_nothing():
    """Strobes of x = cos t at multiples of sqrt(2) never repeat, but lie on a closed orbit."""
    found = ns.regime(free(0.0), period="sqrt(2)")
    assert label(found) == "unsettled"
    assert "on one closed curve" in found.attrs["message"]
    assert abs(found["exponent"].item()) < 1e-12


def test_two_frequencies_are_quasi_periodic():
    """The phase of the second force is no state: exponents are those of the damping."""
    system = System(
        states=["x", "v"],
        equations={"x": "v", "v": "-2*x - 0.2*v + cos(t) + cos(sqrt(3)*t)"},
    )
    found = ns.regime(system, period="2*pi")
    assert label(found) == "quasi-periodic"
    assert found["exponent"].item() == pytest.approx(-0.1, abs=1e-4)


def test_a_torus_that_attracts_is_quasi_periodic():
    """Van der Pol's oscillator beats with a force off its resonance."""
    system = System(
        states=["x", "v"],
        initial={"x": 1.0},
        period="2*pi/1.7",
        equations={"x": "v", "v": "0.5*(1 - x**2)*v - x + 0.3*cos(1.7*t)"},
    )
    assert label(ns.regime(system)) == "quasi-periodic"


def test_a_rotation_number_is_quasi_periodic():
    """A wall that throws back at a speed of its own leaves one direction, a circle map."""
    assert label(ns.regime(kicked())) == "quasi-periodic"


def circle_map(turn: float, bend: float) -> System:
    """Once per period x becomes x + turn + bend sin(2 pi x) on the circle, from 1 back to 0."""
    back = Exit("1 - x", reset={"x": "x - 1"}, name="back")
    onward = {"x": "x + turn + bend*sin(2*pi*x)"}
    return System(
        states=["x"],
        parameters={"turn": turn, "bend": bend},
        period="2*pi",
        initial={"x": 0.3},
        modes={
            "first": Mode({"x": "0"}, exits=[Exit("sin(t)", to="second"), back]),
            "second": Mode({"x": "0"}, exits=[Exit("-sin(t)", to="first", reset=onward), back]),
        },
    )


def iterated(turn: float, bend: float, count: int = 100_000) -> tuple[float, float]:
    """Rotation number, to 1/count, and exponent per period of that circle map, by itself."""
    x = np.empty(count + 1)
    x[0] = 0.3
    for k in range(count):
        x[k + 1] = x[k] + turn + bend * np.sin(2 * np.pi * x[k])
    slopes = np.abs(1 + 2 * np.pi * bend * np.cos(2 * np.pi * x[:-1]))
    return (x[-1] - x[0]) / count, np.log(slopes).mean()


def told_rotation(found) -> tuple[float, float]:
    """Rotation number of the message, and its error."""
    told = re.search(r"rotation number ([0-9.]+) \+- ([0-9.]+)", found.attrs["message"])
    assert told is not None
    return float(told[1]), float(told[2])


@pytest.mark.parametrize(
    ("turn", "bend"), [(0.5 * (5**0.5 - 1), 0.0), (0.45, 0.1), (0.2, 0.14), (0.7, 0.12)]
)
def test_a_circle_that_turns_is_quasi_periodic(turn, bend):
    """Its one coordinate jumps where it begins anew; a rigid turn has the rotation number turn."""
    found = ns.regime(circle_map(turn, bend), phase=0.25)
    assert label(found) == "quasi-periodic"
    told, error = told_rotation(found)
    known = iterated(turn, bend)[0] if bend else turn
    assert abs(told - known) <= error + 5e-5  # the last digit that is told


@pytest.mark.parametrize(
    ("turn", "bend", "period"), [(0.5, 0.1, 2), (0.01, 0.1, 1), (0.35, 0.14, 3)]
)
def test_a_circle_that_turns_by_a_fraction_is_periodic(turn, bend, period):
    found = ns.regime(circle_map(turn, bend), phase=0.25)
    assert (label(found), found["period"].item()) == ("periodic", period)


def test_a_circle_that_is_folded_is_chaotic():
    found = ns.regime(circle_map(0.51, 0.45), phase=0.25)
    assert label(found) == "chaotic"
    exponent = iterated(0.51, 0.45)[1] / (2 * np.pi)
    assert abs(found["exponent"].item() - exponent) < 4 * found["exponent_error"].item()


@pytest.mark.parametrize("turn", [0.6, 0.25])
def test_a_rigid_turn_by_a_fraction_attracts_nothing(turn):
    found = ns.regime(circle_map(turn, 0.0), phase=0.25)
    assert label(found) == "unsettled"
    assert "unit circle" in found.attrs["message"]


@pytest.mark.parametrize("current", [1.2, 1.5, 3.0])
def test_the_rotation_number_of_a_neuron_that_leaks(current):
    """v' = I - v from 0 to 1 takes ln(I / (I - 1)): one over that is a turn per unit time."""
    neuron = System(
        states=["v"],
        parameters={"I": current, "A": 0.0},
        period=1.0,
        modes={"m": Mode({"v": "I - v + A*cos(2*pi*t)"}, exits=[Exit("1 - v", reset={"v": "0"})])},
    )
    found = ns.regime(neuron)
    assert label(found) == "quasi-periodic"
    told, error = told_rotation(found)
    turn = 1 / np.log(current / (current - 1)) % 1
    assert abs(told - turn) <= error + 5e-5
    # two states, and a forcing that it is not locked to
    neuron = System(
        states=["v", "w"],
        parameters={"A": 0.05},
        period=1.0,
        modes={
            "m": Mode(
                {"v": "1.2 - v - 0.3*w + A*cos(2*pi*t)", "w": "-w/0.7"},
                exits=[Exit("1 - v", reset={"v": "0", "w": "w + 0.2"}, name="spike")],
            )
        },
    )
    assert label(ns.regime(neuron)) == "quasi-periodic"


@pytest.mark.parametrize(
    "step",
    [
        lambda x: (2 * x + 1e-3) % 1,  # doubling
        lambda x: 1 - 2 * x**2,  # folded
        lambda x: -0.999 * x,  # turns over, and settles
        lambda x: 0.999 * x,  # settles
        lambda x: x + 1,  # grows
        lambda x: (x + 0.4 + 1e-9) % 1,  # nearly repeats
    ],
)
def test_what_does_not_turn_has_no_rotation_number(step):
    values = [0.3 / np.sqrt(2)]
    for _ in range(400):
        values.append(step(values[-1]))
    assert isinstance(closed_curves(np.array(values)[:, None]), Rotation)


def test_a_motion_that_forgets_is_locked():
    """A mass rests until sin t = 0.9, is thrown up, and lands two units of time later."""
    system = System(
        states=["x", "v"],
        period="2*pi",
        modes={
            "flight": Mode(
                {"x": "v", "v": "-1"},
                exits=[Exit("x", to="rest", reset={"x": "0", "v": "0"}, name="landing")],
            ),
            "rest": Mode(
                {"x": "0", "v": "0"},
                exits=[Exit("0.9 - sin(t)", to="flight", reset={"v": "1"}, name="launch")],
            ),
        },
    )
    found = ns.regime(system, {"x": 0.5})
    assert (label(found), found["period"].item()) == ("locked", 1)
    assert found["word"].item() == "rest flight rest"
    assert found["impacts"].item() == 2.0
    assert found["exponent"].item() == -np.inf
    assert np.all(found["multiplier_modulus"] == 0.0)


def test_strong_damping_is_not_locked():
    """exp(-30 T) is below every rounding, and still a number."""
    system = System(
        states=["x"], period="2*pi", equations={"x": "-30*x + cos(t)"}, initial={"x": 1.0}
    )
    found = ns.regime(system)
    assert label(found) == "periodic"
    assert found["exponent"].item() == pytest.approx(-30.0, rel=1e-9)


def test_equilibria():
    found = ns.regime(free(0.1, period="2*pi"))
    assert (label(found), found["period"].item()) == ("equilibrium", 1)
    assert found["exponent"].item() == pytest.approx(-0.1, abs=1e-9)
    # x = 0 at the strobes of this one is no rest
    system = System(states=["x"], period="2*pi", equations={"x": "-x + cos(t) + sin(t)"})
    assert label(ns.regime(system, {"x": 1.0})) == "periodic"


@pytest.mark.slow
@pytest.mark.parametrize("period", [1.0, "sqrt(2)"])
def test_limit_cycles(period):
    system = System(
        states=["x", "v"], initial={"x": 1.0}, equations={"x": "v", "v": "(1 - x**2)*v - x"}
    )
    found = ns.regime(system, period=period)
    assert label(found) == "limit-cycle"
    # the other exponent is zero, so this one is the mean divergence, after twenty cycles
    late = solve_ivp(
        lambda t, z: [z[1], (1 - z[0] ** 2) * z[1] - z[0], 1 - z[0] ** 2],
        (0, 1000), [2.0, 0.0, 0.0], rtol=1e-8, atol=1e-10, t_eval=[100, 1000],
    ).y[2]  # fmt: skip
    assert found["exponent"].item() == pytest.approx((late[1] - late[0]) / 900, abs=0.01)
    assert label(ns.regime(stick_and_slip(), period=period)) == "limit-cycle"


def flow(**equations: str) -> System:
    return System(states=list(equations), equations=equations)


@pytest.mark.few(7)
@pytest.mark.parametrize("period", [1.0, "sqrt(2)"])
@pytest.mark.parametrize(
    ("equations", "initial", "expected"),
    [
        ({"x": "-0.01*x"}, {"x": 0.1}, "equilibrium"),  # exp(-32) is left of the start
        ({"x": "-0.001*x"}, {"x": 0.1}, "unsettled"),
        ({"x": "0.001*x"}, {"x": 0.1}, "unsettled"),
        ({"x": "0.01*x"}, {"x": 0.1}, "unsettled"),
        ({"x": "1"}, {"x": 0.1}, "unsettled"),
        ({"x": "1/(1 + x**2)"}, {"x": 0.1}, "unsettled"),
        ({"x": "-x**3"}, {"x": 1.0}, "unsettled"),
        ({"x": "-0.01*x", "y": "-y"}, {"x": 1.0, "y": 1.0}, "equilibrium"),
        ({"x": "-0.001*x", "y": "-y"}, {"x": 1.0, "y": 1.0}, "unsettled"),
        ({"x": "0.01*x", "y": "-y"}, {"x": 1.0, "y": 1.0}, "unsettled"),
        ({"x": "1", "y": "-y"}, {"y": 1.0}, "unsettled"),
        ({"x": "v", "v": "-x - 0.002*v"}, {"x": 1.0}, "unsettled"),
    ],
)
def test_motions_without_a_cycle_are_no_limit_cycles(equations, initial, expected, period):
    """Linear flows and scalar ones, whose motions are known; neighbours approach most of them."""
    found = ns.regime(flow(**equations), initial, period=period)
    # with the longer steps more of them get to their end
    ends = (expected,) if period == 1.0 else (expected, "equilibrium", "diverged")
    assert label(found) in ends
    if label(found) == "unsettled" and len(equations) == 1:
        assert "has no cycle" in found.attrs["message"]
        assert np.isnan(found["exponent"].item())


def test_growth_without_bound_is_not_chaotic():
    found = ns.regime(flow(x="0.005*x", y="0.01*y"), {"x": 1.0, "y": 1.0}, period=1.0)
    assert label(found) == "unsettled"
    assert "grows" in found.attrs["message"]


def test_a_torus_that_travels_is_not_quasi_periodic():
    """The angle z of a cycle goes on for ever; declared as a drift it leaves the cycle."""
    circle = {"x": "x*(1 - x*x - y*y) - y", "y": "y*(1 - x*x - y*y) + x", "z": "1 + x"}
    found = ns.regime(flow(**circle), {"x": 1.2}, period=1.0)
    assert label(found) == "unsettled"
    assert "z travels" in found.attrs["message"]
    declared = System(states=list(circle), equations=circle, drift=["z"])
    assert label(ns.regime(declared, {"x": 1.2}, period=1.0)) == "limit-cycle"


@pytest.mark.parametrize("period", [0.3, 1.0, 6.66])
@pytest.mark.parametrize("mu", [0.1, 3.0])
def test_slow_and_stiff_cycles(mu, period):
    """Strobes at 6.66 creep along the cycle of mu = 0.1, whose period is 2 pi (1 + mu^2 / 16)."""
    system = flow(x="v", v=f"{mu}*(1 - x**2)*v - x")
    assert label(ns.regime(system, {"x": 1.0}, period=period)) == "limit-cycle"


def test_strobes_that_creep_along_a_cycle():
    """Angular speed one: 500 strobes at 2 pi + 0.001 pass a twelfth of the circle."""
    system = flow(x="x*(1 - x*x - y*y) - y", y="y*(1 - x*x - y*y) + x")
    found = ns.regime(system, {"x": 1.2}, period="2*pi + 0.001", longest=200)
    assert label(found) == "limit-cycle"


@pytest.mark.parametrize("period", [1.0, "sqrt(2)"])
def test_cycles_of_relays(period):
    """A thermostat with one state, whose half cycles last ln 3, and an oscillator with a relay."""
    heater = System(
        states=["x"],
        modes={
            "on": Mode({"x": "2 - x"}, exits=[Exit("1.5 - x", to="off")]),
            "off": Mode({"x": "-x"}, exits=[Exit("x - 0.5", to="on")]),
        },
    )
    found = ns.regime(heater, {"x": 1.0}, mode="on", period=period)
    assert label(found) == "limit-cycle"
    # the mean over a window of a hundred intervals
    length = found.attrs["strobe_period"]
    assert found["events"].item() == pytest.approx(length / np.log(3), abs=0.011)
    relay = System(
        states=["x", "v"],
        modes={
            "up": Mode({"x": "v", "v": "1 - x - 0.2*v"}, exits=[Exit("0.5 - x", to="down")]),
            "down": Mode({"x": "v", "v": "-1 - x - 0.2*v"}, exits=[Exit("x + 0.5", to="up")]),
        },
    )
    assert label(ns.regime(relay, {"x": 0.1}, mode="up", period=period)) == "limit-cycle"


@pytest.mark.parametrize(
    ("equations", "initial", "expected"),
    [
        ({"x": "1"}, {"x": 0.1}, ("periodic", 1.0)),
        ({"x": "v", "v": "1 - v"}, {}, ("periodic", 1.0)),
        ({"x": "v", "v": "-0.1*v"}, {"v": 1.0}, ("equilibrium", 0.0)),
        ({"x": "0"}, {"x": 0.1}, ("equilibrium", 0.0)),
    ],
)
def test_a_drift_at_constant_speed_is_no_equilibrium(equations, initial, expected):
    system = System(states=list(equations), equations=equations, drift=["x"])
    found = ns.regime(system, initial, period=1.0)
    assert (label(found), found["period"].item()) == (expected[0], 1)
    assert found["x_per_time"].item() == pytest.approx(expected[1], abs=1e-12)
    assert ("travels in x" in found.attrs["message"]) == (expected[0] == "periodic")


def test_a_cycle_strobed_at_its_own_period():
    """r' = r (1 - r^2) on a circle passed in 2 pi: the multiplier across is exp(-4 pi)."""
    system = System(
        states=["x", "y"],
        initial={"x": 0.5},
        equations={"x": "x*(1 - x*x - y*y) - y", "y": "y*(1 - x*x - y*y) + x"},
    )
    found = ns.regime(system, period="2*pi")
    assert (label(found), found["period"].item()) == ("periodic", 1)
    assert found["multiplier_modulus"].values[0] == pytest.approx(np.exp(-4 * np.pi), rel=1e-6)


def test_the_transient_is_doubled_until_it_is_over():
    """exp(-0.01 t) of the start is left; it has to fall to a millionth of the motion."""
    found = ns.regime(damped(0.01), {"x": 1.0}, transient=5, record=20, longest=1000)
    assert label(found) == "periodic"
    used = found["transient_used"].item()
    assert used > 220  # ln(1e6) / 0.0628
    assert found["multiplier_modulus"].values == pytest.approx(
        [np.exp(-0.01 * 2 * np.pi / np.sqrt(1 - 1e-4))] * 2, abs=1e-9
    )


@pytest.mark.parametrize("zeta", [1e-3, 1e-4, 1e-5])
def test_a_transient_that_is_not_over_is_unsettled(zeta):
    found = ns.regime(damped(zeta), {"x": 30.0}, transient=10, longest=80)
    assert label(found) == "unsettled"
    assert found["transient_used"].item() <= 80


def test_a_slow_decay_tells_how_long_to_follow_it():
    """exp(-zeta t) is left: in 14000 periods of one time unit a millionth."""
    found = ns.regime(free(1e-3), period=1.0)
    assert label(found) == "unsettled"
    told = re.search(r"factor ([0-9.]+) per period; .* longest=([0-9]+) is", found.attrs["message"])
    assert told is not None
    # the extremes of sampled windows are off by some percent, a 500th of which is in the factor
    assert float(told[1]) == pytest.approx(np.exp(-1e-3), abs=5e-5)
    assert 14_000 < int(told[2]) < 3 * 14_000
    assert label(ns.regime(free(1e-3), period=1.0, longest=int(told[2]))) == "equilibrium"


@pytest.mark.parametrize("zeta", [2e-4, 8e-4])
def test_a_slow_decay_to_a_driven_motion_is_no_torus(zeta):
    """exp(-2 pi zeta) of the way to the cycle is left after a period."""
    system = System(
        states=["x", "v"],
        parameters={"zeta": zeta},
        period="2*pi",
        initial={"x": 1.0},
        equations={"x": "v", "v": "-2.1*x - 2*zeta*v + cos(t)"},
    )
    found = ns.regime(system)
    assert label(found) == "unsettled"
    told = re.search(r"factor ([0-9.]+) per period; .* longest=([0-9]+) is", found.attrs["message"])
    assert told is not None
    assert float(told[1]) == pytest.approx(np.exp(-2 * np.pi * zeta), abs=5e-5)
    assert label(ns.regime(system, longest=int(told[2]))) == "periodic"


def test_a_motion_without_damping_that_repeats_attracts_nothing():
    found = ns.regime(free(0.0), period="2*pi", transient=20, longest=40)
    assert label(found) == "unsettled"
    assert "unit circle" in found.attrs["message"]


def test_the_mole_drifts():
    found = ns.regime(ns.models.moling())
    run = ns.simulate(ns.models.moling(), periods=220, samples_per_period=1)
    way = float(run["v"][220] - run["v"][200]) / 20
    assert (label(found), found["period"].item()) == ("periodic", 1)
    assert found["v_per_period"].item() == pytest.approx(way, abs=1e-9)
    assert found["v_per_time"].item() == pytest.approx(way / run.attrs["period"], abs=1e-12)
    assert found.sizes["multiplier"] == 3  # that of the drift, one, is left out
    assert found["multiplier_modulus"].values[2] == 0.0  # the slaved state


def test_starts_and_files(tmp_path):
    """A run, a point of it, and the same start in words lead to the same motion."""
    system = ns.models.soft_impact()
    run = ns.simulate(system, {"x": 0.2}, periods=3)
    words = {name: float(run[name][-1]) for name in ("x", "v")}
    found = [ns.regime(system, start) for start in (run, run.isel(time=-1), words)]
    for each in found:
        assert label(each) == label(found[0])
        assert each["period"].item() == found[0]["period"].item()
    found[0].to_netcdf(tmp_path / "r.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "r.nc", engine="h5netcdf") as again:
        xr.testing.assert_identical(again.load(), found[0])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"transient": -1}, "transient"),
        ({"record": 1}, "seen twice"),
        ({"evidence": 10}, "20 strobes at least; a survey"),
        ({"longest": 10}, "less than transient"),
        ({"phase": 1.0}, "phase = 1"),
        ({"match": 1.0}, "match = 1"),
        ({"period": -1.0}, "must be positive"),
        ({"period": "q"}, "no parameter"),
        ({"initial": {"y": 1.0}}, "unknown state 'y'"),
        ({"mode": "rub"}, "unknown mode 'rub'"),
        ({"parameters": {"q": 1.0}}, "q"),
    ],
)
def test_wrong_use(options, message):
    with pytest.raises((OptionError, ns.ModelError), match=message):
        ns.regime(damped(0.1), **options)


def test_systems_that_cannot_settle():
    with pytest.raises(OptionError, match="has no period"):
        ns.regime(free(0.1))
    with pytest.raises(OptionError, match="fits no mode"):
        ns.regime(rigid_wall(), {"x": 5.0})
    slow = System(
        states=["x"], parameters={"k": 1.0}, period="2*pi", slow={"k": "1 + 0.1*t"},
        equations={"x": "-k*x + cos(t)"},
    )  # fmt: skip
    with pytest.raises(OptionError, match="slow="):
        ns.regime(slow)
    measured = System(
        states=["x"],
        signals={"u": ns.Signal([0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 0.0, 1.0])},
        equations={"x": "-x + u"},
    )
    with pytest.raises(OptionError, match="has the signal 'u', which does not repeat"):
        ns.regime(measured, period=1.0)


def test_strobes_of_a_driven_system_are_whole_periods_apart():
    """At other lengths strobes of a periodic motion lie on a curve, as those of a torus."""
    driven = System(states=["x"], period="2*pi", equations={"x": "-x + cos(t)"})
    message = r"no whole multiple of 2\*pi = 6\.28.*Leave period= out"
    for period in (3, "3", 2 * np.pi / 1.5, "2*pi + 1e-6"):
        with pytest.raises(OptionError, match=message):
            ns.regime(driven, period=period)
    assert label(ns.regime(driven, period=4 * np.pi)) == "periodic"
    # what is declared may be several periods of what stands in the equations
    twice = System(states=["x"], period="4*pi", equations={"x": "-x + cos(t)"})
    assert label(ns.regime(twice, period="2*pi")) == "periodic"
    # two frequencies without a common period are a torus
    both = System(states=["x"], equations={"x": "-x + cos(t) + cos(sqrt(2)*t)"})
    assert label(ns.regime(both, period="2*pi")) == "quasi-periodic"


def test_whole_periods_hold_over_all_of_a_map():
    system = ns.models.soft_impact(omega=0.8)
    over = {"omega": [0.8, 0.9], "a": [0.5, 0.7]}
    few = {"transient": 10, "longest": 20, "evidence": 20, "confirm": 0}
    with pytest.raises(OptionError, match=r"2\*pi/omega = 6\.98"):
        ns.regime_map(system, over, period=2 * np.pi / 0.8, **few)
    assert ns.regime_map(system, over, period="4*pi/omega", **few).sizes["omega"] == 2


@pytest.mark.parametrize("omega", [1.7, 1.9])
def test_a_slow_decay_beside_a_stop_is_no_torus(omega):
    """A light oscillator that meets a spring: areas shrink by exp(-c T) in each period.

    That is the product of the multipliers of the motion that it settles to. Two windows of a
    hundred periods on the way there look like a torus.
    """
    damping = 2e-4
    system = ns.System(
        states=["x", "v"],
        parameters={"w": omega, "c": damping},
        period="2*pi/w",
        modes={
            "flow": ns.Mode(
                {"x": "v", "v": "-x - c*v - 0.5*max(x - 0.5, 0) + 0.8*cos(w*t)"},
            )
        },
    )
    early = ns.regime(system)
    assert str(early["regime"].values) == "unsettled"
    assert "quasi-periodic at first" in early.attrs["message"]
    late = ns.regime(system, transient=60_000)
    assert str(late["regime"].values) == "periodic"
    product = float(late["multiplier_modulus"].prod())
    assert product == pytest.approx(np.exp(-damping * 2.0 * np.pi / omega), rel=1e-9)


@pytest.mark.parametrize(
    ("equations", "period", "grows"),
    [
        ({"x": "1 + 0.3*cos(2*pi*t)"}, "1", "x"),  # x = t at strobes
        ({"x": "v", "v": "cos(t) - x"}, "2*pi", "v"),  # v = sin(t)/2 + t/2 cos(t), x = t/2 sin(t)
        ({"x": "v", "v": "cos(t) - x"}, "4*pi", "v"),
    ],
)
def test_what_grows_for_ever_is_said_to_grow(equations, period, grows):
    """Closed forms: the state at strobes grows by the same amount in each period."""
    found = ns.regime(ns.System(states=list(equations), equations=equations, period=period))
    assert found["regime"].item() == "unsettled"
    message = found.attrs["message"]
    assert f"and {grows} grows from window to window, without bound so far" in message
    assert f"{grows} moves on by the same amount each period: drift= declares it" in message
    assert "settles" not in message and "longest" not in message


def test_what_grows_by_larger_and_larger_steps():
    """x = exp(1e-4 t) at strobes; no drift."""
    flow = {"x": "1e-4*x*(1 + cos(2*pi*t))"}
    found = ns.regime(ns.System(states=["x"], equations=flow, period="1", initial={"x": 1.0}))
    message = found.attrs["message"]
    assert "x grows from window to window, without bound so far" in message
    assert "drift=" not in message


def test_what_settles_slowly_is_not_said_to_grow():
    """x = 1 - exp(-2e-4 t) at strobes but for the forcing: its steps get smaller."""
    flow = {"x": "2e-4*(1 - x) + cos(2*pi*t)"}
    found = ns.regime(ns.System(states=["x"], equations=flow, period="1"), longest=4000)
    assert found["regime"].item() == "unsettled"
    assert "grows from window" not in found.attrs["message"]


def test_a_motion_that_follows_two_frequencies_with_jumps_is_not_sent_for_more_evidence():
    """A ball that rests now and then on a table with two frequencies: every rest forgets."""
    bouncing = System(
        states=["z", "u"], initial={"z": 0.03},
        parameters={"g": 9.81, "r": 0.72, "A": 0.004, "B": 0.002, "w": 52.0, "v": 90.0666},
        definitions={"s": "A*sin(w*t) + B*sin(v*t)"},
        modes={
            "fly": Mode({"z": "u", "u": "-g"}, exits=[Exit(
                "z - s", name="hit", sticks="carried",
                reset={"u": "-r*u + (1+r)*(A*w*cos(w*t) + B*v*cos(v*t))"},
            )])
        },
    )  # fmt: skip
    found = ns.regime(bouncing, period="2*pi/w", evidence=500)
    assert found["regime"].item() == "unsettled"
    assert "every perturbation is lost" in found.attrs["message"]
    assert "evidence= tells more" not in found.attrs["message"]
