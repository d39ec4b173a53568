"""`continue_orbit`: grazing in closed form, flips, folds, branches from them, constructions."""

import os
import signal

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.periodic_orbits import branch_run
from periodic_orbits.kinds import rigid_wall, van_der_pol

SOFT = {"omega": 0.85, "zeta": 0.01, "beta": 29.0, "e": 1.26}


def table(branch, *kinds):
    """Values of the parameter at special points of some kinds, in order along the branch."""
    rows = zip(branch["special_kind"].values, branch["special_value"].values, strict=True)
    return [float(value) for kind, value in rows if kind in kinds]


def reach(omega: float, zeta: float) -> float:
    """Force over amplitude of the oscillator that touches nothing."""
    return float(np.hypot(1 - omega**2, 2 * zeta * omega))


@pytest.mark.parametrize(
    ("omega", "zeta", "e"),
    [(0.85, 0.01, 1.26), (0.6, 0.02, 1.26), (1.4, 0.05, 0.5), (2.3, 0.2, 1.0), (0.45, 0.1, 2.0)],
)
def test_grazing_of_the_soft_stop(omega, zeta, e):
    graze = e * reach(omega, zeta) / omega**2
    system = ns.models.soft_impact(omega=omega, zeta=zeta, e=e, a=0.9 * graze)
    branch = ns.continue_orbit(
        system, "a", (0.8 * graze, 1.05 * graze), direction="up", word="free"
    )
    found = table(branch, "grazing")
    assert found and found[0] == pytest.approx(graze, rel=1e-12)
    first = int(
        branch["special_point"].values[list(branch["special_kind"].values).index("grazing")]
    )
    assert set(branch["word"].values[:first]) == {"free"}
    assert branch["word"].values[first + 1].count("contact") == 1
    # the orbit without contact is the closed form, all the way
    a = branch["a"].values[:first]
    x = -1j * a * omega**2 / (1 - omega**2 + 2j * zeta * omega)
    np.testing.assert_allclose(branch["x"].values[:first], x.real, atol=1e-11)


@pytest.mark.parametrize(
    ("omega", "zeta", "sigma"), [(2.0, 0.02, 0.1), (2.8, 0.02, 0.5), (1.7, 0.1, 1)]
)
def test_grazing_of_the_rigid_wall(omega, zeta, sigma):
    graze = sigma * reach(omega, zeta)
    system = rigid_wall(omega=omega, zeta=zeta, sigma=sigma, F=0.9 * graze)
    branch = ns.continue_orbit(
        system, "F", (0.5 * graze, 1.2 * graze), direction="up", word="free", steps=60
    )
    (found,) = table(branch, "grazing")
    assert found == pytest.approx(graze, rel=1e-12)
    detail = str(
        branch["special_detail"].values[list(branch["special_kind"].values).index("grazing")]
    )
    assert "touches 'impact'" in detail
    there = list(branch["special_kind"].values).index("grazing")
    known = branch["special_multiplier"].values[there]
    assert known == np.inf or abs(known) < 1.0  # from without a contact it stays inside


def test_grazing_from_the_side_of_impacts():
    """The impact loses its speed where the free motion reaches the wall; the log says which."""
    system = rigid_wall(omega=3.2, zeta=0.02, sigma=0.1, F=1.0)
    branch = ns.continue_orbit(
        system, "omega", (3.2, 3.4), direction="up", word="free free", initial={"x": -0.1}
    )
    there = list(branch["special_kind"].values).index("grazing")
    graze = float(branch["special_value"][there])
    assert 0.1 * reach(graze, 0.02) == pytest.approx(1.0, rel=1e-12)
    assert "comes with zero speed to 'impact'" in str(branch["special_detail"].values[there])


@pytest.mark.slow
def test_from_a_graze_far_away():
    """The orbit grows by twenty times behind the graze of the rigid wall."""
    system = rigid_wall(omega=2.0, F=0.25)
    branch = ns.continue_orbit(system, "F", (0.2, 1.0), direction="up")
    assert branch.attrs["end_last"] == "bound"
    again = ns.continue_orbit(
        rigid_wall(omega=2.0, F=1.0), "F", (0.1, 1.0), initial=branch.isel(point=-1)
    )
    there = list(again["special_kind"].values).index("grazing")
    assert again["special_multiplier"].values[there] == np.inf  # no bound at a rigid wall
    known = ns.find_orbit(rigid_wall(omega=2.0, F=1.0), transient=300)
    assert float(branch["x"][-1]) == pytest.approx(float(known["x"]), abs=1e-10)


