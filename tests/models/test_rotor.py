"""The rotor's System: starts on the ring, regimes, limits, bad values."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.models import massive_ring_rotor, rotor, snubber_ring

PRELOADS = [(0.1, 0.1), (0.0, 0.0), (0.3, 0.05), (0.0, 0.2)]


@pytest.mark.slow
@pytest.mark.parametrize("preload", PRELOADS)
def test_ten_thousand_starts_stand_where_statics_put_them(preload):
    """The engine's Newton against closed forms and one monotone equation (`snubber_ring`)."""
    rng = np.random.default_rng(5)
    angle, radius = rng.uniform(0.0, 2.0 * np.pi, 10_000), rng.uniform(0.0, 3.0, 10_000)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    vx, vy = rng.normal(size=(2, x.size))
    system = rotor(delta_x=preload[0], delta_y=preload[1], nu2=0.2)
    lanes = ns.ensemble(system, {"x": x, "y": y, "vx": vx, "vy": vy}, times=[0.0])
    statics = snubber_ring(x, y, vx, vy, K=30.0, nu2=0.2, delta_x=preload[0], delta_y=preload[1])
    # a start that pulls on the ring releases it at once, and is on its way free
    presses = (statics["normal_force"].values > 1e-9) | (radius < 1.0)
    edge = np.abs(np.abs(statics["sx"].values) - preload[0]) < 1e-9
    edge |= np.abs(np.abs(statics["sy"].values) - preload[1]) < 1e-9
    keep = presses & ~(edge & (radius > 1.0))
    assert np.mean(keep) > 0.5
    for name in ("sx", "sy", "mu", "ring_vx", "ring_vy", "force_x", "force_y", "energy"):
        if name in lanes:
            ours, theirs = lanes[name].values.squeeze()[keep], statics[name].values[keep]
            np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-12, err_msg=name)
    words = np.array(lanes["mode"].attrs["flag_meanings"].split())
    ours = words[lanes["mode"].values.squeeze()[keep]]
    theirs = np.array(statics["regime"].attrs["flag_meanings"].split())
    theirs = np.array(["free", *theirs[1:]])
    numbers = np.asarray(statics["regime"].attrs["flag_values"])
    named = theirs[np.searchsorted(numbers, statics["regime"].values[keep])]
    assert np.array_equal(ours, named)


def test_distance_in_contact_and_the_force_that_presses():
    run = ns.simulate(rotor(), periods=200)
    regime = np.array(run["mode"].attrs["flag_meanings"].split())[run["mode"].values]
    touching = regime != "free"
    assert set(regime) >= {"free", "II"}
    assert np.abs(run["gap"].values[touching]).max() < 2e-15
    assert run["gap"].values[~touching].min() >= -1e-15
    press = (
        np.cos(run["contact_angle"]) * run["force_x"]
        + np.sin(run["contact_angle"]) * run["force_y"]
    )
    assert press.values[touching].min() > -1e-12
    assert run.attrs["certified"] == 1


@pytest.mark.slow
def test_a_ring_with_little_damping_tends_to_one_that_returns_at_once():
    """The difference falls in proportion to the damping."""
    start = {"x": 0.3, "vx": 1.0, "vy": -2.0}
    limit = ns.simulate(rotor(ring="returns"), start, periods=1, samples_per_period=1)
    assert "nu2" not in rotor(ring="returns").parameters
    differences = []
    for nu2 in (2e-4, 2e-5, 2e-6):
        run = ns.simulate(rotor(nu2=nu2), start, periods=1, samples_per_period=1)
        differences.append(abs(float(run["x"][-1] - limit["x"][-1])))
    assert differences[0] < 1e-2
    np.testing.assert_allclose(np.diff(np.log10(differences)), -1.0, atol=0.05)


def test_energy_is_kept_without_damping_and_drive():
    system = rotor(nu1=0.0, eta_m=0.0, ring="returns", eps_x=0.2)
    run = ns.simulate(system, {"vx": 1.5, "vy": 0.7}, periods=40)
    total = 0.5 * (run["vx"] ** 2 + run["vy"] ** 2) + 0.5 * ((run["x"] - 0.2) ** 2 + run["y"] ** 2)
    total = (total + run["energy"]).values
    assert np.abs(total - total[0]).max() < 1e-12 * 100
    assert run.attrs["n_events"] > 20


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"delta_x": -0.1}, "delta_x >= 0"),
        ({"nu2": 0.0}, "ring='returns'"),
        ({"K": 0.0}, "K > 0"),
        ({"eta": 0.0}, "eta > 0"),
        ({"ring": "flies"}, "'relaxes' or 'rides' or 'returns'"),
    ],
)
def test_values_that_no_rotor_has(changes, words):
    with pytest.raises(ns.ModelError, match=words):
        rotor(**changes)


