"""Branches onto a family of cycles of all sizes at one parameter, and what grazes its largest one.

Within the gaps of some stops the equations are linear. Where their rest neither grows nor decays
cycles of all sizes surround it, up to the one that touches a stop. Beyond, the work of the stops
balances the growth: references are the eigenvalues of the linear equations and, to leading order
in the depth d, the integral of cos(t) (d - g t**2/2) over a contact of a cycle of the amplitude g,
which is 4 sqrt(2)/3 d**(3/2)/sqrt(g).
"""

from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq

import nonsmooth as ns

M, IZ, F, A, R0, LAM, KY, KP, CY, K1 = (
    1800.0, 1200.0, 3.5e6, 0.75, 0.46, 0.2, 4e5, 1.5e6, 1e3, 2e6,
)  # fmt: skip
GAP = 0.006
OF_CONTACT = 4.0 * np.sqrt(2.0) / 3.0


def wheelset() -> ns.System:
    """A hunting wheelset between soft flanges; its states differ in size by a factor of 200."""
    return ns.System(
        states=["y", "v", "p", "w"],
        parameters={"V": 45.0},
        equations={
            "y": "v",
            "v": f"(-{KY}*y - {CY}*v - {2 * F}*(v/V - p) - {K1}*(y - clip(y, -{GAP}, {GAP})))/{M}",
            "p": "w",
            "w": f"(-{KP}*p - {2 * F * A}*({LAM / R0}*y + {A}*w/V))/{IZ}",
        },
        initial={"y": 0.004},
    )


def matrix(speed: float) -> np.ndarray:
    """Of the wheelset between its flanges."""
    return np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-KY / M, -(CY + 2 * F / speed) / M, 2 * F / M, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [-2 * F * A * LAM / R0 / IZ, 0.0, -KP / IZ, -2 * F * A**2 / speed / IZ],
        ]
    )


@cache
def critical_speed() -> float:
    return brentq(lambda v: np.linalg.eigvals(matrix(v)).real.max(), 20.0, 60.0, xtol=1e-13)


def critical_pair(speed: float) -> complex:
    values = np.linalg.eigvals(matrix(speed))
    return complex(values[np.argmax(values.imag)])


def depth_of_flanges() -> float:
    """Depth over the distance of the speed to the power 2/3: first order of averaging.

    With A q = i omega q, q_y = 1/2 and p q = 1 the amplitude r of y changes by
    Re(p_v) times twice the mean of exp(-i omega t) times the force, and by the growth times r.
    """
    at = critical_speed()
    values, right = np.linalg.eig(matrix(at))
    k = int(np.argmax(values.imag))
    q = right[:, k] / (2.0 * right[0, k])
    lefts, covectors = np.linalg.eig(matrix(at).T)
    p = covectors[:, int(np.argmin(np.abs(lefts - values[k])))]
    p = p / (p @ q)
    step = 1e-4
    growth = (critical_pair(at + step).real - critical_pair(at - step).real) / (2.0 * step)
    # both flanges; y = 2 Re(q_y z) with z = r exp(i omega t)
    brakes = (K1 / M) * p[1].real * 2.0 * OF_CONTACT / np.sqrt(GAP) / (2.0 * np.pi)
    return (growth * GAP / brakes) ** (2.0 / 3.0)


@pytest.fixture(scope="module")
def hunting():
    system = wheelset()
    return ns.continue_orbit(
        system, "V", (20.0, 60.0), initial=ns.find_orbit(system), direction="down", steps=60
    )


def test_a_branch_of_four_states_ends_where_its_rest_loses_stability(hunting):
    assert list(hunting["special_kind"].values) == ["hopf", "grazing"]
    assert hunting.attrs["end_first"] == "hopf"
    # nothing is unexplained where the parameter stays where it is
    assert "tells why" not in hunting.attrs["message"]
    assert hunting["special_value"].values == pytest.approx(critical_speed(), rel=1e-13)
    pair = critical_pair(critical_speed())
    end = hunting.isel(point=0)
    assert float(end["length"]) == pytest.approx(2.0 * np.pi / pair.imag, rel=1e-12)
    assert all(abs(float(end[name])) < 1e-15 for name in "yvpw")
    # of the rest one multiplier of the pair is that of the cycles along themselves
    others = [v for v in np.linalg.eigvals(matrix(critical_speed())) if v.real < -1.0]
    assert len(others) == 2
    decay = np.abs(np.exp(np.array(others) * 2.0 * np.pi / pair.imag))
    assert np.abs(end["multipliers"].values) == pytest.approx([1.0, *decay], rel=1e-5)


def test_orbits_with_flange_contact_exist_above_the_critical_speed(hunting):
    found = ns.criticality(hunting, "grazing").isel(special=0)
    assert found["criticality"].item() == "continuous"
    assert found["side"].item() == "above"
    assert "above V = " in found["criticality_detail"].item()
    # the step of the growth and the power law of a curvature have eight digits
    assert float(found["amplitude_factor"]) == pytest.approx(depth_of_flanges(), rel=1e-6)
    assert float(found["amplitude_power"]) == pytest.approx(2.0 / 3.0)
    speed = critical_speed()
    depths = []
    for point in range(hunting.sizes["point"]):
        beyond = float(hunting["V"][point]) - speed
        if 1e-6 < beyond < 0.5:
            orbit = ns.orbit_samples(hunting.isel(point=point))
            depth = float(np.abs(orbit["y"]).max()) - GAP
            depths.append((beyond, depth / beyond ** (2.0 / 3.0)))
    assert len(depths) >= 2
    for beyond, factor in depths:
        # the next term is as much smaller as the depth is beside the gap
        share = depth_of_flanges() * beyond ** (2.0 / 3.0) / GAP
        assert factor == pytest.approx(depth_of_flanges(), rel=2.0 * share + 1e-4)


