"""The impact oscillator: closed forms of its orbits, and chatter one by one in 40 digits."""

import numpy as np
import pytest
from mpmath import matrix, mp, mpf

import nonsmooth as ns
from models.rebounds import Instant, of_rounding, of_the_end, rebounds
from nonsmooth.models import impact_oscillator
from periodic_orbits.references.rigid_wall import RigidWall

EPS = np.finfo(float).eps

# omega, zeta, sigma, r, n, F, which of the two orbits (0: the faster one)
ORBITS = [
    (2.0, 0.02, 0.0, 0.8, 1, 1.0, 0),
    (2.5, 0.0, 0.0, 0.8, 1, 1.0, 0),
    (2.8, 0.02, 0.1, 0.8, 2, 0.3, 1),
    (5.6, 0.02, 0.1, 0.8, 3, 1.0, 0),
    (2.8, 0.02, -0.1, 0.5, 1, 1.0, 0),
]


def named(run, name):
    return run["event_time"].values[run["event_name"].values == name]


def special(branch, kind):
    """Forces at the special points of a kind."""
    kinds = branch["special_kind"].values.astype(str)
    return branch["special_value"].values[kinds == kind]


@pytest.mark.parametrize(("omega", "zeta", "sigma", "r", "n", "F", "which"), ORBITS)
def test_one_impact_in_n_periods(omega, zeta, sigma, r, n, F, which):
    words = {"omega": omega, "zeta": zeta, "sigma": sigma, "r": r}
    wall = RigidWall.of(**words, n=n)
    speed = wall.speeds(F)[which]
    assert wall.clearance(speed, 100) > 1e-3  # it is a motion
    orbit = ns.find_orbit(impact_oscillator(F=F, **words), wall.start(speed), period=n)
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    for name, value in wall.start(speed).items():
        assert abs(float(orbit[name]) - value) < 1e-10
    exact = [complex(m) for m in wall.multipliers(speed)]
    found = orbit["multipliers"].values
    # a pair of complex conjugates has either first
    assert min(np.abs(found - exact).max(), np.abs(found - exact[::-1]).max()) < 1e-8
    assert bool(orbit["stable"]) == (abs(exact[0]) < 1)
    log = 2 * np.log(r) - 2 * zeta * float(wall.span)
    assert abs(float(orbit["log_determinant"]) - log) < 1e-12 * max(1.0, abs(log))


@pytest.mark.parametrize("kind", ["fold", "flip"])
def test_stability_limits(kind):
    """Folds are where the force is least, flips where 1 + trace + determinant vanishes."""
    words = {"omega": 2.8, "zeta": 0.02, "sigma": 0.1, "r": 0.8}
    wall = RigidWall.of(**words, n=2)
    system = impact_oscillator(F=0.3, **words)
    orbit = ns.find_orbit(system, wall.start(wall.speeds(0.3)[0]), period=2)
    # on the flip's side only up to it: beyond, the orbit touches the wall between its impacts
    exact = float(wall.force(wall.fold_speed if kind == "fold" else wall.flip_speed))
    ends = (0.05, 0.35) if kind == "fold" else (0.25, 1.05 * exact)
    branch = ns.continue_orbit(system, "F", ends, initial=orbit)
    assert np.abs(special(branch, kind) - exact).min() < 1e-10


@pytest.mark.parametrize(("omega", "r"), [(2.5, 0.8), (1.7, 0.6)])
def test_trace_without_damping_and_gap(omega, r):
    wall = RigidWall.of(omega=omega, zeta=0.0, sigma=0.0, r=r)
    start = wall.start(wall.speeds(1.0)[0])
    system = impact_oscillator(omega=omega, zeta=0.0, r=r)
    run = ns.simulate(system, start, periods=1, tangent=True)
    tangent = run["tangent"].values[-1]
    span = 2 * np.pi / omega
    trace = -2 * r * np.cos(span) + (1 + r) ** 2 * (1 - omega**2) * (1 + np.cos(span)) / 2
    assert named(run, "impact").size == 1
    assert abs(np.trace(tangent) - trace) < 1e-10
    assert abs(np.linalg.det(tangent) - r**2) < 1e-10


