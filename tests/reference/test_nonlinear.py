"""The route for systems that are not linear against closed forms and other routes."""

import json
from itertools import chain

import pytest
from mpmath import mp, mpf

from . import automata
from .differences import derivatives
from .hybrid import hybrid_run
from .make_tangent_runs import FILE, run_of, text
from .nonlinear import DIGITS, SmoothExit, SmoothMode, SmoothModel, smooth_run
from .nonlinear_models import CASES, Case
from .power_series import sin
from .roots import Undecidable

QUICK = ["bilinear", "rigid impact", "vibrating table"]
EXACT = mpf("1e-38")


@pytest.fixture(autouse=True)
def many_digits():
    with mp.workdps(DIGITS):
        yield


def near(found, expected, tolerance=EXACT):
    return all(abs(a - b) < tolerance for a, b in zip(found, expected, strict=True))


# ---------------------------------------------------------------- runs


def test_pendulum_in_elliptic_functions():
    """sin(angle/2) = k sn(t + K, k) from rest at the angle 2 asin(k)."""
    k = mpf("0.8")
    model = SmoothModel(["angle", "speed"], {"m": SmoothMode(lambda t, z, p: [z[1], -sin(z[0])])})
    times = [mpf(1), mpf("2.5"), mpf(7)]
    run = smooth_run(model, {}, [2 * mp.asin(k), 0], "m", times)
    for t, (angle, speed) in zip(times, run.samples, strict=True):
        u = t + mp.ellipk(k**2)
        assert abs(mp.sin(angle / 2) - k * mp.ellipfun("sn", u, m=k**2)) < EXACT
        assert abs(speed - 2 * k * mp.ellipfun("cn", u, m=k**2)) < EXACT


def bouncing_ball(r):
    """Height and speed; at the floor the ball keeps the share r of its speed."""
    rebound = SmoothExit(lambda t, z, p: z[0], "free", lambda t, z, p: [z[0], -p.r * z[1]])
    free = SmoothMode(lambda t, z, p: [z[1], -1], [rebound])
    return Case(SmoothModel(["h", "w"], {"free": free}), {"r": r}, [1, 0], "free", [2, 4])


def test_bouncing_ball():
    r, fall = mpf("0.75"), mp.sqrt(2)
    run = run_of(bouncing_ball(r))
    times = [fall, fall * (1 + 2 * r)]
    assert near([e.time for e in run.events], times)
    assert near([e.rate for e in run.events], [-fall, -fall * r])
    assert near([e.after[1] for e in run.events], [fall * r, fall * r**2])


LINEAR = {
    "rigid impact": (automata.rigid_impact, lambda p, z: automata.oscillator_start(*z)),
    "bilinear": (automata.soft_impact, lambda p, z: automata.oscillator_start(*z)),
    "mole": (
        lambda phi, **p: automata.mole(**p),
        lambda p, z: automata.mole_start(p["phi"], *z),
    ),
}


@pytest.mark.few(1)
@pytest.mark.parametrize("name", LINEAR)
def test_linear_automata_agree(name):
    case = CASES[name]
    automaton, start = LINEAR[name]
    modes, z0 = automaton(**case.parameters), start(case.parameters, case.start)
    other = hybrid_run(modes, z0, case.mode, case.times[-1])
    run = run_of(case)
    assert [e.path for e in run.events] == [e.path for e in other.events]
    assert near([e.time for e in run.events], [e.time for e in other.events])
    assert near(run.samples[-1], other.state[: len(case.start)])
    assert run.modes[-1] == other.mode


ROTOR = pytest.param("rotor", marks=pytest.mark.slow)  # whose series have the most terms


@pytest.mark.few(1)
@pytest.mark.parametrize("name", [ROTOR, "pendulum", "ramp", "curved mole"])
def test_first_stretches_by_another_integrator(name):
    """mpmath's own integrator from the start, and from the first event, to 20 digits."""
    case = CASES[name]
    run = smooth_run(case.model, case.parameters, case.start, case.mode, [2.0, 2.5])
    with mp.workdps(25):
        p = _Words(case.parameters)
        event = run.events[0]
        before = _odefun(case, case.mode, p, 0, case.start)(event.time)
        assert near(before, event.before, mpf("1e-20"))
        words = case.model.modes[case.mode]
        guard, rates = words.exits[event.path[0][1]].guard, words.rates(event.time, before, p)
        assert abs(guard(event.time, before, p)) < mpf("1e-20")
        slope = mp.diff(lambda s: guard(event.time + s, along(before, rates, s), p), 0)
        assert abs(slope - event.rate) < mpf("1e-12")
        next_time = 2.0 if event.time < 2 else 2.5
        after = _odefun(case, event.mode_to, p, event.time, event.after)(mpf(next_time))
        expected = run.samples[[2.0, 2.5].index(next_time)]
        free = [i for i in range(len(after)) if i not in case.model.modes[event.mode_to].slaved]
        assert near([after[i] for i in free], [expected[i] for i in free], mpf("1e-20"))


def along(z, rates, s):
    return [x + s * rate for x, rate in zip(z, rates, strict=True)]


class _Words:
    def __init__(self, parameters):
        self.__dict__.update({k: mpf(x) for k, x in parameters.items()})


def _odefun(case, mode, p, t0, start):
    rates = case.model.modes[mode].rates
    return mp.odefun(lambda t, z: rates(t, z, p), mpf(t0), [mpf(x) for x in start])