def planar(stops: int, sign: float = 1.0, centre: float = 0.0) -> ns.System:
    """x'' = 2 a x' - x with the damping d of one or two stops a unit away from the rest."""
    x = f"(x - {centre})"
    hit = f"max({x} - 1, 0)" if stops == 1 else f"({x} - clip({x}, -1, 1))"
    return ns.System(
        states=["x", "y"],
        parameters={"a": 0.1 * sign},
        equations={"x": f"y - (0.6*{hit} - 2*({sign}*a)*{x})", "y": f"-{x}"},
        initial={"x": centre + 1.5},
    )


@pytest.mark.few(1)
@pytest.mark.parametrize("stops", [1, 2])
@pytest.mark.parametrize(("sign", "side", "bounds"), [
    (1.0, "above", (-0.1, 0.25)), (-1.0, "below", (-0.25, 0.1)),
])  # fmt: skip
@pytest.mark.parametrize("centre", [0.0, 3.0])
def test_cycles_in_the_plane(stops, sign, side, bounds, centre):
    """A turn gains 2 pi a and loses 0.6 times the integral of each contact."""
    system = planar(stops, sign, centre)
    branch = ns.continue_orbit(
        system, "a", bounds, initial=ns.find_orbit(system), direction="down" if sign > 0 else "up"
    )
    assert sorted(branch["special_kind"].values) == ["grazing", "hopf"]
    assert "hopf" in (branch.attrs["end_first"], branch.attrs["end_last"])
    assert "tells why" not in branch.attrs["message"]
    assert branch["special_value"].values == pytest.approx([0.0, 0.0], abs=1e-14)
    place = int(branch["special_point"].values[branch["special_kind"].values == "hopf"][0])
    assert float(branch["x"][place]) == pytest.approx(centre, abs=1e-14)
    # few of the cycles in between, which are all alike
    assert np.count_nonzero(np.abs(branch["a"].values) < 1e-13) <= 5
    found = ns.criticality(branch, "grazing").isel(special=0)
    assert found["side"].item() == side
    assert "stable orbits" in found["criticality_detail"].item()
    assert "unstable" not in found["criticality_detail"].item()
    depth = (2.0 * np.pi / (0.6 * stops * OF_CONTACT)) ** (2.0 / 3.0)
    assert float(found["amplitude_factor"]) == pytest.approx(depth, rel=1e-8)


def test_backwards_in_time_the_orbits_are_unstable():
    forwards = planar(2)
    orbit = ns.find_orbit(forwards)
    system = ns.System(
        states=["x", "y"],
        parameters={"a": 0.1},
        equations={"x": "-(y - (0.6*(x - clip(x, -1, 1)) - 2*a*x))", "y": "x"},
    )
    start = {name: float(orbit[name]) for name in "xy"}
    back = ns.find_orbit(system, start, transient=0)
    assert not back["stable"].item()
    branch = ns.continue_orbit(system, "a", (-0.1, 0.25), initial=back, direction="down")
    assert branch.attrs["end_first"] == "hopf"
    found = ns.criticality(branch, "grazing").isel(special=0)
    assert found["side"].item() == "above"
    assert "unstable orbits" in found["criticality_detail"].item()


def test_a_state_that_follows_a_cycle_in_the_plane():
    """The same with three states, about a rest that moves."""
    system = ns.System(
        states=["x", "y", "z"],
        parameters={"a": 0.1},
        definitions={"u": "x - 3 - 2*a"},
        equations={"x": "y - 0.6*(u - clip(u, -1, 1)) + 2*a*u", "y": "-u", "z": "x - 4*z"},
        initial={"x": 4.5},
    )
    branch = ns.continue_orbit(system, "a", (-0.1, 0.25), direction="down")
    assert list(branch["special_kind"].values) == ["hopf", "grazing"]
    assert branch["special_value"].values == pytest.approx([0.0, 0.0], abs=1e-14)
    end = branch.isel(point=0)
    assert [float(end[name]) for name in "xyz"] == pytest.approx([3.0, 0.0, 0.75], abs=1e-13)
    assert end["multipliers"].values.real == pytest.approx([1.0, np.exp(-8.0 * np.pi)], rel=1e-3)
    assert ns.criticality(branch, "grazing")["side"].values.tolist() == ["above"]


def test_cycles_of_a_spring_that_hardens_shrink_to_their_rest():
    """Without damping all amplitudes repeat, with periods of their own: no cycle is another one."""
    system = ns.System(
        states=["x", "v"],
        parameters={"d": 0.0},
        equations={"x": "v", "v": "-x - x**3 - d*v"},
    )
    orbit = ns.find_orbit(system, {"x": 0.5, "v": 0.0})
    branch = ns.continue_orbit(system, "d", (-0.1, 0.25), initial=orbit, direction="up")
    assert branch.attrs["end_last"] == "hopf"
    assert "tells why" not in branch.attrs["message"]
    assert branch["d"].values == pytest.approx(0.0, abs=1e-13)
    assert float(branch["length"][-1]) == pytest.approx(2.0 * np.pi, rel=1e-13)
    assert np.all(np.diff(np.hypot(branch["x"].values, branch["v"].values)) < 0.0)
