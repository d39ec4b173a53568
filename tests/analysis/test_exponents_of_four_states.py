"""All exponents of systems of four states: closed forms, another integrator, and what they cost."""

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

import nonsmooth as ns
from effort import calls_at_most

PERIOD, FORCE, COUPLING, DAMPING, RESTITUTION, WALL = 5.5, 1.0, 0.8, 0.06, 0.6, 0.3
PERIODS = 60

MATRIX = np.array(
    [
        [0.0, 1.0, 0.0, 0.0],
        [-1.0 - COUPLING, -2 * DAMPING, COUPLING, 0.0],
        [0.0, 0.0, 0.0, 1.0],
        [COUPLING, 0.0, -1.0 - COUPLING, -2 * DAMPING],
    ]
)


def two_masses() -> ns.System:
    """Two coupled masses, of which the first one hits a wall."""
    return ns.System(
        name="two_masses",
        states=["x", "v", "y", "u"],
        period="T",
        parameters={
            "T": PERIOD, "F": FORCE, "k": COUPLING, "d": DAMPING, "r": RESTITUTION, "w": WALL,
        },
        modes={
            "free": ns.Mode(
                {
                    "x": "v",
                    "v": "F*cos(2*pi/T*t) - (1 + k)*x + k*y - 2*d*v",
                    "y": "u",
                    "u": "k*x - (1 + k)*y - 2*d*u",
                },
                exits=[ns.Exit("w - x", reset={"v": "-r*v"}, name="impact")],
            )
        },
    )  # fmt: skip


def logarithms_by_matrices(skipped: int, count: int, steps: int = 100) -> np.ndarray:
    """Logarithms of R, period by period: exponentials of matrices, bisection, saltation.

    The force is a pair of states of its own, so each piece is one exponential.
    """
    generator = np.zeros((6, 6))
    generator[:4, :4] = MATRIX
    generator[1, 4] = FORCE
    generator[4, 5], generator[5, 4] = -2 * np.pi / PERIOD, 2 * np.pi / PERIOD
    h = PERIOD / steps
    whole = expm(generator * h)
    z, columns = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0]), np.eye(4)
    rows = []
    for k in range((skipped + count) * steps):
        left, propagator = h, whole
        while (propagator @ z)[0] > WALL:
            until = brentq(
                lambda s, at=z: (expm(generator * s) @ at)[0] - WALL, 1e-12, left, xtol=1e-15
            )
            flown = expm(generator * until)
            before = flown @ z
            z = before.copy()
            z[1] *= -RESTITUTION
            jump = np.diag([1.0, -RESTITUTION, 1.0, 1.0])
            gap = (generator @ z)[:4] - jump @ (generator @ before)[:4]
            jump += np.outer(gap, [1.0, 0.0, 0.0, 0.0]) / before[1]
            columns = jump @ flown[:4, :4] @ columns
            left -= until
            propagator = expm(generator * left)
        z, columns = propagator @ z, propagator[:4, :4] @ columns
        if (k + 1) % steps == 0:
            columns, triangle = np.linalg.qr(columns)
            rows.append(np.log(np.abs(np.diag(triangle))))
    return np.array(rows[skipped:])


def test_exponents_are_those_of_another_integrator():
    """Both run the same record from the same start, so only the directions differ at first."""
    found = ns.lyapunov_spectrum(
        two_masses(), {"x": 0.0, "v": 0.0}, transient=PERIODS, record=PERIODS
    )
    assert found.attrs["n_impacts"] >= PERIODS / 2
    rows = logarithms_by_matrices(PERIODS, PERIODS)
    wanted = np.sort(rows.sum(axis=0))[::-1] / (PERIODS * PERIOD)
    # of pairs that turn, a start in other directions leaves a factor between the columns
    np.testing.assert_allclose(
        found["lyapunov_exponent"], wanted, rtol=0, atol=2.0 / (PERIODS * PERIOD)
    )
    assert abs(float(found["exponent_sum"]) - wanted.sum()) < 1e-9


def test_sum_counts_impacts():
    """Each impact multiplies volumes by r^2, damping by exp(-4 d t)."""
    found = ns.lyapunov_spectrum(two_masses(), transient=20, record=100)
    assert found.attrs["n_impacts"] >= 50
    rate = found.attrs["n_impacts"] / found.attrs["duration"]
    wanted = 2 * np.log(RESTITUTION) * rate - 4 * DAMPING
    assert abs(float(found["exponent_sum"]) - wanted) < 1e-10


def test_eigenvalues_of_a_linear_system():
    """Real and apart, so after the transient each column grows by its own eigenvalue alone."""
    values = np.array([-0.1, -0.9, -1.9, -3.1])
    vectors = np.array([[1, 2, 0, 1], [0, 1, 3, 1], [2, 0, 1, 1], [1, 1, 1, 3.0]])
    matrix = vectors @ np.diag(values) @ np.linalg.inv(vectors)
    names = ["a", "b", "c", "d"]
    rows = [
        [f"({entry!r})*{name}" for entry, name in zip(row, names, strict=True)]
        for row in matrix.tolist()
    ]
    equations = {name: " + ".join(row) for name, row in zip(names, rows, strict=True)}
    system = ns.System(states=names, equations=equations)
    found = ns.lyapunov_spectrum(system, {"a": 1.0}, transient=50.0, record=100.0)
    # The gap of 0.8 leaves exp(-40) of the directions at the start. Columns part by a factor of 1e6
    # between two looks, which costs as much of 1e-16, in times of ln(1e6) / 3.
    np.testing.assert_allclose(found["lyapunov_exponent"], values, rtol=0, atol=1e-10)


def test_all_exponents_cost_few_calls():
    """The engine keeps the columns orthonormal, so Python does next to nothing in a period."""
    mole = ns.models.moling()
    ns.lyapunov_spectrum(mole, transient=0, record=10)
    with calls_at_most(60_000):
        ns.lyapunov_spectrum(mole, transient=0, record=1000)
