"""The brake model against its eigenvalues, its flutter limit, and hand-written modes."""

import numpy as np
import pytest
from mpmath import mp

import nonsmooth as ns
from models.friction_truth import Leg, followed
from nonsmooth.models import brake_mode_coupling

EPS = np.finfo(float).eps
PLAIN = {"k_x": 2.0, "k_y": 2.0, "k_xy": 1.0, "k_n": 4 / 3, "zeta_x": 0.0, "zeta_y": 0.0}
CASES = [
    PLAIN,
    {**PLAIN, "zeta_x": 0.02, "zeta_y": 0.02},
    {"k_x": 2.5, "k_y": 1.8, "k_xy": 0.6, "k_n": 1.1, "zeta_x": 0.03, "zeta_y": 0.02},
    {"k_x": 2.5, "k_y": 1.8, "k_xy": 0.6, "k_n": 1.1, "zeta_x": 0.001, "zeta_y": 0.1},
]


def flutter_limit(**words):
    """From the docstring of the model, as exact as the working precision."""
    k_x, k_y, k_xy, k_n, zeta_x, zeta_y = (mp.mpf(words[name]) for name in PLAIN)
    a3 = 2 * zeta_x + 2 * zeta_y
    if a3 == 0:
        return ((k_x - k_y) ** 2 + 4 * k_xy**2) / (4 * k_xy * k_n)
    a2 = k_x + k_y + 4 * zeta_x * zeta_y
    a1 = 2 * zeta_x * k_y + 2 * zeta_y * k_x
    return (a1 * (a3 * a2 - a1) / a3**2 - k_x * k_y + k_xy**2) / (k_xy * k_n)


def sliding(mu, k_x, k_y, k_xy, k_n, zeta_x, zeta_y) -> list[list]:
    """Matrix of the rates of x, y, x', y' in steady sliding."""
    return [
        [0, 0, 1, 0],
        [0, 0, 0, 1],
        [-k_x, mu * k_n - k_xy, -2 * zeta_x, 0],
        [-k_xy, -k_y, 0, -2 * zeta_y],
    ]


def growth(mu, **words):
    """Largest real part of the eigenvalues, in the working precision."""
    return max(mp.re(z) for z in mp.eig(mp.matrix(sliding(mu, **words)), right=False))


@pytest.mark.parametrize("words", CASES)
def test_flutter_limit_by_eigenvalues(words):
    with mp.workdps(50):
        words = {name: mp.mpf(value) for name, value in words.items()}
        limit, little = flutter_limit(**words), mp.mpf("1e-12")
        if words["zeta_x"]:
            assert abs(growth(limit, **words)) < 1e-40
            assert growth(limit - little, **words) < -1e-15
            assert growth(limit + little, **words) > 1e-15
        else:  # two pairs meet on the axis and leave it by the root of the distance
            assert abs(growth(limit - little, **words)) < 1e-40
            assert abs(growth(limit, **words)) < 1e-20
            assert growth(limit + little, **words) > 1e-8


def test_uneven_damping_lowers_the_limit():
    assert float(flutter_limit(**PLAIN)) == pytest.approx(0.75)
    undamped = flutter_limit(**CASES[2] | {"zeta_x": 0, "zeta_y": 0})
    assert flutter_limit(**CASES[3]) < 0.8 * undamped < undamped < flutter_limit(**CASES[2])


@pytest.mark.parametrize("words", CASES)
@pytest.mark.parametrize("beyond", [-0.2, 0.2])
def test_small_motions_grow_as_the_eigenvalues_say(words, beyond):
    """The share of a mode, read by a left eigenvector, goes with exp(lambda t) exactly."""
    mu = float(flutter_limit(**words)) * (1 + beyond)
    system = brake_mode_coupling(mu=mu, **words)
    run = ns.simulate(system, {"x": 1e-5, "y": 2e-5}, t_end=40)
    assert run.attrs["n_events"] == 0
    states = np.array([run[name].values for name in ("x", "y", "vx", "vy")])
    values, left = np.linalg.eig(np.transpose(sliding(mu, **words)))
    for value, row in zip(values, left.T, strict=True):
        share = row @ states
        exact = share[0] * np.exp(value * run["time"].values)
        assert np.abs(share - exact).max() < 1e-10 * np.abs(states).max()
    assert (values.real.max() > 1e-3) == (beyond > 0)


@pytest.mark.parametrize("words", CASES)
def test_the_exponent_changes_its_sign_at_the_limit(words):
    """By tangents of the run, for the motion is linear until something switches."""
    limit = float(flutter_limit(**words))
    for mu, grows in ((limit * 0.95, False), (limit * 1.05, True)):
        system = brake_mode_coupling(mu=mu, **words)
        run = ns.simulate(
            system, dict.fromkeys(("x", "y", "vx", "vy"), 0.0), times=[0.0, 100.0], tangent=True
        )
        values = np.linalg.eigvals(run["tangent"].values[-1])
        exact = float(growth(mu, **words))
        assert np.log(np.abs(values).max()) / 100 == pytest.approx(exact, abs=1e-10)
        assert (exact > 1e-6) == grows


