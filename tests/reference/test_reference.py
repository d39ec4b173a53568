"""The reference against closed forms, Taylor integration, and one half against the other."""

import json
import math
from itertools import pairwise

import pytest
from mpmath import mp, mpf

from . import automata, balls
from .linear import LinearExit, LinearMode, exact_flow, first_crossing, hybrid_run
from .make_mole_runs import FILE, text
from .mole import DEFAULTS, DIGITS, mole_events, mole_tangent_growth
from .mole_modes import MODES, Mole, State
from .roots import Undecidable

MANY_CONTACTS = {"a": 0.3, "b": 0.27, "xi": 0.05, "omega": 0.1}
DIRECT_PASSAGE = {"a": 0.9, "b": 0.3, "xi": 0.05, "omega": 0.1}
CRITICAL = {"a": 0.3, "b": 0.15, "xi": 1.0, "omega": 0.1}
OVERDAMPED = {"a": 0.3, "b": 0.15, "xi": 1.5, "omega": 0.1}


@pytest.fixture(autouse=True)
def fifty_digits():
    with mp.workdps(DIGITS):
        yield


def mole_of(parameters):
    return Mole(**{name: mpf(x) for name, x in {**DEFAULTS, **parameters}.items()})


# ---------------------------------------------------------------- closed forms of the mole


def equations(mole, mode, state, theta):
    """The flow as it is printed, without closed forms."""
    _, y, q, _ = state
    f = mole.b + mole.a * mp.cos(theta)
    force = 2 * mole.xi * y + q
    creep = (1 - q) / (2 * mole.xi)
    return {
        "no_contact": State(y, f, -q / (2 * mole.xi), 0),
        "contact": State(y, f - force, y, 0),
        "progression": State(creep, f - 1, creep, y - creep),
    }[mode]


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("xi", [0.05, 0.35, 1.0, 1.0000001, 1.5])
def test_closed_forms_satisfy_the_equations(mode, xi):
    mole, theta0 = mole_of({**MANY_CONTACTS, "xi": xi}), mpf("0.7")
    q = mpf("0.3")
    start = State(q + mole.g, mpf("-0.1"), q, mpf(2))
    flow = MODES[mode](mole, start, theta0)
    assert all(abs(x - x0) < mpf("1e-45") for x, x0 in zip(flow.at(mpf(0)), start, strict=True))
    for s in (mpf("0.1"), mpf("1.3"), mpf(20)):
        expected = equations(mole, mode, flow.at(s), theta0 + mole.omega * s)
        for i, rate in enumerate(expected):
            slope = mp.diff(lambda x, i=i: flow.at(x)[i], s)
            assert abs(slope - rate) < mpf("1e-40")


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("xi", [0.05, 1.0, 1.5])
def test_guard_rates_are_the_slopes_of_the_guards(mode, xi):
    mole, theta0, s = mole_of({**MANY_CONTACTS, "xi": xi}), mpf("0.7"), mpf("1.3")
    flow = MODES[mode](mole, State(mpf("0.32"), mpf("-0.1"), mpf("0.3"), mpf(0)), theta0)
    state, theta = flow.at(s), theta0 + mole.omega * s
    if mode == "progression":  # its rate is written for F = 1, where guards are passed
        state = state._replace(y=(1 - state.q) / (2 * mole.xi))
        flow, s, theta0 = MODES[mode](mole, state, theta), mpf(0), theta
    for guard in flow.guards():
        slope = mp.diff(guard.levels(mpf(0), s + 1)[0], s)
        assert abs(slope - flow.rate(guard.to, state, theta)) < mpf("1e-40")


@pytest.mark.few(2)
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("xi", [0.05, 1.0, 1.5])
def test_guards_are_monotone_between_the_points_that_separate_their_zeros(mode, xi):
    """The weight that makes a level monotone is positive: its sign changes at most once there."""
    mole = mole_of({**MANY_CONTACTS, "xi": xi, "omega": 1.3})
    flow = MODES[mode](mole, State(mpf("0.3"), mpf("0.4"), mpf("0.3"), mpf(0)), mpf("0.7"))
    for guard in flow.guards():
        high = min(guard.longest_piece, mpf(12))
        levels = guard.levels(mpf(0), high)
        constant, cosine, sine = guard.harmonic

        def last(s, c=constant, p=cosine, q=sine, guard=guard):
            theta = guard.theta0 + guard.omega * s
            return c + p * mp.cos(theta) + q * mp.sin(theta)

        points = [high * i / 400 for i in range(401)]
        counts = [sum(f(a) * f(b) < 0 for a, b in pairwise(points)) for f in [*levels, last]]
        assert all(fewer <= more + 1 for fewer, more in pairwise(counts))


