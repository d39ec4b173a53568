"""The two-mass rig against 50 digits, the printed equations, and the file of examples.

Tolerance 1e-10 over five periods: rates reach 3e4, a motion contracts, and the exact flow loses
some hundred roundings per segment; 1e-12 is what is met.
"""

import itertools
from fractions import Fraction

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.integrate import solve_ivp

import nonsmooth as ns
from contract.rig import DIGITS, automaton, rig
from models.fatigue_truth import (
    FIGURE_25,
    PHASES,
    STATES,
    compact_rates,
    cracked_automaton,
    other_names,
    printed_rates,
    printed_system,
    statics,
)
from nonsmooth.models import fatigue_rig
from reference.hybrid import hybrid_run
from reference.modal import first_crossing

CASES = [{}, FIGURE_25]


def switches(run):
    """(name of the cell entered, time) of events that are none of a start."""
    names = run["event_to"].attrs["flag_meanings"].split()
    rows = zip(
        run["event_kind"].values, run["event_to"].values, run["event_time"].values, strict=True
    )
    return [(names[int(to)], float(time)) for kind, to, time in rows if kind != "start"]


def phases_along(run):
    """Name of the phase at each sample."""
    names = run["mode"].attrs["flag_meanings"].split()
    return [names[int(number)] for number in run["mode"].values]


def compare(run, true, renamed):
    assert run.attrs["status"] == "completed" and run.attrs["n_uncertain"] == 0
    own = switches(run)
    assert [name for name, _ in own] == [renamed(e.mode_to) for e in true.events]
    times = [float(e.time) for e in true.events]
    assert np.abs(np.subtract([t for _, t in own], times)).max() < 1e-10
    found = np.array([float(run[name][-1]) for name in STATES])
    assert np.abs(found - [float(x) for x in true.state[:5]]).max() < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "periods"),
    [
        pytest.param({}, 2, id="Fig. 24", marks=pytest.mark.slow),
        pytest.param({}, 5, id="Fig. 24, longer", marks=pytest.mark.slow),
        pytest.param(FIGURE_25, 5, id="Fig. 25"),
    ],
)
def test_periods_from_rest_against_fifty_digits(changes, periods):
    system = fatigue_rig(**changes)
    p = system.parameter_values
    with mp.workdps(DIGITS):
        end = 2 * mp.pi / mpf(p["eta"]) * periods
        modes = automaton(other_names(p))
        true = hybrid_run(modes, [0] * 5 + [1, 0, 1], "both", end, search=first_crossing)
    run = ns.simulate(system, periods=periods, samples_per_period=1)
    compare(run, true, PHASES.get)
    assert len(true.events) >= 2 * periods


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.6, pytest.param(0.2, marks=pytest.mark.slow)])
def test_a_crack_against_fifty_digits(ratio):
    system = fatigue_rig(**FIGURE_25 | {"f1": 4.5, "open_stiffness": ratio})
    p = system.parameter_values
    with mp.workdps(DIGITS):
        end = 2 * mp.pi / mpf(p["eta"]) * 2
        modes = cracked_automaton(p)
        true = hybrid_run(modes, [0] * 5 + [1, 0, 1], "i+", end, search=first_crossing)
    run = ns.simulate(system, periods=2, samples_per_period=1)
    compare(run, true, lambda name: name.rstrip("+-"))
    assert {e.mode_to[-1] for e in true.events} == {"+", "-"}


@pytest.mark.parametrize("changes", CASES)
def test_the_file_of_examples_is_the_same_rig(changes):
    model = fatigue_rig(**changes)
    file = rig(**other_names(model.parameter_values))
    one, other = (ns.simulate(system, periods=10) for system in (model, file))
    assert [n for n, _ in switches(one)] == [PHASES[n] for n, _ in switches(other)]
    for name in STATES:
        assert np.abs(one[name].values - other[name].values).max() < 1e-12
    for mine, theirs in (("contact1", "force_1"), ("contact2", "force_2")):
        assert np.abs(one[mine].values - other[theirs].values).max() < 1e-9


