"""Responses and root loci against closed forms, and against an integration of the equations."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.structures import (
    Beam,
    Bearing,
    Disc,
    frequency_response,
    root_locus,
    shaft,
    static_deflection,
    unbalance_response,
)

SPEEDS = np.linspace(5.0, 400.0, 40)


def disc(kx, ky, *, m=5.0, c=120.0, cross=0.0):
    """A mass that whirls, on springs which may differ and couple."""
    return ns.Structure(
        m * np.eye(2),
        [[kx, cross], [-cross, ky]],
        damping=c * np.eye(2),
        coordinates=["node 1 x", "node 1 y"],
    )


def test_unbalance_of_the_jeffcott_rotor():
    """Forward circle u w^2/(k - m w^2 + i c w) exp(i phase), and no backward one."""
    found = unbalance_response(disc(2e5, 2e5), SPEEDS, [(1, 3e-4, 0.7)])
    exact = 3e-4 * SPEEDS**2 / (2e5 - 5.0 * SPEEDS**2 + 120j * SPEEDS) * np.exp(0.7j)
    np.testing.assert_allclose(found["forward"].sel(node="node 1"), exact, rtol=1e-13)
    assert np.abs(found["backward"]).max() < 1e-16 * np.abs(exact).max() * 10
    np.testing.assert_allclose(
        found["amplitude"].sel(coordinate="node 1 y"), np.abs(exact), rtol=1e-13
    )
    # at the undamped critical speed the displacement lags by a quarter of a turn
    lag = unbalance_response(disc(2e5, 2e5), [200.0], (1, 3e-4))["phase"].values[0]
    np.testing.assert_allclose(lag, [-math.pi / 2, -math.pi], rtol=1e-13)


def test_unbalance_on_springs_that_differ():
    """x and y apart; between both critical speeds the whirl is backward."""
    found = unbalance_response(disc(2e5, 3e5, c=0.0), SPEEDS, (1, 3e-4))
    x = 3e-4 * SPEEDS**2 / (2e5 - 5.0 * SPEEDS**2)
    y = -1j * 3e-4 * SPEEDS**2 / (3e5 - 5.0 * SPEEDS**2)
    np.testing.assert_allclose(found["displacement"].values.T, [x, y], rtol=1e-12)
    pull = 5.0 * SPEEDS**2
    between = (pull > 2e5) & (pull < 3e5)
    assert ((found["minor_axis"].values[:, 0] < 0) == between).all()
    half_axes = np.sort(np.abs(np.stack([x, y])), axis=0)
    np.testing.assert_allclose(found["major_axis"].values[:, 0], half_axes[1], rtol=1e-12)
    np.testing.assert_allclose(np.abs(found["minor_axis"].values[:, 0]), half_axes[0], rtol=1e-12)


def test_unbalances_add_up_and_nodes_may_be_named_by_their_coordinates():
    rotor = disc(2e5, 3e5, cross=4e4)
    one, two = (1, 3e-4, 0.7), (("node 1 x", "node 1 y"), 1e-4, -0.2)
    both = unbalance_response(rotor, SPEEDS, [one, two])["displacement"]
    alone = [unbalance_response(rotor, SPEEDS, [each])["displacement"] for each in (one, two)]
    np.testing.assert_allclose(both, alone[0] + alone[1], rtol=1e-12)


@pytest.mark.slow
def test_unbalance_against_an_integration_in_time():
    """A gyroscopic rotor in bearings that depend on the speed, by DOP853 until it has settled.

    The equations are written here once more, from their definition: the unbalance goes around in
    the sense from x to y, the rotor turns so as well.
    """
    speed, tilt, polar = 140.0, 0.08, 0.12
    stiffness = np.array(
        [[2e5, 0, 0, -3e4], [0, 2.5e5, 3e4, 0], [0, 3e4, 2e4, 0], [-3e4, 0, 0, 2e4]]
    )
    gyroscopic = np.zeros((4, 4))
    gyroscopic[2, 3], gyroscopic[3, 2] = polar, -polar
    mass = np.diag([5.0, 5.0, tilt, tilt])
    film = Bearing(["1x", "1y"], lambda w: [[100 * w, 30 * w], [-30 * w, 50 * w]], 600.0)
    rotor = ns.Structure(
        mass, stiffness, damping=np.diag([20.0, 20.0, 3.0, 3.0]), gyroscopic=gyroscopic,
        coordinates=["1x", "1y", "1rx", "1ry"], bearings=[film],
    )  # fmt: skip

    def rates(t, z):
        q, v = z[:4], z[4:]
        force = -stiffness @ q - np.array([20.0, 20.0, 3.0, 3.0]) * v
        force[:2] -= [100 * speed * q[0] + 30 * speed * q[1] + 600 * v[0],
                      -30 * speed * q[0] + 50 * speed * q[1] + 600 * v[1]]  # fmt: skip
        # angular momentum of a turning disc: Id rx'' = -Ip w ry', Id ry'' = Ip w rx'
        force[2:] -= speed * polar * np.array([v[3], -v[2]])
        force[:2] += 2e-3 * speed**2 * np.array([np.cos(speed * t + 0.4), np.sin(speed * t + 0.4)])
        return np.concatenate([v, force / np.diag(mass)])

    slowest = -ns.structures.natural_modes(rotor, speed)["eigenvalue"].real.max().item()
    end = 2 * math.pi / speed * math.ceil(30.0 / slowest * speed / (2 * math.pi))
    final = solve_ivp(rates, (0.0, end), np.zeros(8), method="DOP853", rtol=1e-11, atol=1e-15).y[
        :, -1
    ]
    found = unbalance_response(rotor, [speed], (1, 2e-3, 0.4))["displacement"].values[0]
    # a whole number of turns after the start, and exp(-30) of the transient
    np.testing.assert_allclose(final[:4], found.real, rtol=1e-7, atol=1e-11)
    np.testing.assert_allclose(final[4:], (1j * speed * found).real, rtol=1e-7, atol=1e-9)


def test_frequency_response_of_a_chain_is_the_sum_over_its_modes():
    """With damping that the modes share, by their closed forms."""
    n, k, m, a, b = 12, 7.0, 3.0, 0.02, 0.01
    one = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    chain = ns.Structure(m * np.eye(n), k * one, damping=a * m * np.eye(n) + b * k * one)
    w = np.linspace(0.0, 4.0, 50)
    found = frequency_response(chain, w, inputs=["q2", 7], outputs="q4", kind="mobility")
    j = np.arange(1, n + 1)
    squares = 4 * k / m * np.sin(j * math.pi / (2 * n + 2)) ** 2
    shape = math.sqrt(2 / (n + 1) / m) * np.sin(
        np.outer(np.arange(1, n + 1), j) * math.pi / (n + 1)
    )
    parts = 1.0 / (squares - w[:, None] ** 2 + 1j * w[:, None] * (a + b * squares))
    for place, column in ((2, 0), (7, 1)):
        exact = 1j * w * (parts * shape[4] * shape[place]).sum(axis=1)
        np.testing.assert_allclose(
            found["response"].values[:, 0, column], exact, rtol=1e-11, atol=1e-13
        )
    assert found["input"].values.tolist() == ["q2", "q7"]
    assert found["amplitude"].attrs["units"] == "m/(N s)"


def test_receptance_mobility_and_accelerance_differ_by_the_frequency():
    w = np.array([1.0, 3.0])
    kinds = ("receptance", "mobility", "accelerance")
    mass = ns.Structure([[2.0]], [[8.0]], damping=[[0.3]])
    found = [frequency_response(mass, w, kind=each)["response"].values.ravel() for each in kinds]
    exact = 1.0 / (8.0 - 2.0 * w**2 + 0.3j * w)
    np.testing.assert_allclose(found, [exact, 1j * w * exact, -(w**2) * exact], rtol=1e-14)


def test_a_synchronous_response_turns_the_shaft_at_each_frequency():
    """A disc that tilts, in closed form: I_p and I_t give forward whirl a stiffness of its own."""
    k, inertia, polar, c = 900.0, 2.0, 1.5, 3.0
    disc = ns.Structure(
        inertia * np.eye(2), k * np.eye(2), damping=c * np.eye(2),
        gyroscopic=[[0.0, polar], [-polar, 0.0]], coordinates=["1rx", "1ry"],
    )  # fmt: skip
    w = np.array([5.0, 17.0, 40.0])
    found = frequency_response(disc, w, speed="synchronous")
    assert found.attrs["speed"] == "synchronous"
    # of the moments (1, -i): circles in the sense of the shaft
    circle = (found["response"].values @ np.array([1.0, -1j]))[:, 0]
    exact = 1.0 / (k - (inertia - polar) * w**2 + 1j * c * w)
    np.testing.assert_allclose(circle, exact, rtol=1e-13)
    each = [frequency_response(disc, [f], speed=f)["response"].values[0] for f in w]
    np.testing.assert_allclose(found["response"].values, each, rtol=1e-14)
    with pytest.raises(ns.OptionError, match=r"^speed = 'turning'"):
        frequency_response(disc, w, speed="turning")


def test_a_response_without_bound_is_refused():
    with pytest.raises(ns.ModelError, match="at 2 rad/s the response is infinite"):
        frequency_response(ns.Structure([[1.0]], [[4.0]]), [2.0])


def test_a_cantilever_deflects_as_timoshenko_says():
    """Under a force and a moment at its end, with any number of elements: exact."""
    length, force, moment = 0.9, 300.0, 40.0
    for n in (1, 7):
        beam = Beam(length / n, 0.09, 0.03)
        held = shaft([beam] * n).fixed(["0x", "0y", "0rx", "0ry"])
        found = static_deflection(held, {f"{n}y": force, f"{n}rx": -moment})["displacement"]
        bent = beam.youngs_modulus * beam.second_moment
        sheared = 12 * bent / (beam.shear_ratio * (length / n) ** 2)
        exact = (
            force * length**3 / (3 * bent)
            + force * length / sheared
            + moment * length**2 / (2 * bent)
        )
        assert found.sel(coordinate=f"{n}y").item() == pytest.approx(exact, rel=1e-10)
        slope = force * length**2 / (2 * bent) + moment * length / bent
        assert found.sel(coordinate=f"{n}rx").item() == pytest.approx(-slope, rel=1e-10)


def test_bearings_carry_the_weight():
    """Of a shaft with a disc at a quarter: by the levers, three to one."""
    beam, heavy = Beam(0.2, 0.05), Disc(1, 30.0, 0.1, 0.2)
    held = [Bearing(["0x", "0y"], 1e7), Bearing(["4x", "4y"], 2e7)]
    found = static_deflection(shaft([beam] * 4, discs=[heavy], bearings=held), gravity={"y": -9.81})
    own = 4 * beam.mass * 9.81
    reaction = found["reaction"]
    assert reaction.sel(coordinate="0y").item() == pytest.approx(
        own / 2 + 0.75 * 30 * 9.81, rel=1e-9
    )
    assert reaction.sel(coordinate="4y").item() == pytest.approx(
        own / 2 + 0.25 * 30 * 9.81, rel=1e-9
    )
    assert np.abs(reaction.sel(coordinate=["0x", "2y", "3rx"])).max() < 1e-6 * own


def test_what_floats_has_no_static_deflection():
    with pytest.raises(
        ns.ModelError, match="stiffness is singular: the structure can move without"
    ):
        static_deflection(shaft([Beam(0.2, 0.05)] * 3), {"1y": 1.0})
    with pytest.raises(ns.OptionError, match="load: unknown coordinate 'q9'"):
        static_deflection(ns.Structure([[1.0]], [[1.0]]), {"q9": 1.0})
    with pytest.raises(ns.OptionError, match="no coordinate has the direction 'y'"):
        static_deflection(ns.Structure([[1.0]], [[1.0]]), gravity={"y": 1.0})


def test_root_locus_over_a_damping():
    """-c/2 + i sqrt(1 - c^2/4) up to c = 2, and on the real axis beyond."""
    values = np.linspace(0.0, 3.0, 31)
    found = root_locus(
        lambda c: ns.Structure([[1.0]], [[1.0]], damping=[[c]]), values, name="damping"
    )
    path = found["eigenvalue"].values[:, 0]
    bound = values < 2.0
    exact = -values[bound] / 2 + 1j * np.sqrt(1 - values[bound] ** 2 / 4)
    np.testing.assert_allclose(path[bound], exact, rtol=1e-13, atol=1e-15)
    assert (path[values > 2.0].imag == 0.0).all()
    product = path[values > 2.0].real ** 2 + values[values > 2.0] * path[values > 2.0].real + 1.0
    assert np.abs(product).max() < 1e-13


def test_oil_whirl_begins_where_the_cross_coupling_beats_the_damping():
    """m z'' + c z' + (k - i q) z = 0 with z = x + i y is stable for q < c sqrt(k/m)."""
    threshold = 120.0 * math.sqrt(2e5 / 5.0)
    values = threshold * np.array([0.0, 0.5, 1.0 - 1e-9, 1.0 + 1e-9, 2.0])
    found = root_locus(lambda q: disc(2e5, 2e5, cross=q), values, count=2)
    assert found["stable"].values.tolist() == [True, True, True, False, False]