# ---------------------------------------------------------------- the route of the mole


def test_first_contact_from_rest_by_taylor_integration():
    parameters = {"a": 0.3, "b": 0.15, "xi": 0.05, "omega": 0.1}
    mole = mole_of(parameters)
    run = mole_events(parameters, {}, 1)
    assert run.events[0][1:] == ("no_contact", "contact")
    impact = run.events[0][0]
    with mp.workdps(25):

        def integrate(mode, start, t0):
            return mp.odefun(
                lambda t, z: list(equations(mole, mode, z, mole.phi + mole.omega * t)), t0, start
            )

        before = integrate("no_contact", [mpf(0)] * 4, 0)(impact)
        assert abs(mole.gap(State(*before))) < mpf("1e-20")
        end = impact + mpf("0.5")
        assert run.events[1][0] > end
        after = integrate("contact", before, impact)(end)
        flow = MODES["contact"](mole, run.event_states[0], mole.phi + mole.omega * impact)
        assert all(
            abs(x - y) < mpf("1e-18") for x, y in zip(after, flow.at(end - impact), strict=True)
        )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("parameters", "initial", "n_periods"),
    [
        (MANY_CONTACTS, {}, 1),
        # a flight that ends at h' = 1e-6
        pytest.param(MANY_CONTACTS, {"y": 0.5019102324423831}, 2, marks=pytest.mark.slow),
        (DIRECT_PASSAGE, {"q": 0.3}, 2),
        (CRITICAL, {}, 2),
        (OVERDAMPED, {}, 2),
        ({"a": 0.3, "b": 0.1, "xi": 0.1, "omega": 1.6}, {}, 10),
    ],
)
def test_both_references_agree_on_the_mole(parameters, initial, n_periods):
    run = mole_events(parameters, initial, n_periods)
    mole = mole_of(parameters)
    other = hybrid_run(
        automata.mole(**{name: getattr(mole, name) for name in ("a", "b", "xi", "omega", "g")}),
        automata.mole_start(mole.phi, **initial),
        "no_contact",
        n_periods * mole.period,
    )
    assert [e[1:] for e in run.events] == [(e.mode_from, e.mode_to) for e in other.events]
    for one, two in zip(run.events, other.events, strict=True):
        assert abs(one[0] - two.time) < mpf("1e-35")
    assert run.final.mode == other.mode
    assert all(
        abs(x - y) < mpf("1e-35") for x, y in zip(run.final[:4], other.state[:4], strict=True)
    )


def test_a_passage_of_zero_duration_is_one_event():
    events = mole_events(DIRECT_PASSAGE, {}, 2).events
    assert ("no_contact", "progression") in [e[1:] for e in events]
    assert all(later[0] > earlier[0] for earlier, later in pairwise(events))


def test_starts_on_the_contact_surface():
    def start_mode(y, q):
        initial = {"p": mpf(q) + mpf(0.02), "y": y, "q": q}
        run = mole_events({**MANY_CONTACTS, "omega": 1e6}, initial, 1)
        assert not run.events
        return run.final.mode

    assert start_mode(0, 0.5) == "contact"
    assert start_mode(0, 1.5) == "progression"
    assert start_mode(0, -0.5) == "no_contact"
    with pytest.raises(ValueError, match="inadmissible"):
        mole_events(MANY_CONTACTS, {"p": 0.03}, 1)


def test_undecidable_graze_is_refused():
    """q = 0 and no forcing: p rises to y0^2 / 2 exactly, which is the gap."""
    parameters = {"a": 0, "b": -1, "xi": 0.5, "omega": 1, "g": 0.125}
    with pytest.raises(Undecidable):
        mole_events(parameters, {"y": 0.5}, 1)
    assert not mole_events(parameters, {"y": 0.5 - 1e-12}, 1).events
    hit = mole_events(parameters, {"y": 0.5 + 1e-12}, 1)
    assert hit.events[0][1:] == ("no_contact", "contact")
    assert mp.almosteq(hit.guard_rates[0], -mp.sqrt(mpf(0.5 + 1e-12) ** 2 - mpf(0.25)), 1e-40)