@pytest.mark.parametrize("changes", [*CASES, FIGURE_25 | {"lambda2": 3.1, "xi_p2": 0.25}])
def test_phase_equations_and_compact_form_have_the_same_right_hand_sides(changes):
    """Along the run of the model, in fractions but for the sine: (38)-(41) and (43) are equal."""
    system = fatigue_rig(**changes)
    run = ns.simulate(system, periods=3, samples_per_period=60)
    p = {name: Fraction(value) for name, value in system.parameter_values.items()}
    rest = statics(p)

    def sin(angle):
        return Fraction(float(np.sin(float(angle))))

    seen = set()
    for k, phase in enumerate(phases_along(run)):
        x = [Fraction(float(run[name][k])) for name in STATES]
        t = Fraction(float(run["time"][k]))
        guards = (float(x[0] - x[2] + rest[2]), float(x[2] - x[3] - rest[3]))
        if min(map(abs, guards)) < 1e-12:
            continue
        printed = printed_rates(phase, p, rest, x, t, sin)
        assert printed == compact_rates(p, rest, x, t, sin)
        for name, rate in (("acceleration1", printed[1]), ("acceleration2", printed[4])):
            # the force of a contact has 1/eps = 500 times the rounding of the states
            assert abs(float(run[name][k]) - float(rate)) < 1e-11 * (1 + abs(float(rate)))
        seen.add(phase)
    assert len(seen) >= (4 if not changes else 2)


@pytest.mark.parametrize("changes", [*CASES, FIGURE_25 | {"lambda2": 3.1, "xi_p2": 0.25}])
def test_phase_equations_and_compact_form_have_the_same_runs(changes):
    system = fatigue_rig(**changes)
    one = ns.simulate(system, periods=10)
    other = ns.simulate(printed_system(dict(system.parameter_values)), periods=10)
    assert [n for n, _ in switches(one)] == [n for n, _ in switches(other)]
    for name in STATES:
        assert np.abs(one[name].values - other[name].values).max() < 1e-11


@pytest.mark.parametrize("ratio", [None, 0.25])
@pytest.mark.parametrize("forces", [(5.44, 3.52), (3.52, 5.44), (3.0, 3.0)])
def test_statics_are_exact(forces, ratio):
    crack = {} if ratio is None else {"open_stiffness": ratio}
    p = dict(fatigue_rig(f1=forces[0], f2=forces[1], **crack).parameter_values)
    d1, d2, D1, D2, gamma = statics(p)
    q = {name: Fraction(value) for name, value in p.items()}
    assert d1 + D1 / q["eps"] == q["f1"] and d2 + D2 / q["eps"] == -q["f2"]
    run = ns.simulate(fatigue_rig(**p), times=[0.0])
    expected = {
        "deflection": gamma,
        "contact1": D1 / q["eps"],
        "contact2": -D2 / q["eps"],
        "load": (D1 + D2) / q["eps"],
        "acceleration1": 0,
        "acceleration2": 0,
    }
    for name, value in expected.items():
        assert abs(float(run[name][0]) - float(value)) < 4e-15 * max(forces), name


def test_a_crack_that_changes_nothing_changes_nothing():
    one = ns.simulate(fatigue_rig(**FIGURE_25), periods=10)
    other = ns.simulate(fatigue_rig(**FIGURE_25, open_stiffness=1.0), periods=10)
    for name in (*STATES, "load"):
        assert np.abs(one[name].values - other[name].values).max() < 1e-11