def test_areas_shrink_by_damping_and_by_each_impact():
    zeta, r = 0.03, 0.7
    system = impact_oscillator(zeta=zeta, r=r, sigma=0.2)
    run = ns.simulate(system, {"x": -0.4, "v": 0.3}, periods=6, samples_per_period=1, tangent=True)
    hits = named(run, "impact")
    assert hits.size > 4
    for time, tangent in zip(run["time"].values, run["tangent"].values, strict=True):
        exact = r ** (2 * np.sum(hits < time)) * np.exp(-2 * zeta * time)
        # the determinant is a difference of products of entries, each off by some roundings
        assert abs(np.linalg.det(tangent) - exact) < 200 * EPS * np.abs(tangent).max() ** 2


@pytest.mark.parametrize(("omega", "zeta", "sigma"), [(0.8, 0.05, 0.5), (2.8, 0.02, 0.1)])
def test_grazing_force(omega, zeta, sigma):
    """Below, the linear response is a motion; from above, impacts cease there."""
    exact = sigma * np.sqrt((1 - omega**2) ** 2 + 4 * zeta**2 * omega**2)
    for factor, touches in ((1 - 1e-10, False), (1 + 1e-10, True)):
        force = exact * factor
        response = force / (1 - omega**2 + 2j * zeta * omega)
        start = {"x": response.real, "v": (1j * omega * response).real}
        system = impact_oscillator(omega=omega, zeta=zeta, sigma=sigma, F=force)
        run = ns.simulate(system, start, periods=1)
        assert (named(run, "impact").size > 0) == touches


def test_grazing_on_a_branch():
    system = impact_oscillator(omega=0.8, zeta=0.05, sigma=0.5, r=0.7, F=0.1)
    exact = 0.5 * np.sqrt((1 - 0.8**2) ** 2 + 4 * 0.05**2 * 0.8**2)
    branch = ns.continue_orbit(system, "F", (0.05, 0.3))
    assert np.abs(special(branch, "grazing") - exact).min() < 1e-10


# ---------------------------------------------------------------- chatter, stick, release


def chatter(omega, zeta, r, sigma, forced=1.0):
    """Impacts from the release on, in 40 digits; the wall at a distance below ``forced``."""
    with mp.workdps(40):
        w, z, wall, force = mpf(omega), mpf(zeta), mpf(sigma), mpf(forced)
        own = mp.sqrt(1 - z**2)
        steady = force / (1 - w**2 + 2j * z * w)

        def flight(began, rate):
            def drive(t):
                turned = steady * mp.expj(w * t)
                return turned.real, (1j * w * turned).real

            x0, v0 = drive(began)
            start = matrix([wall - x0, -rate - v0])

            def motion(t):
                c, s = mp.cos(own * (t - began)), mp.sin(own * (t - began))
                free = matrix([[c + z / own * s, s / own], [-s / own, c - z / own * s]])
                x, v = mp.exp(-z * (t - began)) * free * start
                xd, vd = drive(t)
                x, v = x + xd, v + vd
                return Instant(wall - x, -v, x + 2 * z * v - force * mp.cos(w * t))

            return motion

        return flight, float(mp.acos(wall / force) / w)


SLOW = [(0.3, 0.0, 0.8, 0.0), (0.3, 0.02, 0.8, 0.0), (0.2, 0.05, 0.5, 0.3), (0.3, 0.1, 0.6, -0.2)]