def test_a_position_that_disagrees_with_the_ring_is_told_what_would_agree():
    with pytest.raises(ns.OptionError, match=r"give sx = 0\.2"):
        ns.simulate(rotor(), {"x": 1.2, "sx": 0.1}, periods=1)


@pytest.mark.slow  # every verb on the rotor; each has tests of its own
def test_analyses_take_starts_on_the_ring():
    """What a region leaves out of the ring stands where statics put it, as in `simulate`."""
    system = rotor(eta=2.1, delta_x=0.05, delta_y=0.05, nu1=0.2)
    found = ns.attractors(system, {"x": (0.5, 1.6), "y": (-0.4, 0.4)}, samples=8, record=500)
    assert found["kind"].values.tolist() == ["periodic"]
    axes = {"x": np.linspace(0.5, 1.6, 6), "y": np.linspace(-0.4, 0.4, 5)}
    basins = ns.basins_of_attraction(system, axes, record=500)
    assert np.all(basins["label"] == 1) and basins.attrs["inadmissible_cells"] == 0
    points = ns.StroboscopicMap(system).iterate({"x": 1.4, "y": 0.2}, 1)
    run = ns.simulate(system, {"x": 1.4, "y": 0.2}, periods=1, samples_per_period=1)
    assert float(points["x"][0]) == float(run["x"][-1])


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::nonsmooth.errors.RunWarning")
def test_contacts_with_a_displaced_ring_are_on_the_least_energy():
    """Whatever the ring's place before: no other place at the gap's distance has less nearby."""
    rng = np.random.default_rng(0)

    def energy(s, preload):
        s = np.abs(s)
        return np.where(s <= preload, s * s, 0.5 * s * s + s * preload - 0.5 * preload**2)

    contacts = 0
    for _ in range(150):
        preload = rng.choice([0.0, 0.1, 0.5], 2)
        ring, angle, distance = (
            rng.uniform(-1.2, 1.2, 2),
            rng.uniform(0, 6.28),
            rng.uniform(0.9, 0.99),
        )
        outwards = np.array([np.cos(angle), np.sin(angle)])
        (x, y), (vx, vy) = ring + distance * outwards, 20.0 * outwards
        start = {"x": x, "y": y, "vx": vx, "vy": vy, "sx": ring[0], "sy": ring[1], "mu": 0.0}
        system = rotor(K=30.0, nu2=5.0, delta_x=preload[0], delta_y=preload[1])
        run = ns.simulate(system, start, t_end=0.1)
        assert run.attrs["status"] in ("completed", "undecided")
        names = run["event_name"].values.astype(str)
        for k in np.flatnonzero(names == "contact"):
            x, y, _, _, sx, sy, _ = run["state_after"].values[k]
            if np.hypot(x, y) < 0.7:  # near the centre several places have the least energy
                continue
            contacts += 1
            around = np.arctan2(y - sy, x - sx) + np.array([-1e-3, 0.0, 1e-3])
            stored = energy(x - np.cos(around), preload[0]) + energy(y - np.sin(around), preload[1])
            assert stored[1] <= stored.min() + 1e-12
    assert contacts > 50


@pytest.mark.parametrize("start", [{"x": -1.2, "vx": 1.0}, {"x": 1.01, "vx": -100.0}])
def test_a_rotor_pressed_against_the_ring_may_leave_it_at_once(start):
    """The ring stands where statics put it, and the rotor is free of it from the start."""
    system = rotor(nu2=0.5, K=1.0)
    run = ns.simulate(system, start, times=[0.0, 1e-4])
    place = start["x"] - np.sign(start["x"])
    assert float(run["sx"][0]) == pytest.approx(place, rel=1e-14)
    words = run["mode"].attrs["flag_meanings"].split()
    assert words[int(run["mode"][0])] == "free"
    lanes = ns.ensemble(system, start, times=[0.0])
    initial = lanes["initial_state"].squeeze()
    assert float(initial.sel(state="sx")) == pytest.approx(place, rel=1e-14)
    assert float(initial.sel(state="mu")) == 0.0


@pytest.mark.parametrize("preload", [(0.0, 0.3), (0.3, 0.0), (0.05, 0.2), (0.0, 0.0)])
@pytest.mark.parametrize("model", ["returning", "massive"])
def test_rings_that_always_tell_what_comes_next(model, preload):
    """Unlike the chapter's ring, whose release from III or IV may leave nothing that holds."""
    for eta in (2.0, 3.0, 4.2):
        given = {"eta": eta, "delta_x": preload[0], "delta_y": preload[1]}
        system = (
            rotor(ring="returns", **given)
            if model == "returning"
            else ns.models.massive_ring_rotor(**given)
        )
        run = ns.simulate(system, {"x": 0.5, "vy": 0.3}, periods=20, samples_per_period=1)
        assert run.attrs["status"] == "completed" and run.attrs["n_events"] > 5


