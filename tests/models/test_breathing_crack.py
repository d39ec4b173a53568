"""The breathing crack against 50 digits, an adaptive integrator, and what is known of any orbit."""

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.integrate import solve_ivp

import nonsmooth as ns
from reference.linear import LinearExit, LinearMode, hybrid_run

GROWTH = "5 + 1e-3*exp(t/54734 - 7.8)"
PERIOD = 2 * np.pi / 1.1475


def automaton(xi, eta, d, stiffness):
    """z = (u, v, cos, sin, 1); numbers as the doubles that the package was given."""
    xi, w, d = mpf(xi), mpf(eta), mpf(d)
    modes = {}
    for name, other, sign in (("open", "closed", 1), ("closed", "open", -1)):
        rows = [[mpf(0)] * 5 for _ in range(5)]
        rows[0][1] = mpf(1)
        rows[1] = [-(1 + stiffness[name]), -2 * xi, 0, w * w, d]
        rows[2][3], rows[3][2] = -w, w
        modes[name] = LinearMode(rows, [LinearExit([sign, 0, 0, 0, 0], to=other)])
    return modes


CASES = {
    "as the crack begins": ({"crack": 5.5}, (0.3, -0.2)),
    "period four": ({"crack": 12.0}, (0.0, 0.0)),
    "mean load": ({"crack": 13.03, "d": 0.1}, (1.0, 0.0)),
    "pressed": ({"crack": 10.0, "d": -0.2, "s": 0.5}, (0.1, 0.0)),
    "stiffnesses": ({"kappa_open": 0.0, "kappa_closed": 40.0, "xi": 0.1}, (0.5, 1.0)),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
@mp.workdps(50)
def test_five_periods_from_a_start(name):
    given, start = CASES[name]
    system = ns.models.breathing_crack(**given)
    if "crack" in given:
        s = mpf(given.get("s", 1))
        stiffness = {
            "open": s * mpf("4.245e-3") * (20 - mpf(given["crack"])) ** 3,
            "closed": s * mpf("14.327"),
        }
    else:
        stiffness = {side: mpf(given[f"kappa_{side}"]) for side in ("open", "closed")}
    p = system.parameter_values
    modes = automaton(p["xi"], p["eta"], p["d"], stiffness)
    end = 5 * 2 * mp.pi / mpf(p["eta"])
    true = hybrid_run(modes, [*map(mpf, start), 1, 0, 1], "open", end)
    run = ns.simulate(system, dict(zip("uv", start, strict=True)), periods=5)
    assert run.attrs["status"] == "completed" and run.attrs["n_uncertain"] == 0
    crossings = run["event_time"].values[run["event_kind"].values != "start"]
    assert len(true.events) >= 5 and crossings.size == len(true.events)
    # some dozens of operations of 1e-16 per segment, errors that hardly grow in five periods
    assert max(abs(mpf(float(t)) - e.time) for t, e in zip(crossings, true.events, strict=True)) < (
        mpf(1e-12)
    )
    assert abs(mpf(float(run["u"][-1])) - true.state[0]) < 1e-12
    assert abs(mpf(float(run["v"][-1])) - true.state[1]) < 1e-12


@pytest.mark.parametrize("crack", [5.5, 10.0, 12.09, 13.4])
@pytest.mark.parametrize("n", [1, 7])
def test_product_of_multipliers(crack, n):
    """Both cells lose area at the rate 2 xi, and nothing jumps between them."""
    system = ns.models.breathing_crack(crack=crack)
    run = ns.simulate(system, {"u": 0.4, "v": 0.3}, periods=n, tangent=[])
    matrix = run["tangent"].values[-1]
    assert np.linalg.det(matrix) == pytest.approx(np.exp(-2 * 0.014 * n * PERIOD), rel=1e-11)


@pytest.mark.parametrize(
    ("d", "first"), [(0.0, "open"), (1e-6, "open"), (-1e-6, "closed"), (0.3, "open")]
)
def test_rest_on_the_switching_surface_goes_where_the_first_derivative_points(d, first):
    """At d = 0 that is the third, eta**3."""
    system = ns.models.breathing_crack(crack=12.0, d=d)
    run = ns.simulate(system, periods=1)
    assert run.attrs["phase_word"].split()[0] == first
    t = 1e-3
    early = ns.simulate(system, times=[0.0, t])
    # u = d t^2/2 + eta^3 t^3/6, the next terms being smaller by t
    assert float(early["u"][-1]) == pytest.approx(d * t**2 / 2 + 1.1475**3 * t**3 / 6, rel=2e-2)


def test_preload_weight_and_displacement_enter_by_d_alone():
    """Eq. (50) in y1 = u - gamma, integrated by another code, against the model in u."""
    rho, gamma, f, kappa = 0.7, 0.05, 0.02, {True: 2.2, False: 14.0}
    xi, eta = 0.05, 0.9

    def field(t, y):
        k = kappa[y[0] + gamma > 0]
        force = -(1 + k) * y[0] - (rho + k) * gamma + f + eta**2 * np.sin(eta * t)
        return [y[1], force - 2 * xi * y[1]]

    end = 3 * 2 * np.pi / eta
    other = solve_ivp(field, (0, end), [0, 0], "DOP853", rtol=1e-10, atol=1e-12, max_step=1e-2)
    system = ns.models.breathing_crack(
        xi=xi, eta=eta, d=(1 - rho) * gamma + f, kappa_open=kappa[True], kappa_closed=kappa[False]
    )
    run = ns.simulate(system, {"u": gamma}, times=[0.0, end])
    # without events each of some twenty crossings leaves a step with an error of h^3 = 1e-6
    # times the jump of the slope that the step control then reduces to its tolerance
    assert float(run["u"][-1]) - gamma == pytest.approx(other.y[0, -1], abs=1e-7)


def test_a_crack_that_grows_within_the_flow():
    """Against an adaptive integrator that is stopped at every crossing."""
    system = ns.models.breathing_crack(growth=GROWTH, grows="flow")
    begin, t, z = 9e5, 9e5, np.array([0.1, 0.5])
    end = begin + 20.0
    crossings = []
    while t < end:
        side = z[0] > 0 if z[0] != 0 else z[1] > 0

        def field(t, z, side=side):
            crack = 5 + 1e-3 * np.exp(t / 54734 - 7.8)
            k = 4.245e-3 * (20 - crack) ** 3 if side else 14.327
            return [z[1], -0.028 * z[1] - (1 + k) * z[0] + 1.1475**2 * np.sin(1.1475 * t)]

        def leaves(t, z):
            return z[0]

        leaves.terminal, leaves.direction = True, -1.0 if side else 1.0
        leg = solve_ivp(field, (t, end), z, "DOP853", rtol=1e-12, atol=1e-14, events=leaves)
        t, z = leg.t[-1], leg.y[:, -1]
        if leg.status == 1:
            crossings.append(t)
            z[0] = 0.0
    run = ns.simulate(system, {"u": 0.1, "v": 0.5}, t_start=begin, times=[begin, end])
    found = run["event_time"].values[run["event_kind"].values == "switch"]
    assert len(crossings) > 6 and found == pytest.approx(crossings, abs=2e-9)
    assert run["end_state"].values == pytest.approx(z, abs=1e-9)
    assert run["crack"].values[-1] == pytest.approx(5 + 1e-3 * np.exp(end / 54734 - 7.8), rel=1e-13)


def test_frozen_and_continuous_growth_differ_by_the_growth_in_a_period():
    """From one start at 10.66 mm, where a period adds 5.7e-4 mm, and at a tenth of that rate."""
    gaps = []
    for rate in (54734, 547340):
        growth = f"10.66 + 1e-3*exp({np.log(5660)} + (t - 900000)/{rate}) - 5.66"
        frozen, flow = (
            ns.models.breathing_crack(growth=growth, grows=way) for way in ("frozen", "flow")
        )
        times = 9e5 + PERIOD * np.arange(20)
        # strobes of the frozen crack are multiples of the period
        first = ns.simulate(frozen, {"u": 0.1}, t_start=9e5, times=times)
        second = ns.simulate(flow, {"u": 0.1}, t_start=9e5, times=times)
        gaps.append(np.max(np.abs(first["u"].values - second["u"].values)))
    assert gaps[0] < 1e-3
    assert gaps[1] == pytest.approx(gaps[0] / 10, rel=0.1)


@mp.workdps(30)
def test_the_law_of_guinea_scales_the_closed_stiffness():
    """c1, c2, c3 of Eq. (32) once more."""
    w, b, span, crack = 20, 10, 270, mpf("12.5")
    a, beta = crack / w, mpf(span) / w
    log = mp.log(1 - a)
    c1 = -mpf("0.378") * a**3 * log + a**2 * (mpf("0.29") + mpf("1.39") * a - mpf("1.6") * a**2) / (
        1 + mpf("0.54") * a - mpf("0.84") * a**2
    )
    c2 = mpf("1.1") * a**3 * log + a**2 * (
        -mpf("3.22") - mpf("16.4") * a + mpf("28.1") * a**2 - mpf("11.4") * a**3
    ) / ((1 - a) * (1 + mpf("4.7") * a - 4 * a**2))
    c3 = -mpf("0.176") * a**3 * log + a**2 * (
        mpf("8.91") - mpf("4.88") * a - mpf("0.435") * a**2 + mpf("0.26") * a**3
    ) / ((1 - a) ** 2 * (1 + mpf("2.9") * a))
    beam = mpf(span) ** 3 / (48 * mpf(b) * w**3 / 12) * b  # times E B
    ratio = beam / (beam + c1 + beta * c2 + beta**2 * c3)
    for grows in ("frozen", "flow"):
        system = ns.models.breathing_crack(law="guinea", s=2.0, growth="12.5", grows=grows)
        run = ns.simulate(system, {"u": 0.7}, times=[0.0, 0.01])
        assert float(run["load"][0]) == pytest.approx(float(0.7 * 2 * 14.327 * ratio), rel=1e-13)
    assert 0.2 < ratio < 0.5
    with pytest.raises(ns.ModelError, match="the crack would be through"):
        ns.models.breathing_crack(law="guinea", growth="20.5", grows="flow")


def test_a_crack_that_is_through_ends_the_run():
    frozen = ns.models.breathing_crack(growth="19.9 + t/100")
    with pytest.warns(ns.RunWarning, match="a longer crack is a break"):
        assert ns.simulate(frozen, periods=9).attrs["status"] == "refused"
    flow = ns.models.breathing_crack(growth="19.9 + t/100", grows="flow")
    run = ns.simulate(flow, t_end=50.0)
    assert run.attrs["status"] == "stopped"
    assert float(run["event_time"][-1]) == pytest.approx(10.0, abs=1e-12)
    assert str(run["event_name"].values[-1]) == "broken"


def test_a_crack_that_shrinks_below_its_law_ends_the_run():
    for law, least in (("cubic", 5), ("guinea", 0)):
        flow = ns.models.breathing_crack(growth=f"{least} + 1 - t/10", grows="flow", law=law)
        run = ns.simulate(flow, t_end=50.0)
        assert run.attrs["status"] == "stopped" and str(run["event_name"].values[-1]) == "shrunk"
        assert float(run["event_time"][-1]) == pytest.approx(10.0, abs=1e-12)
        frozen = ns.models.breathing_crack(growth=f"{least} + 1 - t/10", law=law)
        with pytest.warns(ns.RunWarning, match=f"crack >= {least}"):
            assert ns.simulate(frozen, periods=9).attrs["status"] == "refused"
    with pytest.raises(ns.OptionError, match="length"):
        ns.simulate(ns.models.breathing_crack(growth="-3 + t/10", grows="flow"), t_end=50.0)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"crack": 20}, "the specimen is 20 mm wide"),
        ({"crack": -0.1, "law": "guinea"}, "crack >= 0"),
        ({"crack": 4.9}, "below which the cubic law is stiffer open"),
        ({"crack": 7, "growth": GROWTH}, "crack = 7 plays no part"),
        ({"grows": "flow"}, "needs the length of the crack over time"),
        ({"kappa_open": 1, "kappa_closed": 2, "crack": 25}, "crack plays no part"),
        ({"kappa_open": 1, "kappa_closed": 2, "s": 2}, "s plays no part"),
        ({"kappa_open": 1, "kappa_closed": 2, "law": "guinea"}, "law plays no part"),
        ({"kappa_open": -1, "kappa_closed": 2}, "negative stiffness"),
        ({"kappa_open": 1}, "kappa_closed is missing"),
        ({"kappa_open": 1, "kappa_closed": 2, "growth": "5"}, "leave out"),
        ({"law": "quadratic"}, "'cubic' or 'guinea'"),
        ({"growth": GROWTH, "grows": "slowly"}, "'frozen' or 'flow'"),
        ({"growth": "5 + u"}, "u"),
        ({"eta": 0}, "the base must shake"),
        ({"s": 0}, "the specimen is a spring"),
    ],
)
def test_bad_data(given, words):
    with pytest.raises(ns.ModelError, match=words):
        ns.models.breathing_crack(**given)