def test_root_locus_over_the_speed_is_a_campbell_diagram():
    rotor = shaft(
        [Beam(0.2, 0.05)] * 4, bearings=[Bearing([f"{i}x", f"{i}y"], 1e7) for i in (0, 4)]
    )
    speeds = np.linspace(0.0, 900.0, 5)
    locus = root_locus(rotor, speeds, count=4)
    diagram = ns.structures.campbell(rotor, speeds, count=4)
    np.testing.assert_array_equal(locus["eigenvalue"].values, diagram["eigenvalue"].values)


@pytest.mark.parametrize(
    "wrong, says",
    [
        (("node 2", 1.0), "unbalance: unknown node 'node 2'; did you mean 'node 1'"),
        ((("node 1 x",), 1.0), "give the coordinates of x and of y"),
        ((1, "heavy"), "unbalance: moment = 'heavy' is not a finite number"),
        (3.0, r"unbalance = 3.0: give \(node, moment\)"),
    ],
)
def test_a_wrong_unbalance_is_refused(wrong, says):
    with pytest.raises(ns.OptionError, match=says):
        unbalance_response(disc(1.0, 1.0), [1.0], wrong)


def test_a_response_of_a_structure_whose_fastest_mode_grows_has_a_warning():
    """Damping a - b K of a chain of 20 masses, by which all modes but one decay."""
    stiffness = 2 * np.eye(20) - np.eye(20, k=1) - np.eye(20, k=-1)
    fastest = np.linalg.eigvalsh(stiffness)[-2:]
    damping = 0.01 * (fastest.mean() * np.eye(20) - stiffness)
    driven = ns.Structure(np.eye(20), stiffness, damping=damping)
    with pytest.warns(ns.ResultWarning, match=f"the mode of {np.sqrt(fastest[1]):.4g} rad/s, grow"):
        frequency_response(driven, [0.1], inputs=0, outputs=0)