def test_period_counts_with_exact_pi_and_phase_with_the_double():
    run = mole_events({**DIRECT_PASSAGE, "phi": mp.pi / 2}, {}, 1)
    other = mole_events({**DIRECT_PASSAGE, "phi": math.pi / 2}, {}, 1)
    assert mpf("1e-18") < abs(run.final.y - other.final.y) < mpf("1e-13")


def test_tangent_growth_of_a_flight():
    """In flight (p, y, q) become (p + T y, y, q exp(-T/2 xi)), whatever the forcing."""
    parameters = {"a": 0.2, "b": 0.0, "xi": 0.1, "omega": 0.5}
    growth = mole_tangent_growth(parameters, {"p": -0.5}, 3)
    t = 6 * mp.pi / mpf(0.5)
    assert abs(growth.total - (t + mp.sqrt(t**2 + 4)) / 2) < 1e-8
    assert growth.worst == growth.total


def test_stored_runs_are_those_of_the_route():
    stored = json.loads(FILE.read_text(encoding="utf-8"))
    for name in ("critical", "progression graze"):
        record = stored[name]
        run = mole_events(record["parameters"], record["initial"], 2)
        events = [e for e in record["events"] if mpf(e["t"]) < 2 * mpf(record["period"])]
        assert [(text(e[0]), *e[1:]) for e in run.events] == [
            (e["t"], e["from"], e["to"]) for e in events
        ]
        assert [text(x) for x in run.final[:4]] == [record["strobes"][1][x] for x in "pyqv"]


# ---------------------------------------------------------------- linear flows


def test_exact_flow_of_a_damped_oscillator():
    zeta, t = mpf("0.01"), mpf(300)
    w = mp.sqrt(1 - zeta**2)
    x, v = exact_flow([[0, 1], [-1, -2 * zeta]], [1, 0], t)
    decay = mp.exp(-zeta * t)
    assert abs(x - decay * (mp.cos(w * t) + zeta / w * mp.sin(w * t))) < mpf("1e-48")
    assert abs(v + decay / w * mp.sin(w * t)) < mpf("1e-48")


def test_exact_flow_of_a_defective_and_a_stiff_matrix():
    position = exact_flow([[0, 1, 0], [0, 0, -1], [0, 0, 0]], [1, 2, 1], 7)[0]
    assert abs(position - (1 + 14 - mpf(49) / 2)) < mpf("1e-47")
    slow = exact_flow([[-30000, 29999], [0, -1]], [0, 1], 1)
    assert abs(slow[0] - mp.exp(-1)) < mpf("1e-48")


COSINE = [[0, 1, 0], [-1, 0, 0], [0, 0, 0]]


@pytest.mark.parametrize("library", ["flint", "mpmath alone"])
@pytest.mark.parametrize("d", ["0.5", "1", "1e-4", "1e-20"])
def test_cosine_crosses_one_less_d(d, library, monkeypatch):
    use(library, monkeypatch)
    level = 1 - mpf(d)
    time, gap = first_crossing(COSINE, [1, 0, 1], [1, 0, -level], 5)
    assert abs(time - mp.acos(level)) < mpf("1e-38")
    assert abs(gap - min(mpf(d), 2 - mpf(d))) < mpf("1e-48")  # stationary points at 0 and pi


@pytest.mark.parametrize("library", ["flint", "mpmath alone"])
@pytest.mark.parametrize("d", ["1e-3", "1e-10", "1e-20"])
def test_near_tangency_of_either_kind(d, library, monkeypatch):
    """1 - d + cos t: below zero around pi for 0 < d, above throughout for d < 0."""
    use(library, monkeypatch)
    for depth in (mpf(d), -mpf(d)):
        time, gap = first_crossing(COSINE, [1, 0, 1], [1, 0, 1 - depth], 20)
        assert abs(gap - mpf(d)) < mpf("1e-48")
        if depth < 0:
            assert time is None
        else:
            assert abs(time - mp.acos(depth - 1)) < mpf("1e-38")


def use(library, monkeypatch):
    if library == "flint":
        pytest.importorskip("flint", reason="balls.py has a substitute, tested by the other case")
    else:
        monkeypatch.setattr(balls, "flint", None)