UNEQUAL = [(0.1, 0.0), (0.0, 0.1), (0.05, 0.3)]


def rides(run):
    """Instants between which the ring rides on the rotor."""
    names = run["event_to"].attrs["flag_meanings"].split()
    times = run["event_time"].values
    modes = [names[int(mode)] for mode in run["event_to"].values]
    return [times[k : k + 2] for k in range(len(times) - 1) if modes[k] == "riding"]


@pytest.mark.parametrize("preloads", UNEQUAL)
@pytest.mark.parametrize("nu2", [0.002, 0.3])
def test_unequal_preloads_have_a_motion(preloads, nu2):
    run = ns.simulate(rotor(delta_x=preloads[0], delta_y=preloads[1], nu2=nu2), periods=60)
    assert run.attrs["status"] == "completed"
    found = rides(run)
    if 0.0 in preloads:
        assert len(found) > 10
    # the ring is free before it has relaxed
    assert all(end - begin < 2.0 * nu2 / 30.0 for begin, end in found)


@pytest.mark.parametrize("preloads", UNEQUAL[:2])
def test_a_riding_ring_follows_its_dampers(preloads):
    """Force balance of a ring without mass, pushed along the normal, by DOP853."""
    nu2, stiffness = 0.3, 30.0
    system = rotor(delta_x=preloads[0], delta_y=preloads[1], nu2=nu2)
    p = system.parameter_values
    found = rides(ns.simulate(system, periods=20))
    assert len(found) > 3

    def ring(w):
        s, preload = w[4:6], np.array(preloads)
        springs = np.where(np.abs(s) > preload, 1.0, 2.0)
        pull = springs * s + np.where(np.abs(s) > preload, np.sign(s) * preload, 0.0)
        normal = w[:2] - s
        # unknown: rates of the ring, push; balance along both axes, and no approach
        matrix = np.zeros((3, 3))
        matrix[0, 0], matrix[1, 1] = 2.0 * nu2 * springs
        matrix[:2, 2], matrix[2, :2] = -normal, normal
        return np.linalg.solve(matrix, [*(-stiffness * pull), normal @ w[2:4]]), normal

    def flow(t, w):
        (vx, vy, push), normal = ring(np.asarray(w))
        angle = p["eta"] * t
        drive = p["eta_m"] * p["rho"] * p["eta"] ** 2
        ax = drive * np.cos(angle) - 2 * p["nu1"] * w[2] - (w[0] - p["eps_x"]) - push * normal[0]
        ay = drive * np.sin(angle) - 2 * p["nu1"] * w[3] - (w[1] - p["eps_y"]) - push * normal[1]
        return [w[2], w[3], ax, ay, vx, vy]

    def pushes(t, w):
        return ring(np.asarray(w))[0][2]

    pushes.terminal, pushes.direction = True, -1
    for begin, end in found:
        start = ns.simulate(system, times=[begin])
        state = [float(start[name][0]) for name in ("x", "y", "vx", "vy", "sx", "sy")]
        truth = solve_ivp(
            flow, (begin, begin + 0.1), state, "DOP853", events=pushes, rtol=1e-12, atol=1e-14
        )
        # the push is of the size of rounding over the rate at which it falls
        assert abs(float(truth.t_events[0][0]) - end) < 1e-9


@pytest.mark.parametrize("preloads", UNEQUAL[:2])
def test_a_light_ring_tends_to_the_one_without_mass(preloads):
    """In proportion to its mass, and to the damping, which statics leave out along the rotor."""
    words = {"delta_x": preloads[0], "delta_y": preloads[1], "nu2": 2e-4}
    times = np.linspace(0.0, 12.0, 121)
    limit = ns.simulate(rotor(**words), times=times)
    assert len(rides(limit)) > 0
    apart = [
        float(abs(ns.simulate(massive_ring_rotor(**words, m_s=mass), times=times)["x"]
                  - limit["x"]).max())
        for mass in (1e-3, 1e-4, 1e-5)
    ]  # fmt: skip
    assert apart[0] > 5.0 * apart[1] > 25.0 * apart[2]


def test_a_ring_without_damping_in_other_forms():
    """A machine in SI units and one by its matrices take it as one that returns at once."""
    limit = ns.simulate(rotor(ring="returns"), periods=10)
    machine = ns.models.MatrixRotor(
        mass=np.eye(2), stiffness=np.eye(2), damping=0.25 * np.eye(2), ring=(0, 1),
        unbalance=[(0, 1, 0.0017 * 70.0)], load=[0.9, 0.0],
    ).system(Omega=2.442, k_s=30.0, c_s=0.0, delta_x=0.1, delta_y=0.1)  # fmt: skip
    assert "c_s" not in machine.parameters
    run = ns.simulate(machine, periods=10)
    assert np.abs(run["x"].values - limit["x"].values).max() < 1e-11
