"""What a branch of orbits says at its end: no word of options that it has not."""

import inspect
import re

import pytest

import nonsmooth as ns
from nonsmooth.periodic_orbits.branch_part import ending_of_orbits

ENDED = {
    "bound": lambda u, p: (u - p, 1.0, -1.0),
    "steps": lambda u, p: (u - p, 1.0, -1.0),
    "closed": lambda u, p: (u**2 + p**2 - 1, 2 * u, 2 * p),
    "domain": lambda u, p: (u - p, 1.0, -1.0) if p < 0.6 else (u * float("nan"), 1.0, -1.0),
    "smallest_step": lambda u, p: (u - abs(p), 1.0, 1.0 if p < 0.0 else -1.0),
}


@pytest.mark.parametrize("ended", ENDED)
def test_in_the_words_of_orbits(ended):
    start = {"closed": (1.0, 0.0), "smallest_step": (1.0, -1.0)}.get(ended, (0.5, 0.5))
    bounds = (0.0, 1.0) if start == (0.5, 0.5) else (-2.0, 2.0)
    branch = ns.continuation.follow(
        ENDED[ended], *start, bounds=bounds, steps=3 if ended == "steps" else 200
    )
    last = list(branch)[-1]
    assert branch.ended == ended, branch.message
    said = ending_of_orbits(ended, branch.message, "b", last.p)
    assert "residual" not in said and "derivatives" not in said and " p = " not in said
    if ended != "closed":
        assert f"b = {last.p:.10g}" in said
    known = set(inspect.signature(ns.continue_orbit).parameters)
    assert set(re.findall(r"(\w+)=", said)) <= known


def test_two_crossing_branches_and_reasons_in_brackets():
    said = ending_of_orbits("singular", "the derivatives are singular at p = 1 (x): no", "b", 1.0)
    assert "at b = 1" in said and "branch_directions" not in said
    said = ending_of_orbits("domain", "no finite value beyond p = 1 (f(x): too far): ends", "b", 1)
    assert "are not defined (f(x): too far), as" in said
    assert ending_of_orbits("stopped", "far enough", "b", 1.0) == "far enough"


def test_a_branch_that_begins_at_its_bound():
    """The amplitude of x'' = -4 x - 0.4 x' + F cos(3 t) is F / |-5 + 1.2 i|."""
    system = ns.System(
        states=["x", "v"],
        parameters={"F": 0.0},
        period="2*pi/3",
        equations={"x": "v", "v": "-4*x - 0.4*v + F*cos(3*t) - 9.81"},
    )
    branch = ns.continue_orbit(system, "F", (0.0, 0.4))
    assert (branch.attrs["end_first"], branch.attrs["end_last"]) == ("bound", "bound")
    assert branch["F"].values[[0, -1]].tolist() == [0.0, 0.4]
    down = ns.continue_orbit(system, "F", (0.3, 0.4), parameters={"F": 0.3}, direction="down")
    assert down.attrs["end_first"] == "bound" and down["F"].values.tolist() == [0.3]