@pytest.mark.few(2)
@pytest.mark.parametrize("name", [ROTOR, *(name for name in CASES if name != "rotor")])
def test_order_and_tolerance_do_not_matter(name):
    case = CASES[name]
    words = (case.model, case.parameters, case.start, case.mode, case.times[:4])
    one, other = smooth_run(*words), smooth_run(*words, order=37, tolerance=mpf("1e-41"))
    assert one.events
    for a, b in zip(one.samples, other.samples, strict=True):
        assert near(a, b, mpf("1e-35"))


def test_a_graze_is_refused():
    """The height falls to 0 exactly, with a speed of 0."""
    fall = SmoothMode(lambda t, z, p: [z[1], 1], [SmoothExit(lambda t, z, p: z[0], "gone")])
    model = SmoothModel(["h", "w"], {"m": fall, "gone": fall._replace(exits=[])})
    with pytest.raises(Undecidable):
        smooth_run(model, {}, [mpf("0.5"), -1], "m", [2])
    assert not smooth_run(model, {}, [mpf("0.5") + mpf("1e-12"), -1], "m", [2]).events
    (hit,) = smooth_run(model, {}, [mpf("0.5") - mpf("1e-12"), -1], "m", [1]).events
    assert abs(hit.rate + mp.sqrt(mpf("2e-12"))) < mpf("1e-20")


# ---------------------------------------------------------------- derivatives


def test_derivatives_of_a_bouncing_ball():
    """h(t) after one rebound in closed form: h0 enters the time of the impact as well."""
    r = mpf("0.75")
    case = bouncing_ball(r)._replace(times=[2])
    found = derivatives(case, [0, 1], ["r"])

    def height(h0, w0, r):
        hit = w0 + mp.sqrt(w0**2 + 2 * h0)
        speed = r * (hit - w0)
        return speed * (2 - hit) - (2 - hit) ** 2 / 2

    expected = [mp.diff(height, (1, 0, r), n) for n in ((1, 0, 0), (0, 1, 0))]
    assert near(found.tangent[0][0], expected, mpf("1e-22"))
    assert abs(found.sensitivity[0][0][0] - mp.diff(height, (1, 0, r), (0, 0, 1))) < mpf("1e-22")


STORED = json.loads(FILE.read_text(encoding="utf-8"))


@pytest.mark.few(1)
@pytest.mark.parametrize("name", CASES)
def test_stored_runs_are_those_of_the_route(name):
    case, stored = CASES[name], STORED[name]
    assert stored["parameters"] == case.parameters
    assert (stored["start"], stored["times"]) == (case.start, case.times)
    run = run_of(case)
    assert [text(e.time) for e in run.events] == [e["t"] for e in stored["events"]]
    assert [list(map(text, row)) for row in run.samples] == stored["samples"]


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [*QUICK, *(pytest.param(n, marks=pytest.mark.slow) for n in CASES if n not in QUICK)]
)
def test_stored_derivatives_are_those_of_the_route(name):
    case, stored = CASES[name], STORED[name]
    found = derivatives(case, range(len(case.start)), list(case.parameters))
    for words, numbers in (
        (stored["tangent"], found.tangent),
        (stored["sensitivity"], found.sensitivity),
    ):
        for rows, expected in zip(words, numbers, strict=True):
            assert near(map(mpf, chain(*rows)), chain(*expected), mpf("1e-15"))


@pytest.mark.parametrize("name", CASES)
def test_determinants(name):
    """Divergence of the flow, and what the impacts of each kind take."""
    case, stored = CASES[name], STORED[name]
    for k, t in enumerate(case.times):
        events = [e for e in stored["events"] if mpf(e["t"]) < t]
        found = mp.det(mp.matrix([list(map(mpf, row)) for row in stored["tangent"][k]]))
        expected = DETERMINANTS[name](_Words(case.parameters), t, events)
        assert abs(found - expected) < mpf("1e-12"), k


def pendulum_determinant(p, t, events):
    """An impact multiplies by s+/s- and by its derivative, s the speed relative to the wall."""
    product = mp.exp(-p.c * t)
    for event in events:
        angle, w = map(mpf, event["before"])
        s = p.L * mp.cos(angle) * w - p.D * p.nu * mp.cos(p.nu * mpf(event["t"]))
        product *= p.e0**2 / (1 + p.e1 * p.e0 * s) ** 3
    return product


def ramp_determinant(p, t, events):
    product = mp.exp(-p.c * t)
    for event in events:
        product *= (p.h * mp.exp(-(mpf(event["before"][0]) ** 2))) ** 2
    return product


def mole_determinant(p, t, events):
    return mp.exp(-t / (2 * p.xi)) if not events else 0


def curved_mole_determinant(p, t, events):
    """What contact takes is a whole dimension."""
    assert events
    return 0


DETERMINANTS = {
    "curved mole": curved_mole_determinant,
    "bilinear": lambda p, t, events: mp.exp(-2 * p.zeta * t),
    "rigid impact": lambda p, t, events: p.r ** (2 * len(events)) * mp.exp(-2 * p.zeta * t),
    "vibrating table": lambda p, t, events: p.r ** (2 * len(events)),
    "mole": mole_determinant,
    "rotor": lambda p, t, events: mp.exp(-4 * p.zeta * t),
    "pendulum": pendulum_determinant,
    "ramp": ramp_determinant,
}
