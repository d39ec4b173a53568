"""Reduced models: exact where they have to be, and as far off as they say elsewhere."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.linalg import eigh
from scipy.sparse import csc_array

import nonsmooth as ns
from nonsmooth.structures import (
    Beam,
    Bearing,
    Force,
    GapSpring,
    Stop,
    Unbalance,
    machine,
    reduce,
    shaft,
)
from nonsmooth.structures.receptance_error import RESOLUTION
from nonsmooth.structures.speed_texts import coefficient_pieces, piecewise_definitions
from nonsmooth.system.text.evaluate import constant_value
from nonsmooth.system.text.grammar import parse
from structures.contact_truth import beam, chain

METHODS = ["free-interface", "craig-bampton"]
FIRST = 1.8751040687119611664**4  # of a cantilever with EI = m = 1, the square of its frequency


def beam_structure(elements, sparse=False):
    mass, stiffness, names = beam(elements)
    if sparse:
        mass, stiffness = csc_array(mass), csc_array(stiffness)
    damping = 0.1 * mass + 1e-4 * stiffness
    return ns.Structure(mass, stiffness, damping=damping, coordinates=names)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("modes", [0, 3])
def test_static_flexibility_at_kept_coordinates_is_exact(method, modes):
    structure = beam_structure(12)
    keep = ["12y", "5y"]
    small = reduce(structure, keep, modes=modes, method=method)
    at = [structure.index(name) for name in keep]
    full = np.linalg.inv(structure.stiffness)[np.ix_(at, at)]
    rows = small.basis[at]
    assert np.abs(rows @ np.linalg.solve(small.at_speed(0.0)[2], rows.T) / full - 1).max() < 1e-9


@pytest.mark.parametrize("method", METHODS)
def test_statics_stay_exact_when_a_bearing_changes_with_the_speed(method):
    mass, stiffness, names = beam(8)
    held = Bearing(["4y"], np.array([10.0, 200.0, 900.0]), speeds=[0.0, 1.0, 2.0])
    structure = ns.Structure(mass, stiffness, coordinates=names, bearings=[held])
    small = reduce(structure, ["8y"], modes=2, method=method)
    assert small.keep == ("8y", "4y")
    at = structure.index("8y")
    for speed in (0.0, 0.6, 1.9):
        full = np.linalg.inv(structure.at_speed(speed)[2])[at, at]
        row = small.basis[at]
        found = row @ np.linalg.solve(small.at_speed(speed)[2], row)
        assert abs(found / full - 1) < 1e-9


def test_free_bodies_keep_their_rigid_motion():
    mass, stiffness = chain(10)
    stiffness[0, 0] = stiffness[-1, -1]  # nothing holds the left end any more
    small = reduce(ns.Structure(mass, stiffness), ["q9"], modes=3)
    squares = small.squares
    assert squares[0] == 0.0
    exact = eigh(stiffness, mass, eigvals_only=True)
    assert np.abs(squares[1:3] / exact[1:3] - 1).max() < 1e-12
    rigid = small.basis[:, 0]
    assert np.ptp(rigid) < 1e-9 * abs(rigid[0])


@pytest.mark.parametrize("elements", [10, 50])
def test_slow_modes_of_fine_meshes_keep_their_digits(elements):
    """With 50 elements stiffnesses are 2e10, and a mode of 12 has to be found among them."""
    small = reduce(beam_structure(elements), [f"{elements}y"], modes=8)
    # cubic elements err by (beta h)^4/720 of the square of a frequency
    mesh = (1.8751040687 / elements) ** 4 / 720
    assert abs(small.squares[0] / FIRST - 1 - mesh) < 1e-8


@pytest.mark.parametrize("method", METHODS)
def test_the_estimate_is_the_error_of_the_receptance(method):
    structure = beam_structure(15)
    small = reduce(structure, ["15y"], accuracy=1e-3, frequency_range=(0.0, 200.0), method=method)
    worst = float(small.estimate["error"].max())
    assert worst <= 1e-3
    fewer = reduce(
        structure, ["15y"], modes=small.size - 2, frequency_range=(0.0, 200.0), method=method
    )
    assert float(fewer.estimate["error"].max()) > 1e-3  # so the number is the smallest
    at = structure.index("15y")
    for i in (0, 40, -1):
        frequency = float(small.estimate["frequency"][i])
        s = frequency * (1j + RESOLUTION)
        pair = []
        for (mass, damping, stiffness), row in (
            (structure.at_speed(0.0), np.eye(structure.size)[at]),
            (small.at_speed(0.0), small.basis[at]),
        ):
            pair.append(row @ np.linalg.solve(s**2 * mass + s * damping + stiffness, row))
        error = abs(pair[1] - pair[0]) / abs(pair[0])
        assert abs(error - float(small.estimate["error"][0, i])) < 1e-9


def test_sparse_and_dense_matrices_give_the_same():
    dense, sparse = (
        reduce(beam_structure(20, kind), ["20y"], frequency_range=(0.0, 300.0))
        for kind in (False, True)
    )
    assert dense.size == sparse.size
    assert np.abs(dense.squares / sparse.squares - 1).max() < 1e-7
    assert abs(dense.estimate["error"] - sparse.estimate["error"]).max() < 1e-8


def test_a_large_sparse_model():
    structure = beam_structure(1000, sparse=True)
    small = reduce(structure, ["1000y"], frequency_range=(0.0, 100.0), accuracy=1e-2)
    assert small.size < 12
    # shift and invert leaves what the condition of the stiffness, 3e13, leaves of a solution
    assert abs(small.squares[0] / FIRST - 1) < 1e-2


@pytest.mark.parametrize("method", METHODS)
def test_contact_forces_come_to_those_of_the_full_model_as_estimated(method):
    structure = beam_structure(12)
    contacts = [GapSpring("12y", 0.1, 200.0)]
    loads = [Force("7y", "F*cos(omega*t)")]
    words = {"parameters": {"F": 3.0, "omega": 4.0}, "period": "2*pi/omega"}
    full = ns.simulate(machine(structure, contacts, loads, **words), periods=3)
    largest = float(full["spring1_force"].max())
    assert largest > 1.0
    for accuracy in (1e-2, 1e-3, 1e-4):
        small = reduce(
            structure, ["12y"], accuracy=accuracy, frequency_range=(0.0, 300.0),
            driven=["7y"], method=method,
        )  # fmt: skip
        run = ns.simulate(machine(small, contacts, loads, **words), periods=3)
        assert run.attrs["phase_word"] == full.attrs["phase_word"]
        off = float(abs(run["spring1_force"] - full["spring1_force"]).max()) / largest
        assert off < 3 * accuracy
        assert abs(run["event_time"] - full["event_time"]).max() < accuracy


def test_start_and_recover():
    structure = beam_structure(12)
    whole = reduce(structure, ["12y"], modes=structure.size)
    shape = np.linalg.solve(structure.stiffness, np.eye(structure.size)[structure.index("12y")])
    for contact in (GapSpring("12y", 9.0, 1.0), Stop("12y", 9.0, 0.5)):
        system = machine(whole, [contact])
        assert ("y12" in system.states) == isinstance(contact, Stop)
        start = whole.start(system, shape, {"3y": 0.2})
        run = ns.simulate(system, start, t_end=0.01)
        found = whole.recover(run.isel(time=0))
        assert abs(found["displacement"] - shape).max() < 1e-9
        velocity = np.zeros(structure.size)
        velocity[structure.index("3y")] = 0.2
        assert abs(found["velocity"] - velocity).max() < 1e-8
    small = reduce(structure, ["12y"], modes=3)
    with pytest.raises(ns.OptionError, match="the machine is none of this reduction"):
        small.recover(run)
    with pytest.raises(ns.OptionError, match="displacements has shape"):
        whole.start(system, np.zeros(3))


ROWS = np.linspace(0.0, 7.0, 300)
ROUGH = 5.0 + np.random.default_rng(3).random((300, 2, 2))


@pytest.mark.few(3)
@pytest.mark.parametrize(
    "bearing",
    [
        Bearing(["a", "b"], np.arange(20.0).reshape(5, 2, 2) ** 2, 3.0, speeds=[0, 1, 3, 4, 7]),
        Bearing("a", [1.0, 5.0], speeds=[0.0, 7.0]),
        Bearing("a", [9.0, 1.0, 0.5, 0.4], speeds=[0, 1, 2, 7], interpolation="monotone"),
        Bearing(["a", "b"], lambda s: np.array([[np.exp(s), 1], [s**2, 5 / (1 + s**2)]]), np.cos),
        Bearing(["a", "b"], ROUGH, 3.0, speeds=ROWS),  # has texts too long for one definition
        Bearing("a", ROUGH[:, 0, 0], speeds=ROWS, interpolation="monotone"),
        Bearing("a", CubicSpline(ROWS, ROUGH[:, 0, 0]), speeds=ROWS),  # as tables of ROSS are
    ],
)
def test_texts_of_coefficients_are_the_coefficients(bearing):
    pieces = coefficient_pieces(bearing, (0.0, 7.0))
    k = len(bearing.coordinates)
    speeds = np.linspace(0.0, 7.0, 15)
    truth = np.array([bearing.at_speed(speed) for speed in speeds.tolist()])
    size = np.abs(truth).max(axis=0)
    for which, i, j in np.ndindex(2, k, k):
        definitions = piecewise_definitions("c", "Omega", pieces, (which, i, j))
        assert list(definitions)[-1] == "c"
        parsed = {name: parse(text, where=name) for name, text in definitions.items()}
        for speed, right in zip(speeds.tolist(), truth, strict=True):
            values = {"Omega": speed}
            for name, expression in parsed.items():
                values[name] = constant_value(expression, values)
            # polynomials are right to 1e-10 where they were looked at
            assert abs(values["c"] - right[which, i, j]) <= 2e-10 * size[which, i, j]


@pytest.mark.slow
def test_a_machine_with_long_tables_has_their_response():
    """Against the matrices of the full shaft, at speeds between the rows."""
    speeds = np.linspace(0.0, 700.0, 300)
    along = 8e6 + 2.9e4 * speeds + 5e5 * np.sin(speeds / 20)
    tables = {"stiffness": along, "damping": 1.2e4 / (1 + speeds / 350), "speeds": speeds}
    rotor = shaft(
        [Beam(0.2, 0.05)] * 4,
        bearings=[Bearing([f"{node}x", f"{node}y"], **tables) for node in (0, 4)],
    )
    small = reduce(rotor, ["2x", "2y"], modes=rotor.size)
    system = machine(small, [], [Unbalance("2x", "2y", 1e-3)], Omega=150.0)
    for speed in (33.3, 640.1):
        mass, damping, stiffness = rotor.at_speed(speed)
        force = np.zeros(rotor.size, complex)
        force[[rotor.index("2x"), rotor.index("2y")]] = 1e-3 * speed**2 * np.array([1, -1j])
        answer = np.linalg.solve(stiffness + 1j * speed * damping - speed**2 * mass, force)
        found = ns.find_orbit(system.with_parameters(Omega=speed))
        run = ns.simulate(system.with_parameters(Omega=speed), found, periods=1)
        wanted = answer[rotor.index("2x")]
        assert abs(float(run["x2"][0]) - wanted.real) < 1e-8 * abs(wanted)


def test_coefficients_that_jump_are_refused():
    rough = Bearing("a", lambda speed: 1.0 + (speed > 0.3))
    with pytest.raises(ns.ModelError, match=r"no smooth function of the speed: near 0.(29|30)"):
        coefficient_pieces(rough, (0.0, 1.0))


@pytest.mark.parametrize("sparse", [False, True])
def test_a_bearing_that_pushes_is_reduced_too(sparse):
    """Cross-coupling or a seal may push in some direction: the shaft holds it."""
    pushing = [[2e6, 7e6], [5e6, 3e6]]  # its symmetric part has the eigenvalue -3.5e6
    rotor = shaft(
        [Beam(0.1, 0.05)] * 8,
        bearings=[
            *(Bearing([f"{node}x", f"{node}y"], 2e7, 1e3) for node in (0, 8)),
            Bearing(["4x", "4y"], pushing, 1e3),
        ],
        sparse=sparse,
    )
    small = reduce(rotor, ["4x", "4y"], frequency_range=(0.0, 1000.0), accuracy=1e-3)
    assert small.size < 20
    matrices = (rotor.at_speed(0.0), small.at_speed(0.0))
    at = [rotor.index(name) for name in ("4x", "4y")]
    full, reduced = (
        each[2].toarray() if hasattr(each[2], "toarray") else each[2] for each in matrices
    )
    rows = small.basis[at]
    exact = np.linalg.inv(full)[np.ix_(at, at)]
    np.testing.assert_allclose(
        rows @ np.linalg.solve(reduced, rows.T), exact, rtol=1e-7, atol=1e-9 * np.abs(exact).max()
    )


def test_faults():
    structure = beam_structure(6)
    with pytest.raises(ns.OptionError, match="keep: there is none"):
        reduce(structure, [], modes=2)
    with pytest.raises(ns.OptionError, match="frequency_range: give the lowest"):
        reduce(structure, ["6y"])
    with pytest.raises(ns.OptionError, match="give two frequencies"):
        reduce(structure, ["6y"], frequency_range=(3.0, 1.0))
    with pytest.raises(ns.OptionError, match="a coordinate stands twice"):
        reduce(structure, ["6y", "6y"], modes=1)
    with pytest.raises(ns.OptionError, match="is not reached with 12 modes"):
        reduce(structure, ["6y"], accuracy=1e-30, frequency_range=(0.0, 10.0))
    with pytest.raises(ns.OptionError, match=r"accuracy = 0 must be positive"):
        reduce(structure, ["6y"], accuracy=0.0, frequency_range=(0.0, 10.0))
    with pytest.raises(ns.ModelError, match="the structure buckles"):
        reduce(ns.Structure(np.eye(3), np.diag([-2.0, 3.0, 5.0])), ["q0"], modes=1)
    free = ns.Structure(np.eye(3), np.zeros((3, 3)))
    with pytest.raises(ns.ModelError, match="may still move freely"):
        reduce(free, ["q0"], modes=1, method="craig-bampton")
    with pytest.raises(ns.ModelError, match="mass is singular"):
        reduce(ns.Structure(np.diag([1.0, 0.0]), np.eye(2)), ["q0"], modes=1)