def by_hand(mu, v_b, N0, k_x, k_y, k_xy, k_n, zeta_x, zeta_y) -> dict[str, Leg]:
    """Modes with the pad held by hand where friction can hold it."""

    def normal(z):
        return N0 + k_n * z[1]

    def held(z):
        """Friction that keeps the velocity of the disc."""
        return mu * N0 + 2 * zeta_x * v_b + k_x * z[0] + k_xy * z[1]

    def rates(friction, touching):
        def of(t, z):
            N = normal(z) if touching else 0.0
            return [
                z[2],
                z[3],
                friction(z) - mu * N0 - 2 * zeta_x * z[2] - k_x * z[0] - k_xy * z[1],
                N0 + k_n * z[1] - N - 2 * zeta_y * z[3] - k_y * z[1] - k_xy * z[0],
            ]

        return of

    def to(name):
        return lambda t, z: (name, z)

    def at_speed(t, z):
        z = np.array([z[0], z[1], v_b, z[3]])
        if abs(held(z)) <= mu * normal(z):
            return "stick", z
        return ("slip" if held(z) > 0 else "ahead"), z

    def landed(t, z):
        return ("slip" if z[2] < v_b else "ahead"), z

    away = (lambda t, z: normal(z), to("apart"))
    return {
        "slip": Leg(
            rates(lambda z: mu * normal(z), True), [(lambda t, z: v_b - z[2], at_speed), away]
        ),
        "ahead": Leg(
            rates(lambda z: -mu * normal(z), True), [(lambda t, z: z[2] - v_b, at_speed), away]
        ),
        "stick": Leg(
            rates(held, True),
            [
                (lambda t, z: mu * normal(z) - held(z), to("slip")),
                (lambda t, z: mu * normal(z) + held(z), to("ahead")),
            ],
        ),
        "apart": Leg(rates(lambda z: 0.0, False), [(lambda t, z: -normal(z), landed)]),
    }


SQUEAL = {**PLAIN, "mu": 1.0, "zeta_x": 0.05, "zeta_y": 0.05}


@pytest.mark.few(1)
@pytest.mark.parametrize(("v_b", "N0", "vx", "cells"), [
    (0.3, 4.0, 0.0, {"slip", "stick"}), (0.9, 1.0, 0.0, {"slip", "apart"}),
    (0.3, 1.0, 0.0, {"slip", "stick", "apart"}),
    (0.3, 2.0, 1.5, {"ahead", "slip", "stick"})])  # fmt: skip
def test_grown_motions_by_hand_written_modes(v_b, N0, vx, cells):
    times = np.linspace(0, 60, 601)
    start = [0.3, 0.1, vx, 0.0]
    run = ns.simulate(
        brake_mode_coupling(**SQUEAL, v_b=v_b, N0=N0),
        dict(zip(("x", "y", "vx", "vy"), start, strict=True)),
        times=times,
    )
    first = "ahead" if vx > v_b else "slip"
    states, log = followed(by_hand(**SQUEAL, v_b=v_b, N0=N0), first, start, times)
    assert run.attrs["status"] == "completed"
    assert set(ns.phase_word(run)) >= cells
    for name, exact in zip(("x", "y", "vx", "vy"), states.T, strict=True):
        assert np.abs(run[name].values - exact).max() < 1e-9
    late = [time for name, time in log if name == "slip"]
    assert len(late) > 3


def test_forces_in_stick_and_apart():
    run = ns.simulate(brake_mode_coupling(**SQUEAL, v_b=0.3), times=np.linspace(0, 300, 20001))
    names = run["mode"].attrs["flag_meanings"].split()
    mode = np.array(names)[run["mode"].values]
    x, y, N, friction = (run[name].values for name in ("x", "y", "normal_force", "friction"))
    stuck, apart = mode == "stick", mode == "apart"
    assert stuck.sum() > 50 and apart.sum() > 50
    assert np.all(run["slip_velocity"].values[stuck] == 0.0)
    held = 1.0 + 2 * 0.05 * 0.3 + 2 * x + y
    assert friction[stuck] == pytest.approx(held[stuck], abs=1e-13)
    assert np.all(np.abs(friction) <= N + 1e-13)
    assert np.all(N[apart] == 0.0) and np.all(friction[apart] == 0.0)
    assert np.all(N >= 0.0) and N[~apart] == pytest.approx((1 + 4 / 3 * y)[~apart], abs=1e-14)


@pytest.mark.parametrize(("words", "message"), [
    ({"mu": -1}, "mu >= 0"), ({"v_b": 0}, "v_b > 0"), ({"N0": 0}, "N0 > 0"),
    ({"k_n": 3}, "k_y >= k_n"), ({"k_xy": 1.5}, "k_xy"),
    ({"zeta_x": -1}, "zeta_x >= 0")])  # fmt: skip
def test_impossible_parameters_are_refused(words, message):
    with pytest.raises(ns.ModelError, match=message):
        brake_mode_coupling(**words)
