"""Rotors by matrices: the chapter's one, gyroscopic whirl, a beam beside scipy, units, files."""

from itertools import pairwise

import numpy as np
import pytest
import scipy.io
import scipy.sparse
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.models import MatrixRotor, rotor

PLAIN = {"mass": np.eye(2), "stiffness": np.eye(2), "ring": (0, 1)}


def jeffcott(**changes):
    words = PLAIN | {"damping": 0.25 * np.eye(2), "unbalance": [(0, 1, 0.0017 * 70)]}
    return MatrixRotor(**(words | changes))


RING = {"Omega": 2.442, "k_s": 30, "c_s": 0.004, "eps_x": 0.9, "delta_x": 0.1, "delta_y": 0.1}


def beam(elements=3):
    """Matrices of a slender shaft in two planes on pins, of length, EI and mass 1.

    Degrees of freedom of a node in order: deflection and slope in x, then in y.
    """
    h = 1 / elements
    k = np.array(
        [
            [12, 6 * h, -12, 6 * h],
            [6 * h, 4 * h**2, -6 * h, 2 * h**2],
            [-12, -6 * h, 12, -6 * h],
            [6 * h, 2 * h**2, -6 * h, 4 * h**2],
        ]
    ) / (h**3)
    m = np.array(
        [
            [156, 22 * h, 54, -13 * h],
            [22 * h, 4 * h**2, 13 * h, -3 * h**2],
            [54, 13 * h, 156, -22 * h],
            [-13 * h, -3 * h**2, -22 * h, 4 * h**2],
        ]
    ) * (h / 420)
    n = 4 * (elements + 1)
    mass, stiffness = np.zeros((n, n)), np.zeros((n, n))
    for e in range(elements):
        for plane in (0, 2):
            at = [4 * e + plane + i for i in (0, 1, 4, 5)]
            mass[np.ix_(at, at)] += m
            stiffness[np.ix_(at, at)] += k
    held = [0, 2, n - 4, n - 2]
    free = [i for i in range(n) if i not in held]
    return mass[np.ix_(free, free)], stiffness[np.ix_(free, free)]


@pytest.mark.slow
def test_two_degrees_of_freedom_are_the_chapters_rotor():
    one = ns.simulate(jeffcott().system(**RING), {"q0": -0.9}, periods=10)
    two = ns.simulate(rotor(), periods=10)
    assert one.attrs["phase_word"] == two.attrs["phase_word"]
    assert one.attrs["n_events"] > 10
    assert np.abs(one["event_time"].values - two["event_time"].values).max() < 1e-12
    for name in ("x", "y", "vx", "vy", "sx", "sy", "mu", "energy", "gap"):
        assert np.abs(one[name].values - two[name].values).max() < 1e-12
    assert np.abs(one["force"].values - two["force"].values).max() < 1e-11


def test_units_do_not_matter():
    """The rotor in kg, N/m and mm with its own mass, stiffness and gap."""
    M, k, gamma = 9.7, 79e3, 0.5
    rate = np.sqrt(k / M)
    critical = 2 * np.sqrt(k * M)
    machine = MatrixRotor(
        mass=M * np.eye(2),
        stiffness=k * np.eye(2),
        damping=0.125 * critical * np.eye(2),
        ring=(0, 1),
        unbalance=[(0, 1, 0.119 * M * gamma)],
    )
    system = machine.system(
        Omega=2.442 * rate,
        k_s=30 * k,
        c_s=0.002 * critical,
        gamma=gamma,
        eps_x=0.9 * gamma,
        delta_x=0.1 * gamma,
        delta_y=0.1 * gamma,
    )
    one = ns.simulate(system, {"q0": -0.9 * gamma}, periods=5)
    two = ns.simulate(rotor(), periods=5)
    assert np.abs(one["x"].values / gamma - two["x"].values).max() < 1e-12
    assert np.abs(one["force"].values / (k * gamma) - two["force"].values).max() < 1e-11
    assert np.abs(one["energy"].values / (k * gamma**2) - two["energy"].values).max() < 1e-12


@pytest.mark.parametrize("forward", [True, False])
def test_gyroscopic_whirl_has_its_two_frequencies(forward):
    """z = x + i y: z'' - i Omega g z' + k z = 0, so w^2 - Omega g w - k = 0."""
    speed, g, k = 3.0, 0.4, 2.0
    turn = np.array([[0.0, g], [-g, 0.0]])
    machine = MatrixRotor(mass=np.eye(2), stiffness=k * np.eye(2), gyroscopic=turn, ring=(0, 1))
    w = speed * g / 2 + (1 if forward else -1) * np.hypot(speed * g / 2, np.sqrt(k))
    system = machine.system(Omega=speed, k_s=10, c_s=0.01)
    run = ns.simulate(system, {"q0": 0.5, "v1": 0.5 * w}, t_end=20)
    z = run["x"].values + 1j * run["y"].values
    assert run.attrs["n_events"] == 0
    assert np.abs(z - 0.5 * np.exp(1j * w * run["time"].values)).max() < 1e-13


