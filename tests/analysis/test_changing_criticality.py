"""Generalised flips and Chenciner points along curves, beside maps with closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.continuation.follow import follow


def kicked(parameters: dict[str, float], **images: str) -> ns.System:
    """The map that takes each state to its image, once per unit of time."""
    kick = ns.Exit("1 - clock", reset={"clock": "clock - 1", **images}, name="kick")
    flow = {name: "0" for name in images} | {"clock": "1"}
    return ns.System(
        states=list(flow), parameters=parameters, modes={"hold": ns.Mode(flow, exits=[kick])}
    )


def special_branch(system: ns.System, kind: str, between: tuple[float, float] = (-0.4, 0.4)):
    """The branch of the fixed point at zero over mu, and the number of its special point."""
    start = dict.fromkeys(system.states, 0.0)
    branch = ns.continue_orbit(system, "mu", between, initial=start, period=1)
    return branch, branch["special_kind"].values.tolist().index(kind)


def places(curve, kind: str) -> list[float]:
    found = curve["special_value"].values[curve["special_kind"].values == kind]
    return sorted(found.tolist())


def cubic(a: float, b: float) -> ns.System:
    """x' = -(1 + mu) x + a x**2 + b x**3: the coefficient of its flip at mu = 0 is a**2 + b."""
    return kicked({"mu": -0.2, "a": a, "b": b}, x="-(1 + mu)*x + a*x**2 + b*x**3")


@pytest.mark.slow
def test_generalised_flip_of_a_cubic_map() -> None:
    """At b = -1 there are two, a = 1 and a = -1."""
    branch, number = special_branch(cubic(0.5, -1.0), "flip")
    curve = ns.continue_special(branch, number, "a", (-1.6, 1.7))
    assert curve["special_kind"].values.tolist() == [
        "bound", "generalised_flip", "generalised_flip", "bound"
    ]  # fmt: skip
    # by a coefficient whose differences are exact but for rounding, 1e-11 of terms of one
    assert places(curve, "generalised_flip") == pytest.approx([-1.0, 1.0], abs=1e-9)
    assert np.abs(curve["mu"].values).max() < 1e-12
    details = curve["special_detail"].values[1:3]
    assert all("stable orbit beyond turn into flips with an unstable one" in d for d in details)


@pytest.mark.slow
def test_generalised_flip_over_the_other_coefficient() -> None:
    branch, number = special_branch(cubic(0.5, 0.3), "flip")
    curve = ns.continue_special(branch, number, "b", (-1.0, 1.0))
    assert places(curve, "generalised_flip") == pytest.approx([-0.25], abs=1e-9)


def test_flips_on_both_sides_have_the_criticality_that_it_says() -> None:
    for a, criticality in ((0.9, "subcritical"), (1.1, "supercritical")):
        branch, number = special_branch(cubic(a, -1.0), "flip")
        assert ns.criticality(branch, special=number)["criticality"].item() == criticality


@pytest.mark.slow
def test_the_coefficient_passes_a_pole_without_a_change() -> None:
    """x' = -(1 + mu) x - x**2 + x**3 - x w, w' = k w - x**2 with the multipliers -(1 + mu) and k.

    On the centre manifold w = h x**2 with h = -1/(1 - k), since x**2 stays as it is to this order.
    So the coefficient is a**2 + b = 1 + (1 - h) = 2 + 1/(1 - k): it changes its sign through
    infinity at k = 1, where a fold or a crossing happens as well, and through zero at k = 1.5.
    """
    system = kicked({"mu": -0.2, "k": 0.5}, x="-(1 + mu)*x - x**2 + x**3 - x*w", w="k*w - x**2")
    branch, number = special_branch(system, "flip")
    curve = ns.continue_special(branch, number, "k", (0.2, 3.0))
    other = np.isin(curve["special_kind"].values, ["fold_flip", "branch_point"])
    assert curve["special_value"].values[other] == pytest.approx([1.0], abs=1e-6)
    assert places(curve, "generalised_flip") == pytest.approx([1.5], abs=1e-8)


@pytest.mark.slow
def test_no_change_where_the_coefficient_is_rounding() -> None:
    """A linear map has none: what is computed of it is zero or rounding of either sign."""
    system = kicked(
        {"mu": -0.2, "k": 0.3}, x="-(1 + mu)*x + sin(k)*y/3", y="exp(-k)*y/2 + 0.1*x*mu"
    )
    branch, number = special_branch(system, "flip")
    curve = ns.continue_special(branch, number, "k", (0.1, 0.9))
    assert places(curve, "generalised_flip") == []


@pytest.mark.slow
def test_chenciner_point_of_a_rotation() -> None:
    """z' = (1 + mu) exp(i theta) z (1 + s |z|**2): first Lyapunov coefficient s, at mu = 0."""
    theta = 1.0
    turn = {"c": repr(float(np.cos(theta))), "s": repr(float(np.sin(theta)))}
    factor = "(1 + mu)*(1 + (s - 0.3)*(x**2 + y**2) - (x**2 + y**2)**2)"
    system = kicked(
        {"mu": -0.2, "s": 0.1},
        x=f"({turn['c']}*x - {turn['s']}*y)*{factor}",
        y=f"({turn['s']}*x + {turn['c']}*y)*{factor}",
    )
    branch, number = special_branch(system, "torus")
    curve = ns.continue_special(branch, number, "s", (0.0, 0.8))
    assert places(curve, "chenciner") == pytest.approx([0.3], abs=1e-8)
    assert "tori with a stable closed curve" in str(
        curve["special_detail"].values[curve["special_kind"].values == "chenciner"][0]
    )


@pytest.mark.slow
def test_flips_of_a_soft_stop_change_their_criticality() -> None:
    """Branches through both sides of the point tell the same."""
    soft = ns.models.soft_impact(a=0.6)
    branch = ns.continue_orbit(soft, "a", (0.1, 1.0), period=2, steps=1000)
    number = branch["special_kind"].values.tolist().index("flip")
    curve = ns.continue_special(branch, number, "omega", (0.85, 0.9145), direction="up")
    (place,) = places(curve, "generalised_flip")
    found = []
    for omega in (place - 2e-3, place + 2e-3):
        near = int(np.argmin(np.abs(curve["omega"].values - omega)))
        point = curve.isel(point=near)
        values = {name: float(point[name]) for name in ("a", "omega")}
        there = soft.with_parameters(**values)
        width = 1e-3 * values["a"]
        one = ns.continue_orbit(
            there, "a", (values["a"] - width, values["a"] + width), initial=point, period=2
        )
        told = ns.criticality(one, special="flip")
        found.append(told["criticality"].values[0])
    assert sorted(found) == ["subcritical", "supercritical"]


def test_a_dear_test_is_asked_only_where_it_is_needed() -> None:
    """A function in place of a number: called at the ends of steps, and to locate its own zero."""
    calls = []

    def tests(point):
        def dear() -> float:
            calls.append(point.p)
            return point.p + 10.0

        return {"cheap": point.p - 0.35, "dear": dear}

    points = list(follow(lambda u, p: u - p, 0.0, 0.0, bounds=(0.0, 1.0), tests=tests, step=0.1))
    located = [point for point in points if point.special == "cheap"]
    assert [point.p for point in located] == pytest.approx([0.35], abs=1e-12)
    assert len(calls) <= len(points)
    assert points[-1].tests["dear"] == pytest.approx(11.0)