def whirling(speed_of_onset):
    """A disc whose cross-coupling grows with the speed and beats the damping at one."""
    m, c, k = 5.0, 120.0, 2e5
    critical = c * math.sqrt(k / m)
    oil = Bearing(
        ["1x", "1y"],
        lambda speed: critical * speed / speed_of_onset * np.array([[0.0, 1.0], [-1.0, 0.0]]),
    )
    return ns.Structure(
        m * np.eye(2), k * np.eye(2), damping=c * np.eye(2), coordinates=["1x", "1y"],
        bearings=[oil],
    )  # fmt: skip


def test_a_response_of_what_is_unstable_is_told():
    onset = 250.0  # between 248 and 252
    speeds = np.arange(100.0, 400.0, 4.0)
    with pytest.warns(ns.ResultWarning, match=r"forward, grows as exp\(.* a speed of 252 rad/s"):
        unbalance_response(whirling(onset), speeds, (1, 1e-3))
    unbalance_response(whirling(onset), speeds[speeds < onset], (1, 1e-3))  # no warning
    frequency_response(whirling(onset), [10.0, 20.0], speed=249.0)
    growth = np.roots([5.0, 120.0, 2e5 - 1j * 120.0 * math.sqrt(2e5 / 5.0) * 252.0 / onset]).real
    assert f"{growth.max():.4f}" == "0.0957"
    with pytest.warns(ns.ResultWarning, match=r"mode of 200 rad/s, forward, grows as exp\(0.0957"):
        frequency_response(whirling(onset), [10.0, 20.0], speed=252.0)