@pytest.mark.slow
def test_unbalances_and_load_act_where_they_are():
    """Synchronous whirl of a coupled rotor, from the complex response of its matrices."""
    generator = np.random.default_rng(5)
    half = generator.normal(size=(4, 4))
    mass = half @ half.T + 2 * np.eye(4)
    other = generator.normal(size=(4, 4))
    stiffness = other @ other.T + 5 * np.eye(4)
    damping, load = 0.5 * mass, generator.normal(size=4)
    machine = MatrixRotor(
        mass=mass,
        stiffness=stiffness,
        damping=damping,
        ring=(0, 2),
        unbalance=[(0, 2, 0.3), (3, 1, 0.2, 0.7)],
        load=load,
    )
    speed, phi0 = 1.3, 0.4
    force = np.array([0.3, -0.2j * np.exp(0.7j), -0.3j, 0.2 * np.exp(0.7j)]) * np.exp(1j * phi0)
    swing = np.linalg.solve(stiffness - speed**2 * mass + 1j * speed * damping, speed**2 * force)
    system = machine.system(Omega=speed, k_s=1, c_s=1, gamma=100, phi0=phi0)
    rest = np.linalg.solve(stiffness, load)
    start = {f"q{i}": value for i, value in enumerate(rest + swing.real)}
    start |= {f"v{i}": value for i, value in enumerate((1j * speed * swing).real)}
    run = ns.simulate(system, start, periods=3)
    for i in range(4):
        exact = rest[i] + (swing[i] * np.exp(1j * speed * run["time"].values)).real
        assert np.abs(run[f"q{i}"].values - exact).max() < 1e-12


@pytest.mark.slow
def test_a_beam_in_the_ring_against_scipy():
    """Four nodes; without preload the ring stands radially, with its force in closed form."""
    mass, stiffness = beam()
    n = len(mass)
    assert n == 12
    first = np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real.min())
    assert first == pytest.approx(np.pi**2, rel=1e-3)
    damping, i, j = 2e-3 * stiffness, 1, 3  # deflections of the second node
    machine = MatrixRotor(
        mass=mass, stiffness=stiffness, damping=damping, ring=(i, j), unbalance=[(5, 7, 0.02)]
    )
    speed, k_s, c_s, gamma, eps = 9.0, 800.0, 0.5, 0.06, 0.03
    system = machine.system(Omega=speed, k_s=k_s, c_s=c_s, gamma=gamma, eps_x=eps)
    run = ns.simulate(system, periods=4, tangent=True)
    assert run.attrs["n_events"] > 4
    inverse = np.linalg.inv(mass)

    def field(t, state, touching):
        q, v = state[:n], state[n:]
        f = -stiffness @ q - damping @ v
        f[5] += 0.02 * speed**2 * np.cos(speed * t)
        f[7] += 0.02 * speed**2 * np.sin(speed * t)
        if touching:
            z, dz = q[i] + eps + 1j * q[j], v[i] + 1j * v[j]
            r = abs(z)
            dr = (z.conjugate() * dz).real / r
            push = k_s * z * (1 - gamma / r) + c_s * (dz * (1 - gamma / r) + z * gamma * dr / r**2)
            f[i] -= push.real
            f[j] -= push.imag
        return np.concatenate([v, inverse @ f])

    state = np.zeros(2 * n)
    cuts = [*run["event_time"].values, float(run["time"][-1])]
    words = run["event_to"].attrs["flag_meanings"].split()
    for mode, (begin, end) in zip(run["event_to"].values, pairwise(cuts), strict=True):
        touching = words[mode] != "free"
        options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14, "args": (touching,)}
        state = solve_ivp(field, (begin, end), state, **options).y[:, -1]
    growth = np.abs(run["tangent"].values).max()
    assert np.abs(run["end_state"].values[: 2 * n] - state).max() < 1e-11 * growth


