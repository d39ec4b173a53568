"""What errors of forces bring to a record, beside motions of scipy with such forces."""

import numpy as np
import pytest

import nonsmooth as ns
from fitting.truth import RIGID, SOFT, dataset, rigid_motion, soft_motion
from nonsmooth.fitting.channels import check_free, read_channels
from nonsmooth.fitting.force_errors import force_errors
from nonsmooth.fitting.linearised import free_jacobian
from nonsmooth.fitting.record_equations import RecordEquations
from nonsmooth.fitting.shooting import Shooting
from nonsmooth.fitting.solver import Fitted, UnmatchedEvents

NOISE = 0.01
STEP = 1e-4  # of a coefficient: truncation is of its square, the integrator errs by 1e-11/STEP
TIMES = np.linspace(0.0, 15.0, 201)  # of which four segments begin at samples
START = [0.1, 0.2]


def at_truth(system, free, shown, states, n_segments):
    """Equations of a record at the parameters that made it, whose gaps are closed.

    states: of the motion at the starts of the segments, (M, n)
    """
    channels = read_channels(system, dataset(TIMES, x=shown), {"x": "x"}, {
        "gain": None, "offset": None, "delay": None}, NOISE)  # fmt: skip
    bounds = np.linspace(TIMES[0], TIMES[-1], n_segments + 1)
    record = RecordEquations(system, tuple(free), channels, TIMES, bounds, 1e-12)
    shooting = Shooting([record], list(check_free(system, free).values()), [""])
    head = shooting.head_of(np.array([system.parameter_values[name] for name in free]))
    u, noise = shooting.join(head, states), np.array([NOISE])
    found = shooting.evaluate(u, noise)
    assert found is not None
    gaps = np.zeros((shooting.n_gaps, shooting.n))
    return shooting, Fitted(u, 0.0, UnmatchedEvents(0.0, 0.0), noise, gaps, found, True, 1)


def rigid(cubic):
    """A mass that rebounds from a wall, with a spring that is slightly cubic."""
    return rigid_motion(TIMES, START, cubic=cubic)


def soft(cubic):
    """A mass that meets a second spring, likewise."""
    return soft_motion(TIMES, START, cubic=cubic)


@pytest.mark.few(1)
@pytest.mark.parametrize("n_segments", [1, 4])
@pytest.mark.parametrize(
    ("motion", "system", "free"),
    [
        (rigid, ns.models.impact_oscillator(**RIGID), {"r": (0.5, 0.95), "sigma": (0.35, 0.6)}),
        (soft, ns.models.soft_impact(**SOFT), {"beta": (15, 45), "e": (0.9, 1.6)}),
    ],
    ids=["rigid", "soft"],
)
def test_a_cubic_spring_changes_a_motion_as_the_columns_say(motion, system, free, n_segments):
    """A cube is a sum of terms up to the third degree, of the position and of nothing else.

    What unknowns of the fit can change is taken out of both sides, since columns are given up to
    that. Central differences are good to 1e-6.
    """
    x, v, _, _ = motion(0.0)
    begun = np.arange(n_segments) * 200 // n_segments
    states = np.stack([x, v], axis=1)[begun]
    shooting, fitted = at_truth(system, free, x, states, n_segments)
    assert np.abs(fitted.evaluation.gap).max(initial=0.0) < 1e-6
    forces = force_errors(shooting, fitted)
    change = (motion(STEP)[0] - motion(-STEP)[0]) / (2.0 * STEP) / NOISE
    unknown = np.linalg.qr(free_jacobian(shooting, fitted.evaluation)[0])[0]

    def beyond(values):
        return values - unknown @ (unknown.T @ values)

    columns = beyond(np.concatenate([forces.linear, forces.nonlinear], axis=1))
    expected = beyond(change)
    parts = np.linalg.lstsq(columns, expected, rcond=1e-10)[0]
    left = expected - columns @ parts
    assert np.abs(left).max() < 1e-5 * np.abs(expected).max()
    # 201 samples are not explained by any 11 columns
    wrong = columns[::-1]
    other = expected - wrong @ np.linalg.lstsq(wrong, expected, rcond=1e-10)[0]
    assert np.abs(other).max() > 0.05 * np.abs(expected).max()


def test_a_wrong_mass_is_the_first_of_the_linear_terms():
    """A mass that is heavier by a share moves as if force and springs were weaker by that share."""
    system = ns.System(
        states=["x", "v"],
        parameters={"k": 4.0, "c": 0.1, "m": 1.0},
        equations={"x": "v", "v": "(cos(t) - k*x - c*v)/m"},
    )
    free = {"m": (0.5, 2.0), "k": (1.0, 9.0)}
    x = np.cos(2.0 * TIMES)
    shooting, fitted = at_truth(system, free, x, np.array([START]), 1)
    forces = force_errors(shooting, fitted)
    assert forces.n_masses == 1
    assert forces.linear.shape[1] == 4 and forces.nonlinear.shape[1] == 7
    own = fitted.evaluation.rows.head[:, 0] / shooting.head_units()[0]  # by the mass
    np.testing.assert_allclose(forces.linear[:, 0], -own, rtol=1e-6, atol=1e-7 * np.abs(own).max())


def test_models_without_masses_or_with_many_have_none():
    slow = ns.System(states=["x"], parameters={"k": 1.0}, equations={"x": "1 - k*x"})
    shooting, fitted = at_truth(slow, {"k": (0.5, 2.0)}, np.exp(-TIMES), np.array([[0.3]]), 1)
    assert force_errors(shooting, fitted) is None
    names = range(7)
    chain = ns.System(
        states=[f"{letter}{k}" for k in names for letter in "xv"],
        parameters={"k": 1.0},
        equations={f"x{k}": f"v{k}" for k in names} | {f"v{k}": f"-k*x{k}" for k in names},
        outputs={"x": "x0"},
    )
    start = np.tile([0.3, 0.1], 7)[None]
    shooting, fitted = at_truth(chain, {"k": (0.5, 2.0)}, np.cos(TIMES), start, 1)
    assert force_errors(shooting, fitted) is None
