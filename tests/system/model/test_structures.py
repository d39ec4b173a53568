"""Systems from mass, damping and stiffness, against the block matrix written by hand."""

import numpy as np
import pytest
import scipy.sparse

import nonsmooth as ns
from nonsmooth import Exit, ModelError, System

M = np.array([[2.0, 0.5], [0.5, 1.0]])
K = np.array([[300.0, -100.0], [-100.0, 100.0]])
C = 1e-3 * K
VALUES = {"parameters": {"F": 40.0, "omega": 7.0}, "period": "2*pi/omega"}
SHAKEN = ["F*cos(omega*t)", 3.0]


def by_hand(mass, damping, stiffness):
    zero, one = np.zeros_like(mass), np.eye(len(mass))
    return np.block(
        [[zero, one], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)]]
    )


def ends(system, **options):
    return ns.simulate(system, periods=3, **options)["end_state"].values


@pytest.mark.parametrize("mass", [M, np.diag([2.0, 1.0])])
def test_as_the_block_matrix(mass):
    """Motions agree to the rounding of the entries."""
    structure = System.from_matrices(mass=mass, damping=C, stiffness=K, force=SHAKEN, **VALUES)
    assert structure.states == ("x1", "x2", "v1", "v2")
    inverse = np.linalg.inv(mass)
    offset = [0, 0, *(f"{a!r}*F*cos(omega*t) + {3.0 * b!r}" for a, b in inverse.tolist())]
    matrix = System.from_matrices(by_hand(mass, C, K), offset, states=structure.states, **VALUES)
    assert np.allclose(ends(structure), ends(matrix), rtol=0.0, atol=1e-13)


def test_entries_of_a_diagonal_mass_are_quotients():
    """One rounding, as a person would write them."""
    flow = System.from_matrices(mass=np.diag([3.0, 7.0]), stiffness=K).modes["flow"].flow
    assert flow["x1"] == "v1"
    assert flow["v1"] == f"-100.0*x1 + {100 / 3!r}*x2"
    assert flow["v2"] == f"{100 / 7!r}*x1 - {100 / 7!r}*x2"


def test_a_massless_force_and_no_force():
    system = System.from_matrices(mass=[[1.0]], stiffness=[[4.0]], force=["sin(t)"])
    assert system.modes["flow"].flow["v1"] == "-4.0*x1 + (sin(t))"
    free = System.from_matrices(mass=[[2.0]], stiffness=[[4.0]], damping=[[1.0]])
    assert free.modes["flow"].flow["v1"] == "-2.0*x1 - 0.5*v1"
    assert (
        System.from_matrices(mass=[[2.0]], stiffness=[[4.0]], force=[6]).modes["flow"].flow["v1"]
        == "-2.0*x1 + 3.0"
    )


def test_each_mode_has_arrays_of_its_own():
    pressed = K + np.diag([0.0, 5000.0])
    frame = System.from_matrices(
        mass=scipy.sparse.csr_array(np.diag([2.0, 1.0])),
        damping=C,
        stiffness={"apart": K, "touching": pressed},
        force={"apart": ["F*cos(omega*t)", 0], "touching": ["F*cos(omega*t)", "5000*gap"]},
        exits={
            "apart": [Exit("gap - x2", to="touching", name="contact")],
            "touching": [Exit("x2 - gap", to="apart", name="release")],
        },
        parameters=VALUES["parameters"] | {"gap": 0.25},
        period=VALUES["period"],
    )
    assert list(frame.modes) == ["apart", "touching"]
    assert frame.modes["apart"].flow["v1"] == frame.modes["touching"].flow["v1"]
    assert frame.modes["touching"].flow["v2"].endswith("+ (5000*gap)")
    assert ns.simulate(frame, periods=20).attrs["n_events"] > 0
    assert System.from_toml(frame.to_toml()) == frame


def test_exits_may_name_the_modes():
    system = System.from_matrices(
        mass=[[1.0]], stiffness=[[4.0]],
        exits={"a": [Exit("x1", to="b")], "b": [Exit("-x1", to="a")]},
    )  # fmt: skip
    assert list(system.modes) == ["a", "b"]


WRONG = {
    "both": ({"matrix": [[0.0]], "mass": [[1.0]], "stiffness": [[1.0]]}, "not some of both"),
    "offset": ({"offset": [0.0], "mass": [[1.0]], "stiffness": [[1.0]]}, "not some of both"),
    "no mass": ({"stiffness": [[1.0]]}, "mass: give mass= and stiffness= together"),
    "no stiffness": ({"mass": [[1.0]]}, "stiffness: give mass= and stiffness= together"),
    "force alone": ({"force": [1.0]}, "mass: give mass= and stiffness= together"),
    "sizes": ({"mass": [[1.0]], "stiffness": K}, "stiffness is 2 x 2 and mass is 1 x 1"),
    "no inverse": ({"mass": [[1.0, 1.0], [1.0, 1.0]], "stiffness": K}, "mass has no inverse"),
    "massless": ({"mass": np.diag([1.0, 0.0]), "stiffness": K}, "mass has no inverse"),
    "entry": ({"mass": M, "stiffness": [[1, 2], [3, np.nan]]}, r"stiffness\[1, 1\]"),
    "damping": ({"mass": M, "stiffness": K, "damping": [[1, 2]]}, "damping has 1 rows"),
    "force": ({"mass": M, "stiffness": K, "force": ["F"]}, "force has 1 entries; give 2"),
    "mode": ({"mass": {"a": M, "b": M}, "stiffness": {"a": K}}, "stiffness: the mode 'b' has none"),
    "states": ({"mass": M, "stiffness": K, "states": ["x", "y"]}, "states: 2 names"),
    "nothing": ({}, "matrix"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_is_named(case):
    given, said = WRONG[case]
    with pytest.raises(ModelError, match=said):
        System.from_matrices(**given)