def test_a_crack_against_an_integrator_that_knows_no_events():
    p = FIGURE_25 | {"open_stiffness": 0.3, "theta": 7.828, "eps": 0.002012}
    system = fatigue_rig(**p)
    p = dict(system.parameter_values)
    d1, d2, D1, D2, gamma = map(float, statics(p))

    def field(t, x):
        X1, X2, X3, X4, X5 = x
        R1 = max(X1 - X3 + D1, 0) / p["eps"]
        R2 = max(X3 - X4 - D2, 0) / p["eps"]
        u = X3 + gamma
        k = p["theta"] ** 2 * (p["open_stiffness"] if u > 0 else 1.0)
        push = p["eta"] ** 2 * np.sin(p["eta"] * t)
        c = 2 * (p["xi_Ls"] + p["xi_p1"] * p["lambda1"])
        s = 1 + p["lambda1"] ** 2
        return [
            X2,
            -s * X1 - c * X2 - R1 - d1 + p["f1"] + push,
            (R1 - R2 - k * u) / (2 * p["theta"] * p["xi_s"]),
            X5,
            -s * X4 - c * X5 + R2 - d2 - p["f2"] + push,
        ]

    end = 2 * np.pi / p["eta"]
    other = solve_ivp(field, (0, end), [0.0] * 5, method="Radau", rtol=1e-8, atol=1e-11)
    run = ns.simulate(system, times=[0.0, end])
    found = [float(run[name][-1]) for name in STATES]
    assert np.abs(found - other.y[:, -1]).max() < 1e-6


def test_outputs_by_hand():
    run = ns.simulate(fatigue_rig(), periods=2)
    p = fatigue_rig().parameter_values
    base = -(p["eta"] ** 2) * np.sin(p["eta"] * run["time"].values)
    assert np.allclose(run["base"], base, atol=1e-12)
    assert np.allclose(run["absolute1"], run["acceleration1"] + base, atol=1e-10)
    assert np.allclose(run["absolute2"], run["acceleration2"] + base, atol=1e-10)
    assert np.allclose(run["load"], run["contact1"] - run["contact2"], atol=1e-10)
    assert np.allclose(run["pneumatic1"], 4 * run["X1"] + 1.6 * run["X2"], atol=1e-12)
    # Newton on mass 1 as a whole: inertia, leaf spring, cylinder, contact
    left = run["acceleration1"] + run["X1"] + 2 * p["xi_Ls"] * run["X2"] + run["pneumatic1"]
    assert np.allclose(left + run["contact1"] - float(run["contact1"][0]) + base, 0, atol=1e-9)


def test_identical_sides_in_contact_move_together():
    run = ns.simulate(fatigue_rig(f1=30, f2=25), periods=10)
    assert set(phases_along(run)) == {"i"}
    assert np.abs(run["X1"] - run["X4"]).max() < 1e-14


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        ({"theta": 0}, "theta > 0"),
        ({"eps": -1e-3}, "eps > 0"),
        ({"xi_s": 0}, "xi_s > 0"),
        ({"xi_p1": -0.1}, "xi_p1 >= 0"),
        ({"lambda1": -2, "f1": 9}, "lambda1 >= 0 .*damping would feed energy"),
        ({"lambda2": -1e-3}, "lambda2 >= 0"),
        ({"eta": 0}, "eta"),
        ({"open_stiffness": 0}, "open_stiffness > 0"),
        ({"open_stiffness": -0.5}, "open_stiffness > 0"),
        ({"theta": "x"}, "x"),
    ],
)
def test_bad_input(bad, words):
    with pytest.raises(ns.ModelError, match=words):
        fatigue_rig(**bad)


def contact_forces_at_rest(f1, f2, stiffness, eps):
    """Contact forces of the two masses at rest: the one of four cases that contradicts nothing.

    A contact that is closed has its force and its approach in proportion, one that is open has no
    force and a gap; a leaf spring bends by what is left of the force on its mass.
    """
    for closed in itertools.product((True, False), repeat=2):
        # unknown: forces R1, R2 and the deflection of the specimen
        matrix, right = np.zeros((3, 3)), np.zeros(3)
        for i, (sign, force) in enumerate(((1.0, f1), (-1.0, f2))):
            matrix[i, i] = eps + 1.0 if closed[i] else 1.0
            if closed[i]:  # eps R = (f - R) - sign gamma
                matrix[i, 2], right[i] = sign, force
        matrix[2] = 1.0, -1.0, -stiffness
        r1, r2, gamma = np.linalg.solve(matrix, right)
        gaps = gamma - (f1 - r1), -(f2 - r2) - gamma
        if all(r >= 0.0 if is_closed else gap >= 0.0 for is_closed, r, gap in
               zip(closed, (r1, r2), gaps, strict=True)):  # fmt: skip
            return r1, r2, gamma
    raise AssertionError("no rest")