def test_first_crossing_at_a_start_with_zeros():
    never, touching = first_crossing(COSINE, [1, 0, 1], [-1, 0, 1], 10)  # 1 - cos t
    assert never is None
    assert touching < mpf("1e-60")
    assert first_crossing(COSINE, [1, 0, 1], [1, 0, -1], 10).time == 0  # cos t - 1
    sine = first_crossing(COSINE, [1, 0, 1], [0, -1, 0], 10)  # sin t
    assert abs(sine.time - mp.pi) < mpf("1e-49")
    assert abs(sine.gap - 1) < mpf("1e-49")
    nothing = first_crossing(COSINE, [1, 0, 1], [0, 0, 0], 10)
    assert nothing.time is None
    assert first_crossing(COSINE, [1, 0, 1], [0, 0, -1], 10).time == 0


def test_cubic_tangency_is_a_crossing():
    """g = (1 - s)^3, with a triple zero at 1."""
    chain = [[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]]
    time, gap = first_crossing(chain, [1, -3, 6, -6], [1, 0, 0, 0], 3)
    assert abs(time - 1) < mpf("1e-15")  # a triple zero keeps a third of the digits
    assert gap < mpf("1e-40")


# ---------------------------------------------------------------- automata


def test_bouncing_ball():
    r, modes = (
        mpf("0.5"),
        {
            "free": LinearMode(
                [[0, 1, 0], [0, 0, -1], [0, 0, 0]],
                [LinearExit([1, 0, 0], "free", [[0, 0, 0], [0, "-0.5", 0], [0, 0, 1]])],
            )
        },
    )
    fall = mp.sqrt(2)
    times = [fall * (1 + 2 * sum(r**j for j in range(1, k + 1))) for k in range(20)]
    run = hybrid_run(modes, [1, 0, 1], "free", times[-1] + r**25)
    assert len(run.events) == 20
    for k, (event, time) in enumerate(zip(run.events, times, strict=True)):
        assert abs(event.time - time) < mpf("1e-40")
        assert abs(event.after[1] - fall * r ** (k + 1)) < mpf("1e-40")


def test_rigid_impact_without_forcing():
    r = mpf("0.8")
    modes = automata.rigid_impact(F=0, omega=1, zeta=0, sigma=0, r=r)
    run = hybrid_run(modes, automata.oscillator_start(-1, 0), "free", 20)
    for k, event in enumerate(run.events):
        assert abs(event.time - mp.pi * (k + mpf(1) / 2)) < mpf("1e-45")
        assert abs(event.after[1] + r ** (k + 1)) < mpf("1e-45")


def test_soft_impact_without_forcing():
    """Half a period of each oscillator in turn."""
    modes = automata.soft_impact(a=0, omega=1, zeta=0, e=0, beta=29)
    run = hybrid_run(modes, automata.oscillator_start(-1, 0), "free", 20)
    stays = [later.time - earlier.time for earlier, later in pairwise(run.events)]
    assert [e.mode_to for e in run.events[:2]] == ["contact", "free"]
    for k, stay in enumerate(stays):
        assert abs(stay - mp.pi / (1 if k % 2 else mp.sqrt(30))) < mpf("1e-40")


def test_forced_rigid_impact_by_taylor_integration():
    F, w, zeta, sigma, r = (mpf(x) for x in ("1", "2.8", "0.1", "0", "0.8"))
    modes = automata.rigid_impact(F=F, omega=w, zeta=zeta, sigma=sigma, r=r)
    run = hybrid_run(modes, automata.oscillator_start("-0.3", "0.1"), "free", 4)
    time, state = mpf(0), [mpf("-0.3"), mpf("0.1")]
    assert len(run.events) > 1
    with mp.workdps(25):
        for event in run.events[:2]:
            path = mp.odefun(
                lambda t, z: [z[1], F * mp.cos(w * t) - 2 * zeta * z[1] - z[0]], time, state
            )
            x, v = path(event.time)
            assert abs(x - sigma) < mpf("1e-20")
            time, state = event.time, [sigma, -r * v]
            assert abs(event.after[1] - state[1]) < mpf("1e-20")


def test_modes_that_send_each_other_back_are_an_error():
    down = [[0, -1], [0, 0]]
    modes = {
        "a": LinearMode(down, [LinearExit([1, 0], "b")]),
        "b": LinearMode(down, [LinearExit([1, 0], "a")]),
    }
    with pytest.raises(RuntimeError, match="no mode holds"):
        hybrid_run(modes, [1, 1], "a", 2)