def test_points_are_orbits():
    """Each point by its own: `find_orbit` there has the same state and multipliers."""
    system = ns.models.soft_impact(**SOFT, a=0.4)
    branch = ns.continue_orbit(system, "a", (0.4, 0.6))
    for k in range(0, branch.sizes["point"], 5):
        point = branch.isel(point=k)
        orbit = ns.find_orbit(system, point, parameters={"a": float(point["a"])})
        assert orbit["word"].item() == point["word"].item()
        assert float(orbit["x"]) == pytest.approx(float(point["x"]), abs=1e-9)
        assert (
            orbit["stable"].item() == point["stable"].item()
            or abs(abs(complex(orbit["multipliers"][0])) - 1.0) < 1e-6
        )


def test_stability_changes_at_flips_and_folds_alone():
    branch = ns.continue_orbit(ns.models.moling(), "b", (0.1, 0.17))
    kinds = dict(zip(branch["special_point"].values, branch["special_kind"].values, strict=True))
    stable = branch["stable"].values
    for k in np.flatnonzero(stable[1:] != stable[:-1]):
        assert {kinds.get(k), kinds.get(k + 1)} & {"flip", "fold", "grazing"}, k
    for kind, value in zip(
        branch["special_kind"].values, branch["special_multiplier"].values, strict=True
    ):
        if kind == "flip":
            assert value == pytest.approx(-1.0, abs=1e-9)
        if kind == "fold":
            assert value == pytest.approx(1.0, abs=1e-8)
    # on either side of the fold the parameter comes from below
    fold = int(branch["special_point"].values[list(branch["special_kind"].values).index("fold")])
    b = branch["b"].values
    assert b[fold] == b[fold - 3 : fold + 4].max()


def test_the_doubled_branch_begins_at_the_flip():
    """At the flip it is the old orbit passed twice; beyond, the two halves differ."""
    system = ns.models.soft_impact(**SOFT, a=0.4)
    branch = ns.continue_orbit(system, "a", (0.3, 0.9))
    flip = list(branch["special_kind"].values).index("flip")
    doubled = ns.continue_orbit(system, "a", (0.3, 0.9), initial=branch, special=flip)
    value = float(branch["special_value"][flip])
    start = int(np.argmin(np.abs(doubled["arclength"].values)))
    assert float(doubled["a"][start]) == pytest.approx(value, abs=1e-10)
    assert doubled.attrs["period"] == 2
    assert float(doubled["length"][start]) == pytest.approx(4 * np.pi / 0.85, rel=1e-13)
    beyond = doubled.isel(point=start + 3)
    orbit = ns.find_orbit(system, beyond, period=2, parameters={"a": float(beyond["a"])})
    assert orbit.attrs["status"] == "completed" and int(orbit["primitive_parts"]) == 1