@pytest.mark.few(1)
@pytest.mark.parametrize(("omega", "zeta", "r", "sigma"), SLOW)
def test_chatter_ends_at_the_wall_and_the_force_releases(omega, zeta, r, sigma):
    words = {"omega": omega, "zeta": zeta, "r": r, "sigma": sigma}
    flight, released = chatter(**words)
    system = impact_oscillator(**words)
    period = system.period_value
    # pushed by the force, the mass is at rest at the wall from phase 0 on
    run = ns.simulate(system, {"x": sigma, "v": 0.0}, periods=3)
    assert run.attrs["status"] == "completed"
    releases = named(run, "release")
    assert releases.size == 3
    assert np.abs(releases - released - period * np.arange(3)).max() < 1e-12 * 3 * period
    with mp.workdps(40):
        lifted = flight(mpf(released), mpf(0))
        # left at rest: the gap opens with the third power of time
        first = mp.findroot(lambda t: lifted(t).gap, float(named(run, "impact")[0]), tol=1e-60)
        rate = -mpf(r) * lifted(first).rate
    times, over = rebounds(flight, first, rate, r)
    times = [float(first), *times]
    kinds = run["event_kind"].values.astype(str)
    ended = run["event_time"].values[kinds == "chatter"]
    alone = (kinds == "impact") & (run["event_time"].values < ended[0])
    single = run["event_time"].values[alone]
    speeds = -run["guard_rate"].values[alone]
    assert single.size > 8
    assert np.all(np.abs(single - times[: single.size]) < of_rounding(speeds))
    assert abs(ended[0] - over) < min(1e-10 * over, of_the_end(speeds, r, period))
    assert np.abs(np.diff(ended) - period).max() < 1e-12 * 3 * period


@pytest.mark.parametrize(("omega", "zeta", "r", "sigma"), SLOW)
def test_a_motion_that_sticks_forgets_its_start(omega, zeta, r, sigma):
    """Superstable: whatever the start, one motion from the first release on, and a tangent 0."""
    system = impact_oscillator(omega=omega, zeta=zeta, r=r, sigma=sigma)
    period = system.period_value
    times = 4 * period + period * np.linspace(0, 2, 41)
    one = ns.simulate(system, {"x": sigma - 0.3, "v": 0.2}, times=times, tangent=True)
    two = ns.simulate(system, {"x": sigma - 1.0, "v": -0.4}, times=times)
    assert "stuck" in one.attrs["phase_word"] and "stuck" in two.attrs["phase_word"]
    for name in "xv":
        values = one[name].values
        # a rounding of a time near 6 periods, by speeds and accelerations of order 1
        allowed = 32 * EPS * 6 * period
        assert np.abs(values - two[name].values).max() < allowed
        assert np.abs(values[20:] - values[:21]).max() < allowed
    assert np.abs(one["tangent"].values).max() == 0.0


def test_the_wall_pushes_with_what_the_spring_leaves_of_the_force():
    system = impact_oscillator(omega=0.3, sigma=0.2)
    run = ns.simulate(system, {"x": 0.2}, periods=2, samples_per_period=400)
    stuck = np.array([name == "stuck" for name in modes(run)])
    force = np.cos(0.3 * run["time"].values) - 0.2
    assert stuck.sum() > 30
    assert np.abs(run["wall_force"].values[stuck] - force[stuck]).max() < 1e-13
    assert run["wall_force"].values.min() >= -1e-13
    assert np.all(run["wall_force"].values[~stuck] == 0.0)
    assert np.all(run["x"].values[stuck] == 0.2) and np.all(run["v"].values[stuck] == 0.0)


def modes(run):
    names = run["mode"].attrs["flag_meanings"].split()
    return [names[int(m)] for m in run["mode"].values]


@pytest.mark.parametrize(
    ("argument", "value"), [("omega", 0.0), ("zeta", -0.1), ("r", -0.1), ("r", 1.1)]
)
def test_impossible_parameters_are_refused(argument, value):
    with pytest.raises(ns.ModelError, match=f"{argument} [<>]"):
        impact_oscillator(**{argument: value})