FORCES_AT_REST = [(3.75, 3.75), (5.0, 1.0), (-1.0, 3.75), (-0.01, 3.0), (2.0, -1.0), (0.5, -0.5),
                  (0.0, 0.0), (-2.0, -1.0)]  # fmt: skip


@pytest.mark.parametrize("crack", [None, 0.4])
@pytest.mark.parametrize("forces", FORCES_AT_REST)
def test_rest_with_masses_on_the_specimen_or_off_it(forces, crack):
    f1, f2 = forces
    rig = fatigue_rig(f1=f1, f2=f2, theta=3.0, eps=0.02, open_stiffness=crack)
    stiffness = 9.0 * (crack if crack is not None and f1 > f2 else 1.0)
    r1, r2, gamma = contact_forces_at_rest(f1, f2, stiffness, 0.02)
    start = ns.simulate(rig, times=[0.0])
    found = [float(start[name][0]) for name in ("contact1", "contact2", "deflection")]
    np.testing.assert_allclose(found, [r1, r2, gamma], rtol=0, atol=1e-13 * (1 + abs(f1) + abs(f2)))
    still = fatigue_rig(
        f1=f1, f2=f2, theta=3.0, eps=0.02, open_stiffness=crack,
        base=ns.Signal([0.0, 50.0], [0.0, 0.0], method="linear"),
    )  # fmt: skip
    run = ns.simulate(still, times=np.linspace(0.0, 40.0, 81))
    assert max(float(abs(run[name]).max()) for name in rig.states) < 1e-12


@pytest.mark.parametrize("forces", [(-1.0, 3.75), (2.0, -1.0), (-0.5, -0.2)])
@pytest.mark.slow
def test_motion_from_a_rest_with_a_mass_off_the_specimen(forces):
    """Positions of the masses themselves, by an implicit method of order five."""
    f1, f2 = forces
    theta, eps, xi_s, eta, rate = 3.0, 0.05, 0.1, 1.1, 0.8 + 2 * 0.00255
    rig = fatigue_rig(
        eta=eta, lambda1=1.0, lambda2=1.0, theta=theta, eps=eps, f1=f1, f2=f2, xi_s=xi_s
    )
    r1, r2, gamma = contact_forces_at_rest(f1, f2, theta**2, eps)
    rest = np.array([f1 - r1, 0.0, gamma, r2 - f2, 0.0])

    def flow(t, w):
        one, two = max(w[0] - w[2], 0.0) / eps, max(w[2] - w[3], 0.0) / eps
        shaking = eta**2 * np.sin(eta * t)
        return [
            w[1],
            f1 - w[0] - (w[0] - rest[0]) - rate * w[1] - one + shaking,
            (one - two - theta**2 * w[2]) / (2.0 * theta * xi_s),
            w[4],
            -f2 - w[3] - (w[3] - rest[3]) - rate * w[4] + two + shaking,
        ]

    times = np.linspace(0.0, 2.0 * 2.0 * np.pi / eta, 40)
    truth = solve_ivp(flow, (0.0, times[-1]), rest, "Radau", times, rtol=1e-10, atol=1e-12,
                      max_step=0.02)  # fmt: skip
    run = ns.simulate(rig, times=times)
    found = np.array([run[name].values for name in rig.states])
    assert run.attrs["n_events"] >= 4
    # what an implicit method of this tolerance leaves at kinks
    np.testing.assert_allclose(found + rest[:, None], truth.y, rtol=0, atol=1e-7)