def test_the_other_branch_where_a_symmetry_breaks():
    system = ns.models.trilinear(omega=1.5)
    branch = ns.continue_orbit(system, "omega", (0.7, 1.6))
    kinds = list(branch["special_kind"].values)
    crossing = kinds.index("symmetry_breaking")
    other = ns.continue_orbit(
        system, "omega", (0.7, 1.6), initial=branch, special=crossing, steps=40
    )
    value = float(branch["special_value"][crossing])
    assert np.abs(other["omega"].values - value).min() < 1e-6

    def asymmetry(orbit):
        """Of the states half a turn apart, whose sum vanishes on a symmetric orbit."""
        half = float(orbit["time"] + 0.5 * orbit["length"])
        there = system.with_parameters(omega=float(orbit["omega"]))
        start = {name: float(orbit[name]) for name in ("x", "v")}
        return abs(float(ns.simulate(there, start, times=[half])["x"][-1]) + start["x"])

    on = branch.isel(point=[0, branch.sizes["point"] // 2])
    assert all(asymmetry(on.isel(point=k)) < 1e-7 for k in range(2))
    far = int(np.argmax(np.abs(other["arclength"].values)))
    assert asymmetry(other.isel(point=far)) > 1e-3


def test_constructions_go_on_through_the_stop():
    system = ns.models.soft_impact(**SOFT, a=0.4)
    branch = ns.continue_orbit(system, "a", (0.3, 0.9), inadmissible=True)
    graze = SOFT["e"] * reach(SOFT["omega"], SOFT["zeta"]) / SOFT["omega"] ** 2
    a, motion = branch["a"].values, branch["admissible"].values
    assert set(branch["word"].values) == {"free"}
    np.testing.assert_array_equal(motion, a < graze)
    assert a.min() == 0.3 and a.max() == 0.9


@pytest.mark.slow
def test_a_cycle_over_a_parameter():
    """Small mu: the length is 2 pi (1 + mu^2/16) but for mu^4 (van der Pol)."""
    branch = ns.continue_orbit(van_der_pol(), "mu", (0.05, 2.0), transient=10)
    assert branch.attrs["status"] == "completed"
    assert (branch.attrs["end_first"], branch.attrs["end_last"]) == ("bound", "bound")
    mu, length = branch["mu"].values, branch["length"].values
    small = mu < 0.3
    assert small.any()
    np.testing.assert_allclose(
        length[small], 2 * np.pi * (1 + mu[small] ** 2 / 16), atol=2e-2 * 0.3**4 * 2 * np.pi
    )
    assert np.all(np.diff(mu) > 0.0) and branch["stable"].values.all()


def test_one_way_and_a_few_steps():
    system = ns.models.soft_impact(**SOFT, a=0.4)
    up = ns.continue_orbit(system, "a", (0.3, 0.9), direction="up", steps=5)
    assert (up.attrs["end_first"], up.attrs["end_last"]) == ("start", "steps")
    assert float(up["a"][0]) == 0.4 and np.all(np.diff(up["a"].values) > 0.0)
    assert "steps=" in up.attrs["message"]
    down = ns.continue_orbit(system, "a", (0.3, 0.9), direction="down")
    assert (down.attrs["end_first"], down.attrs["end_last"]) == ("bound", "start")
    assert float(down["a"].values.min()) == 0.3
    assert np.all(np.diff(down["arclength"].values) > 0.0)


def test_control_c_keeps_the_points(monkeypatch, interrupts):
    calls = []
    look = branch_run.BranchStretch.look

    def interrupted(self, point):
        calls.append(point)
        if len(calls) == 12:
            os.kill(os.getpid(), signal.SIGINT)
        return look(self, point)

    monkeypatch.setattr(branch_run.BranchStretch, "look", interrupted)
    system = ns.models.soft_impact(**SOFT, a=0.4)
    branch = ns.continue_orbit(system, "a", (0.3, 0.9))
    assert branch.attrs["status"] == "interrupted"
    assert branch.attrs["end_last"] == "interrupted" and branch.attrs["end_first"] == "start"
    assert 1 <= branch.sizes["point"] < 15
    assert "interrupted" in branch.attrs["message"]


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"parameter": "bb"}, "unknown parameter 'bb'"),
        ({"between": (0.5, 0.9)}, "lies outside"),
        ({"between": (0.9, 0.3)}, "must be below the second"),
        ({"between": 0.5}, "lowest and the highest"),
        ({"between": (0.3, np.nan)}, "between"),
        ({"direction": "left"}, "both, up, down"),
        ({"period": True}, "period = True is not a finite number"),
        ({"steps": 0}, "steps"),
        ({"step": 0.2}, "in this order"),
        ({"smallest_step": 0.0}, "above 0"),
        ({"largest_step": 2.0}, "at most 1"),
        ({"inadmissible": 1}, "inadmissible"),
        ({"special": 0}, "needs initial="),
        ({"word": "contact free contact free contact"}, None),
        ({"parameters": {"a": 0.6}, "word": "free"}, "inadmissible=True follows"),
    ],
)
def test_bad_input(change, message):
    options = {"parameter": "a", "between": (0.3, 0.9)} | change
    with pytest.raises(ns.NonsmoothError, match=message or "no orbit|no motion"):
        ns.continue_orbit(ns.models.soft_impact(**SOFT, a=0.4), **options)


def test_bad_special_points():
    system = ns.models.soft_impact(**SOFT, a=0.4)
    branch = ns.continue_orbit(system, "a", (0.3, 0.9))
    for special, message in ((0, "bound point"), (7, "numbered from 0"), (0.5, "numbered from 0")):
        with pytest.raises(ns.OptionError, match=message):
            ns.continue_orbit(system, "a", (0.3, 0.9), initial=branch, special=special)
    with pytest.raises(ns.OptionError, match="the same parameter"):
        ns.continue_orbit(system, "omega", (0.8, 0.9), initial=branch, special=2)