@pytest.mark.slow
def test_files_hold_the_same_rotor(tmp_path):
    mass, stiffness = beam(2)
    np.savez(tmp_path / "all.npz", mass=mass, stiffness=stiffness)
    np.save(tmp_path / "m.npy", mass)
    np.savetxt(tmp_path / "m.csv", mass, delimiter=",", fmt="%.17g")
    scipy.io.mmwrite(tmp_path / "k.mtx", scipy.sparse.csr_array(stiffness), precision=17)
    made = MatrixRotor(mass=mass, stiffness=scipy.sparse.csr_array(stiffness), ring=(1, 2))
    system = made.system(**RING)
    others = [
        MatrixRotor.from_file(tmp_path / "all.npz", ring=(1, 2)),
        MatrixRotor(mass=tmp_path / "m.npy", stiffness=tmp_path / "k.mtx", ring=(1, 2)),
        MatrixRotor(mass=str(tmp_path / "m.csv"), stiffness=stiffness, ring=(1, 2)),
    ]
    for other in others:
        assert other.system(**RING) == system
    assert ns.System.from_toml(system.to_toml()) == system


def test_every_name_has_a_label():
    system = jeffcott().system(**RING)
    names = {*system.states, *system.outputs, *system.parameters}
    assert names <= set(system.describe) <= names


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"mass": np.ones((2, 3))}, r"mass has shape \(2, 3\)"),
        ({"mass": np.ones((2, 2))}, "mass is singular"),
        ({"mass": [[1, 2], [3]]}, "mass: a matrix has real numbers"),
        ({"mass": [["a", "b"], ["c", "d"]]}, "mass: a matrix has real numbers"),
        ({"mass": np.eye(2) * 1j}, "mass: a matrix has real numbers"),
        ({"mass": np.eye(30)}, "at most 26 degrees"),
        ({"stiffness": np.eye(3)}, "stiffness is 3 x 3 and the mass matrix 2 x 2"),
        ({"stiffness": None}, "stiffness: a matrix has"),
        ({"damping": [[0, np.nan], [0, 0]]}, r"damping\[0, 1\] = nan is not finite"),
        ({"gyroscopic": np.eye(2)}, "not skew-symmetric"),
        ({"ring": (0, 2)}, "no degree of freedom 2; they are 0 to 1"),
        ({"ring": (1, 1)}, "one degree of freedom, 1"),
        ({"ring": "xy"}, "give two degrees of freedom"),
        ({"unbalance": [(0, 1)]}, r"unbalance\[0\] .*give"),
        ({"unbalance": [(0, 1, 1, 0, 5)]}, r"unbalance\[0\] .*give"),
        ({"unbalance": [(0, 1, np.inf)]}, r"unbalance\[0\] = .*finite numbers"),
        ({"unbalance": [(0, 1, 1), (0, 7, 1)]}, r"unbalance\[1\]: there is no"),
        ({"load": [1.0]}, "load has 1 numbers for 2"),
        ({"load": [1.0, np.nan]}, "load = .*give a finite number for each degree"),
    ],
)
def test_wrong_data_is_refused_with_the_reason(changes, match):
    with pytest.raises(ns.ModelError, match=match):
        jeffcott(**changes)


def test_files_that_cannot_be_read_are_refused(tmp_path):
    (tmp_path / "bad.csv").write_text("1,2\n3,x\n")
    (tmp_path / "bad.npz").write_bytes(b"no archive")
    (tmp_path / "text.npy").write_text("1,2")
    (tmp_path / "bad.mtx").write_text("nothing")
    np.save(tmp_path / "object.npy", np.array([[{}]], dtype=object))
    np.savez(tmp_path / "few.npz", mass=np.eye(2))
    np.savez(tmp_path / "more.npz", mass=np.eye(2), stiffness=np.eye(2), K=np.eye(2))
    for name, match in (
        ("bad.csv", "bad.csv cannot be read"),
        ("bad.mtx", "bad.mtx cannot be read"),
        ("object.npy", "object.npy holds Python objects"),
        ("none.npy", "none.npy cannot be read"),
        ("text.npy", r"text.npy cannot be read: it is no .npy file$"),
        ("m.txt", "none of the suffixes"),
        ("all.npz", "MatrixRotor.from_file"),
    ):
        with pytest.raises(ns.ModelError, match=match):
            jeffcott(mass=tmp_path / name)
    for name, match in (
        ("bad.npz", r"cannot be read as .npz: it is no archive of arrays$"),
        ("object.npy", "cannot be read as .npz"),
        ("none.npz", r"there is no file or folder .*none.npz"),
        ("few.npz", "no array 'stiffness'"),
        ("more.npz", "array 'K' has no meaning"),
    ):
        with pytest.raises(ns.ModelError, match=match):
            MatrixRotor.from_file(tmp_path / name, ring=(0, 1))


@pytest.mark.parametrize("name", ["Omega", "k_s", "gamma"])
def test_impossible_rings_are_refused(name):
    with pytest.raises(ns.ModelError, match=f"{name} > 0"):
        jeffcott().system(**(RING | {name: 0}))
