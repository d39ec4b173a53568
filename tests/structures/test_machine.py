"""Machines with contacts against scipy in the coordinates of the full model."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

import nonsmooth as ns
from effort import calls_at_most
from nonsmooth.structures import (
    BaseMotion,
    Beam,
    Bearing,
    Disc,
    DryFriction,
    Force,
    GapSpring,
    RubRing,
    SnubberRing,
    Stop,
    Unbalance,
    Weight,
    machine,
    reduce,
    shaft,
)
from structures.contact_truth import Bench, Spring, Wall, chain

OMEGA = 2.1
# DOP853 at 3e-14 leaves 1e-12 of a state; a slow crossing divides that by its speed
NEAR = 1e-9


def chain_structure(n):
    mass, stiffness = chain(n)
    damping = 0.05 * mass + 0.02 * stiffness
    names = [f"{i}x" for i in range(n)]
    return ns.Structure(mass, stiffness, damping=damping, coordinates=names), names


def truth_of(n, springs=(), walls=()):
    mass, stiffness = chain(n)
    unit = np.eye(n)
    return Bench(
        mass,
        0.05 * mass + 0.02 * stiffness,
        stiffness,
        lambda t: 2.0 * np.cos(OMEGA * t) * unit[n // 2],
        springs,
        walls,
    )


def shaken(structure, contacts, at, **others):
    return machine(
        structure,
        contacts,
        [Force(at, "F*cos(omega*t)")],
        parameters={"F": 2.0, "omega": OMEGA},
        period="2*pi/omega",
        **others,
    )


def assert_same_events(system, bench, count, names):
    truth = bench.run(np.zeros(2 * bench.n), count, 200.0)
    run = ns.simulate(system, t_end=truth[-1].time + 1e-3)
    assert run.attrs["certified"]
    found = run["event_time"].values[run["event_kind"].values != "start"][:count]
    assert len(found) == len(truth) == count
    assert np.abs(found - [event.time for event in truth]).max() < NEAR
    between = truth[-2].time, truth[-1].time
    middle = ns.simulate(system, times=np.array([0.0, 0.5 * sum(between)]))
    # behind the last event but one nothing happens until the middle
    solved = solve_ivp(
        bench.rates, (between[0], 0.5 * sum(between)), truth[-2].state, method="DOP853",
        args=(truth[-2].springs,), rtol=3e-14, atol=1e-15,
    )  # fmt: skip
    for i, name in enumerate(names):
        assert abs(float(middle[name][-1]) - solved.y[i, -1]) < NEAR


@pytest.mark.few(1)
@pytest.mark.parametrize("n", [4, 12, pytest.param(40, marks=pytest.mark.slow)])
def test_two_springs(n):
    structure, names = chain_structure(n)
    unit = np.eye(n)
    contacts = [
        GapSpring(names[-1], 0.1, 30.0),
        GapSpring(names[n // 3], 0.05, 20.0, 0.5, side="below"),
    ]
    springs = [Spring(unit[-1], 0.1, 30.0), Spring(-unit[n // 3], 0.05, 20.0, 0.5)]
    system = shaken(structure, contacts, names[n // 2], outputs=names)
    states = [f"x{i}" for i in range(n)]
    assert_same_events(system, truth_of(n, springs), 20, states)


@pytest.mark.parametrize("n", [4, 12, pytest.param(40, marks=pytest.mark.slow)])
def test_a_spring_between_two_coordinates_and_a_stop(n):
    structure, names = chain_structure(n)
    unit = np.eye(n)
    contacts = [
        GapSpring((names[-1], names[n // 3]), 0.08, 30.0),
        Stop(names[n // 2], 0.1, 0.8, side="below"),
    ]
    system = shaken(structure, contacts, names[n // 2], outputs=names)
    bench = truth_of(
        n, [Spring(unit[-1] - unit[n // 3], 0.08, 30.0)], [Wall(-unit[n // 2], 0.1, 0.8)]
    )
    assert_same_events(system, bench, 20, [f"x{i}" for i in range(n)])


def test_two_parts_that_collide():
    n = 4
    structure, names = chain_structure(n)
    unit = np.eye(n)
    contacts = [Stop((names[3], names[1]), 0.1, 0.9)]
    system = shaken(structure, contacts, names[2])
    bench = truth_of(n, walls=[Wall(unit[3] - unit[1], 0.1, 0.9)])
    assert_same_events(system, bench, 20, [f"x{i}" for i in range(n)])


def test_an_impact_takes_all_coordinates_where_the_mass_matrix_is_full():
    mass = np.array([[2.0, 0.5], [0.5, 1.0]])
    structure = ns.Structure(mass, 4 * np.eye(2), coordinates=["a", "b"])
    system = machine(structure, [Stop("a", 0.1, 0.5)])
    run = ns.simulate(system, {"va": 1.0, "vb": 0.3}, t_end=0.2)
    event = int(np.flatnonzero(run["event_kind"] == "impact")[0])
    before, after = (
        run[f"state_{when}"][event].sel(state=["va", "vb"]).values for when in ("before", "after")
    )
    impulse = mass @ (after - before)
    assert abs(after[0] + 0.5 * before[0]) < 1e-14
    assert abs(impulse[1]) < 1e-14  # nothing strikes b


@pytest.mark.slow
def test_a_ring_is_that_of_the_matrix_rotor():
    n = 4
    plane = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    stiffness, mass = np.kron(plane, np.eye(2)), np.diag(np.repeat([0.5, 1.0, 1.0, 0.7], 2))
    gyroscopic = 0.1 * np.kron(np.eye(n), [[0.0, 1.0], [-1.0, 0.0]])
    names = [f"{i}{axis}" for i in range(n) for axis in "xy"]
    given = {"damping": 0.1 * stiffness, "gyroscopic": gyroscopic}
    model = ns.models.MatrixRotor(
        mass=mass, stiffness=stiffness, ring=(2, 3), unbalance=[(4, 5, 2.0)], **given
    ).system(Omega=0.8, k_s=30, c_s=0.05, gamma=0.4, eps_x=0.2, delta_x=0.02, delta_y=0.02)
    structure = ns.Structure(mass, stiffness, coordinates=names, **given)
    ring = SnubberRing(
        "1x", "1y", 0.4, 30, 0.05, preload_x=0.02, preload_y=0.02, centre_x=-0.2
    )  # fmt: skip
    system = machine(structure, [ring], [Unbalance("2x", "2y", 2.0)], Omega=0.8)
    one, other = (ns.simulate(each, periods=10) for each in (model, system))
    assert one.attrs["phase_word"] == other.attrs["phase_word"]
    assert {"II", "V"} <= set(ns.phase_word(other))
    assert abs(one["event_time"] - other["event_time"]).max() < 1e-10
    for i, name in enumerate(names):
        assert abs(one[f"q{i}"] - other[f"{name[1]}{name[0]}"]).max() < 1e-10
    assert abs(one["force"] - other["ring1_force"]).max() < 1e-8


@pytest.mark.slow
def test_a_ring_with_one_preload_rides_as_in_the_model():
    structure = ns.Structure(
        np.eye(2), np.eye(2), damping=0.25 * np.eye(2), coordinates=["1x", "1y"]
    )
    ring = SnubberRing("1x", "1y", 1.0, 30.0, 0.004, preload_x=0.1, centre_x=-0.9)
    system = machine(structure, [ring], [Unbalance("1x", "1y", 0.119)], Omega=2.442)
    run = ns.simulate(system, {"x1": -0.9}, periods=10)
    same = ns.simulate(ns.models.rotor(delta_x=0.1, delta_y=0.0), periods=10)
    assert "riding" in ns.phase_word(run) and run.attrs["status"] == "completed"
    assert run.attrs["n_events"] == same.attrs["n_events"] > 20
    # rounding times the growth of the tangent over ten periods
    assert abs(run["x1"] + 0.9 - same["x"]).max() < 1e-10


@pytest.mark.slow  # 756 modes and cells take a minute to set up
def test_two_rings_at_once():
    structure = ns.Structure(
        np.eye(4),
        np.kron([[2.0, -1.0], [-1.0, 2.0]], np.eye(2)),
        damping=0.2 * np.eye(4),
        coordinates=["1x", "1y", "2x", "2y"],
    )
    rings = [
        SnubberRing(f"{i}x", f"{i}y", gap, 30.0, 0.05, name=name)
        for i, gap, name in ((1, 0.3, "left"), (2, 0.4, "right"))
    ]
    alone = [
        machine(structure, [ring], [Unbalance("1x", "1y", 0.5)], Omega=1.0) for ring in rings[:1]
    ]
    both = machine(structure, rings, [Unbalance("1x", "1y", 0.5)], Omega=1.0)
    start = {"x1": 0.1, "vy2": -0.1}
    run = ns.simulate(both, start, periods=8)
    visited = {mode.split("[")[0] for mode in ns.phase_word(run)}
    assert {"free", "left", "left_right"} <= visited
    # before the second ring is met, the first one is as if it were alone
    to = [both.mode_names[int(each)] for each in run["event_to"].values]
    first = next(
        float(time)
        for time, mode in zip(run["event_time"].values, to, strict=True)
        if mode.startswith("left_right")
    )
    single = ns.simulate(alone[0], start, times=np.linspace(0.0, 0.99 * first, 50))
    same = ns.simulate(both, start, times=np.linspace(0.0, 0.99 * first, 50))
    assert abs(single["left_force"] - same["left_force"]).max() < 1e-10
    # where both touch each ring follows its own place: without preload s = (1 - gap/|r|) r
    touching = (run["left_force"] > 0) & (run["right_force"] > 0)
    late = run.isel(time=np.flatnonzero(touching))
    assert late.sizes["time"] > 20
    for name, i, gap in (("left", 1, 0.3), ("right", 2, 0.4)):
        place = np.array([late[f"x{i}"], late[f"y{i}"]])
        speed = np.array([late[f"vx{i}"], late[f"vy{i}"]])
        far = np.hypot(*place)
        outward = place / far
        across = speed - outward * (speed * outward).sum(axis=0)
        force = 30.0 * (1 - gap / far) * place + 0.05 * (speed - gap / far * across)
        found = np.array([late[f"{name}_force_x"], late[f"{name}_force_y"]])
        assert np.abs(found - force).max() < 1e-10


def test_rub_against_the_model_of_a_jeffcott_rotor():
    rotor = ns.Structure(np.eye(2), np.eye(2), damping=0.2 * np.eye(2), coordinates=["1x", "1y"])
    ring = RubRing("1x", "1y", 1.0, 20.0, friction=0.2, radius=10.0)
    system = machine(rotor, [ring], [Unbalance("1x", "1y", 0.0)], Omega=0.9)
    model = ns.models.rubbing_rotor(zeta=0.1, rho=0, f=0.2, radius=10)
    start = {"x": 1.1, "vy": -5.0}
    one = ns.simulate(model, start, t_end=60)
    other = ns.simulate(system, {"x1": 1.1, "vy1": -5.0}, t_end=60)
    assert ns.phase_word(one) == ("forward_slip", "rolling")
    assert ns.phase_word(other) == ("contact,forward_slip", "contact,rolling")
    pairs = {"normal_force": "rub1_force", "friction": "rub1_friction", "x": "x1"}
    for name, called in pairs.items():
        # the same motion from other texts: rounding grows while the whip does
        assert abs(one[name].values - other[called].values).max() < 1e-8


def test_friction_holds_a_coordinate_of_a_chain():
    """A rod that slips and sticks, against scipy with the law of Coulomb written out."""
    n = 4
    structure, names = chain_structure(n)
    mass, stiffness = chain(n)
    inverse, damping = np.linalg.inv(mass), 0.05 * mass + 0.02 * stiffness
    unit, limit = np.eye(n), 0.6
    system = shaken(structure, [DryFriction(names[-1], limit)], names[2])
    run = ns.simulate(system, t_end=12.0)
    assert {"stick", "back", "forth"} == set(ns.phase_word(run))
    rows = [i for i, kind in enumerate(run["event_kind"].values) if kind != "start"]
    signs = {"back": -1.0, "forth": 1.0, "stick": 0.0}
    assert len(rows) > 6
    for i in rows[:-1]:  # each piece from its start, by the field that holds in it
        j = i + 1
        begin, end = float(run["event_time"][i]), float(run["event_time"][j])
        mode = system.mode_names[int(run["event_to"][i])]
        state = run["state_after"][i].sel(state=list(system.states)).values

        def rates(t, y, sign=signs[mode]):
            q, v = y[:n], y[n:]
            total = 2 * np.cos(OMEGA * t) * unit[2] - damping @ v - stiffness @ q
            held = total[-1] if sign == 0.0 else limit * sign
            return np.concatenate([v, inverse @ (total - held * unit[-1])])

        solved = solve_ivp(rates, (begin, end), state, method="DOP853", rtol=1e-13, atol=1e-14)
        assert np.abs(solved.y[:, -1] - run["state_before"][j].values).max() < 1e-9
        q, v = solved.y[:n, -1], solved.y[n:, -1]
        if mode == "stick":  # it leaves where the load has reached what friction holds
            load = (2 * np.cos(OMEGA * end) * unit[2] - damping @ v - stiffness @ q)[-1]
            assert abs(abs(load) - limit) < 1e-9
        else:
            assert abs(v[-1]) < 1e-9


def test_base_motion_is_absolute_motion_less_that_of_the_base():
    structure, names = chain_structure(3)
    mass, stiffness = chain(3)
    ones = np.ones(3)
    moved = machine(structure, loads=[BaseMotion("x", "-4*A*sin(2*t)")], parameters={"A": 0.3})
    run = ns.simulate(moved, t_end=6.0)
    damping = 0.05 * mass + 0.02 * stiffness

    def rates(t, y):  # of absolute displacements, on a base at A sin 2t
        q, v = y[:3] - 0.3 * np.sin(2 * t), y[3:] - 0.6 * np.cos(2 * t)
        return np.concatenate([y[3:], np.linalg.solve(mass, -damping @ v - stiffness @ q)])

    start = np.concatenate([np.zeros(3), 0.6 * ones])
    solved = solve_ivp(rates, (0, 6), start, method="DOP853", rtol=1e-13, atol=1e-14)
    base = 0.3 * np.sin(12.0)
    for i in range(3):
        assert abs(float(run[f"x{i}"][-1]) + base - solved.y[i, -1]) < 1e-9
    assert names[0] == "0x"


def test_weight_is_the_mass_of_the_structure():
    structure, _ = chain_structure(5)
    mass, stiffness = chain(5)
    system = machine(structure, loads=[Weight("x", 9.81)])
    sag = np.linalg.solve(stiffness, 9.81 * mass @ np.ones(5))
    run = ns.simulate(system, {f"x{i}": sag[i] for i in range(5)}, t_end=3.0)
    for i in range(5):
        assert abs(run[f"x{i}"] - sag[i]).max() < 1e-13 * abs(sag).max() * 100


# ---------------------------------------------------------------- analyses


@pytest.fixture(scope="module")
def rattling():
    """Three masses of which the last meets a spring, and its rates for scipy."""
    structure, names = chain_structure(3)
    system = shaken(structure, [GapSpring(names[-1], 0.3, 10.0)], names[1])
    bench = truth_of(3, [Spring(np.eye(3)[-1], 0.3, 10.0)])
    return system, bench


@pytest.mark.slow
def test_an_orbit_is_one_of_scipy(rattling):
    system, bench = rattling
    found = ns.find_orbit(system)
    period = 2 * np.pi / OMEGA
    names = [f"{prefix}x{i}" for prefix in ("", "v") for i in range(3)]
    point = np.array([float(found[name]) for name in names])

    def rates(t, y):
        depth = bench.depth(bench.springs[0], y)
        return bench.rates(t, y, ["closed" if depth > 0 else "free"])

    def turn(y):
        solved = solve_ivp(
            rates, (0, period), y, method="DOP853", rtol=1e-12, atol=1e-13, max_step=0.01
        )
        return solved.y[:, -1] - y

    # the corner of the force within a step of scipy leaves some 1e-8
    assert np.abs(turn(point)).max() < 1e-7
    near, _, status, _ = fsolve(turn, point + 1e-3, full_output=True, xtol=1e-10)
    assert status == 1
    assert np.abs(near - point).max() < 1e-6
    assert found["word"].item().split() != ["free"]


def test_sweeps_take_parameters_of_contacts_without_building_anew(rattling):
    system, _ = rattling
    gaps = np.array([0.2, 0.3, 5.0])
    found = ns.contact_statistics(
        system, "spring1_gap", gaps, contact="contact", of="spring1_force"
    )
    assert (found["contacts"].values[:2] > 0).all()
    assert found["contacts"].values[2] == 0
    largest = found["spring1_force_max"].values
    assert largest[0] > 0
    assert largest[2] == 0
    run = ns.simulate(system, periods=300)
    late = run.sel(time=slice(250 * 2 * np.pi / OMEGA, None))
    assert abs(float(late["spring1_force"].max()) / largest[1] - 1) < 1e-2  # of samples
    assert system.with_parameters(spring1_gap=0.2).structure is system.structure


def test_branches_and_diagrams(rattling):
    system, _ = rattling
    orbit = ns.find_orbit(system)
    branch = ns.continue_orbit(system, "spring1_gap", (0.25, 0.35), initial=orbit)
    assert float(branch["spring1_gap"].max()) >= 0.35 - 1e-9
    diagram = ns.bifurcation_diagram(
        system, "spring1_gap", [0.25, 0.3, 0.35], transient=200, record=8
    )
    at = branch["x2"].values[np.abs(branch["spring1_gap"].values - 0.3).argmin()]
    assert abs(diagram["x2"].isel(parameter=1) - float(orbit["x2"])).max() < 1e-6
    assert abs(at - float(orbit["x2"])) < 0.1


# ---------------------------------------------------------------- speed


def rotor_with(bearing):
    mass = np.diag([2.0, 2.0, 1.0, 1.0])
    plane = np.array([[50.0, -50.0], [-50.0, 50.0]])
    gyroscopic = np.zeros((4, 4))
    gyroscopic[2, 3], gyroscopic[3, 2] = 0.3, -0.3
    return ns.Structure(
        mass,
        np.kron(plane, np.eye(2)),
        damping=0.3 * np.eye(4),
        gyroscopic=gyroscopic,
        coordinates=["1x", "1y", "2x", "2y"],
        bearings=[bearing],
    )


SPEEDS = [0.5, 2.0, 3.0, 6.0]
TABLE = np.array([[[k, 0.1 * k], [-0.05 * k, 1.3 * k]] for k in (60.0, 80.0, 95.0, 110.0)])
TABULATED = ns.structures.Bearing(["1x", "1y"], TABLE, 0.05 * TABLE, speeds=SPEEDS)
FORMULA = ns.structures.Bearing(
    ["1x", "1y"],
    lambda speed: np.array([[60 + 5 * speed, speed], [-speed, 70 + speed**2]]),
    lambda speed: 3 + np.exp(-speed),
)


@pytest.mark.parametrize("bearing", [TABULATED, FORMULA])
@pytest.mark.parametrize("method", ["free-interface", "craig-bampton"])
def test_response_with_bearings_that_depend_on_the_speed(bearing, method):
    structure = rotor_with(bearing)
    whole = reduce(structure, ["2x", "2y"], modes=4, speeds=1.0, method=method)
    system = machine(whole, loads=[Unbalance("2x", "2y", 0.01)], Omega=1.0, speed_range=(0.5, 6.0))
    for speed in (0.7, 2.0, 2.6, 5.5):
        mass, damping, stiffness = structure.at_speed(speed)
        force = 0.01 * speed**2 * np.array([0, 0, 1, -1j])
        amplitude = np.linalg.solve(stiffness + 1j * speed * damping - speed**2 * mass, force)
        orbit = ns.find_orbit(system.with_parameters(Omega=speed))
        states = {name: float(orbit[name]) for name in system.states}
        run = ns.simulate(system.with_parameters(Omega=speed), states, periods=1)
        for i, name in enumerate(("x1", "y1", "x2", "y2")):
            # polynomials stand for the function, right to 1e-10 of its largest value
            assert abs(float(run[name][0]) - amplitude[i].real) < 1e-8 * abs(amplitude[i])


@pytest.mark.slow
def test_a_run_up_takes_the_coefficients_of_each_revolution():
    structure = rotor_with(TABULATED)
    system = machine(
        structure, [GapSpring("2x", 0.005, 40.0)], [Unbalance("2x", "2y", 0.5)], Omega=1.0
    )
    from dataclasses import replace

    up = ns.simulate(replace(system, slow={"Omega": "1 + t/40"}), periods=12, samples_per_period=4)
    state, time = np.zeros(8), 0.0
    for _ in range(12):
        speed = 1 + time / 40
        mass, damping, stiffness = structure.at_speed(speed)
        inverse = np.linalg.inv(mass)

        def rates(t, y, speed=speed, d=damping, k=stiffness, m=inverse, t0=time):
            q, v = y[:4], y[4:]
            angle = speed * (t - t0)
            force = 0.5 * speed**2 * np.array([0, 0, np.cos(angle), np.sin(angle)])
            force[2] -= 40 * max(q[2] - 0.005, 0.0)
            return np.concatenate([v, m @ (force - d @ v - k @ q)])

        solved = solve_ivp(
            rates, (time, time + 2 * np.pi / speed), state, method="DOP853",
            rtol=1e-12, atol=1e-14, max_step=0.01,
        )  # fmt: skip
        state, time = solved.y[:, -1], solved.t[-1]
    assert up.attrs["n_events"] > 10
    assert abs(float(up["time"][-1]) - time) < 1e-9
    for i, name in enumerate(("x1", "y1", "x2", "y2")):
        # scipy steps over the corners of the force, at most 0.01 long
        assert abs(float(up[name][-1]) - state[i]) < 1e-7


@pytest.mark.slow
def test_a_ring_on_a_shaft_with_long_tables_is_read_once():
    """Each equation of the machine has all coefficients of both bearings in it."""
    speeds = np.linspace(0.0, 600.0, 30)
    table = 1e7 * (np.eye(2) + 0.1 * np.random.default_rng(1).random((30, 2, 2)))
    held = [Bearing([f"{i}x", f"{i}y"], table, 1e-3 * table, speeds=speeds) for i in (0, 12)]
    small = reduce(shaft([Beam(0.1, 0.05)] * 12, bearings=held), ["6x", "6y"], modes=14)
    ring = RubRing("6x", "6y", gap=1e-4, stiffness=1e7)
    with calls_at_most(6_000_000):  # 2.9 million; 13.9 million if each equation reads its own
        machine(small, [ring], [Unbalance("6x", "6y", 1e-3)], Omega=100.0)


def test_waterfall_has_the_unbalance_response_where_nothing_touches():
    structure = rotor_with(TABULATED)
    system = machine(
        structure, [GapSpring("2x", 9.0, 40.0)], [Unbalance("2x", "2y", 0.05)], Omega=1.0
    )
    speeds = [1.5, 3.5]
    found = ns.waterfall(
        system, "Omega", speeds, ("x2", "y2"), transient=200, record=20, window="boxcar"
    )
    lines = found["amplitude"]
    for i, speed in enumerate(speeds):
        mass, damping, stiffness = structure.at_speed(speed)
        force = 0.05 * speed**2 * np.array([0, 0, 1, -1j])
        u = np.linalg.solve(stiffness + 1j * speed * damping - speed**2 * mass, force)
        forward, backward = abs(u[2] + 1j * u[3]) / 2, abs(u[2].conj() + 1j * u[3].conj()) / 2
        each = lines.isel(parameter=i)
        assert abs(float(each.sel(harmonic=1)) - forward) < 1e-9
        assert abs(float(each.sel(harmonic=-1)) - backward) < 1e-9


# ---------------------------------------------------------------- what is refused


def test_faults_name_what_is_wrong():
    structure, names = chain_structure(30)
    small = reduce(structure, [names[-1]], modes=4)
    with pytest.raises(ns.ModelError, match="does not keep the coordinate '3x'"):
        machine(small, [GapSpring("3x", 0.1, 1.0)])
    with pytest.raises(ns.OptionError, match="unknown coordinate '99x'"):
        machine(small, [GapSpring("99x", 0.1, 1.0)])
    with pytest.raises(ns.ModelError, match="two contacts or loads are called 'a'"):
        machine(small, [GapSpring("29x", 0.1, 1.0, name="a"), GapSpring("29x", 0.2, 1.0, name="a")])
    with pytest.raises(ns.OptionError, match="contacts: 3 is none; give some of Stop"):
        machine(small, [3])
    with pytest.raises(ns.OptionError, match="Omega: give the speed"):
        machine(small, loads=[Unbalance("1x", "2x", 1.0)])
    with pytest.raises(ns.ModelError, match=r"spring1_stiffness >= 0 is required"):
        machine(small, [GapSpring("29x", 0.1, -1.0)])
    with pytest.raises(ns.ModelError, match=r"side='left' is not known"):
        GapSpring("29x", 0.1, 1.0, side="left")
    with pytest.raises(ns.ModelError, match="speed_range: the bearing at 1x, 1y is a function"):
        machine(rotor_with(FORMULA), Omega=1.0)
    with pytest.raises(ns.ModelError, match=r"Omega <= 6.0 is required"):
        machine(rotor_with(TABULATED), Omega=7.0)
    ring = {"gap": 0.1, "stiffness": 5.0}
    for kind in (RubRing("29x", "29x", **ring), SnubberRing("29x", "29x", damping=1.0, **ring)):
        with pytest.raises(ns.ModelError, match=r"(rub|ring)1: x and y are both '29x'"):
            machine(small, [kind])
    with pytest.raises(ns.ModelError, match=r"Omega > 0 is required, Omega = -3 was given: the"):
        machine(small, loads=[Unbalance("28x", "29x", 1.0)], Omega=-3.0)
    large = ns.Structure(np.eye(300), np.eye(300))
    with pytest.raises(ns.OptionError, match="at most 255 can run"):
        machine(large)


def overhung(modes):
    """A disc beside two bearings, whose highest modes die away within a few revolutions."""
    rotor = shaft(
        [Beam(0.1, 0.04)] * 8,
        discs=[Disc(8, 25.0, 0.35, 0.65)],
        bearings=[Bearing([f"{node}x", f"{node}y"], 7e6, 150.0) for node in (0, 5)],
    )
    return reduce(rotor, ["8x", "8y"], modes=modes)


@pytest.mark.parametrize("modes", [2, 12])
@pytest.mark.parametrize("transient", [0, 200])
def test_the_orbit_of_a_linear_rotor_is_that_of_its_matrices(modes, transient):
    """Also from a settled motion, in which high modes have almost no size."""
    rotor = machine(overhung(modes), [], [Unbalance("8x", "8y", 1e-3)], Omega=590.0)
    for speed in (200.0, 400.0, 590.0):
        orbit = ns.find_orbit(rotor, parameters={"Omega": speed}, transient=transient)
        assert orbit.attrs["status"] == "completed"
        run = ns.simulate(rotor, orbit, periods=1, parameters={"Omega": speed})
        for name in rotor.states:
            size = float(np.abs(run[name]).max())
            assert float(run[name][-1]) == pytest.approx(float(orbit[name]), abs=1e-8 * size)


@pytest.mark.parametrize(
    ("contact", "said"),
    [
        (
            GapSpring("x", gap=-0.1, stiffness=8.0, side="both"),
            "overlap are two contacts",
        ),
        (Stop("x", gap=0.1, restitution=1.5), "an impact adds no energy"),
    ],
)
def test_contacts_that_would_not_be_what_they_say(contact, said):
    mass = ns.Structure([[1.0]], [[1.0]], coordinates=["x"])
    with pytest.raises(ns.ModelError, match=said):
        machine(mass, [contact])


def test_a_number_of_a_part_is_given_once():
    mass = ns.Structure([[1.0]], [[1.0]], coordinates=["x"])
    spring = GapSpring("x", gap=0.1, stiffness=8.0)
    with pytest.raises(ns.OptionError, match="'spring1_gap' is a number of a contact or load"):
        machine(mass, [spring], parameters={"spring1_gap": 3.0})


def test_a_speed_beyond_those_of_the_estimate_is_told():
    load = Unbalance("8x", "8y", 1e-3)
    small = reduce(overhung(2).structure, ["8x", "8y"], frequency_range=(0, 3000))
    with pytest.warns(ns.ResultWarning, match="estimated at speeds up to 0 rad/s"):
        machine(small, [], [load], Omega=1400.0)
