"""Branches of all models at random parameters agree with themselves, or tell where they do not.

What is looked at here is the dataset alone: multipliers of neighbouring orbits lie on the same
sides of the unit circle unless a special point is between them, and the parameter turns back at
special points only.
"""

from __future__ import annotations

import numpy as np
import pytest

import nonsmooth as ns

# parameters that are drawn, and over one of which the branch is followed; None for all
MODELS: dict[str, tuple[str, ...] | None] = {
    "soft_impact": ("a", "omega", "beta"),
    "impact_oscillator": ("omega", "sigma", "r"),
    "duffing": ("gamma", "omega"),
    "trilinear": None,
    "gear_pair": None,
    "friction_oscillator": None,
    "breathing_crack": ("crack", "d"),
    "moling": ("b", "a", "omega"),
    "rotor": ("eta", "eta_m"),
    "clearance_rotor": None,
    "percussive_drilling": None,
    "belt_oscillator": None,
    "bouncing_ball": None,
    "metal_cutting": None,
}
SETS = 200
NEAR = 1e-5  # of the unit circle: a multiplier there is on neither side


def drawn(number: int) -> tuple[ns.System, str, tuple[float, float]] | None:
    """A system, a parameter and its bounds; None where the model refuses the values."""
    name = list(MODELS)[number % len(MODELS)]
    rng = np.random.default_rng(number)
    system = getattr(ns.models, name)()
    values = dict(system.parameter_values)
    chosen = [key for key in MODELS[name] or values if values[key] != 0.0]
    try:
        system = system.with_parameters(
            **{key: float(values[key] * rng.uniform(0.8, 1.25)) for key in chosen}
        )
    except ns.ModelError:
        return None
    parameter = str(rng.choice(chosen))
    value = system.parameter_values[parameter]
    return system, parameter, (min(0.75 * value, 1.3 * value), max(0.75 * value, 1.3 * value))


def outside(multipliers: np.ndarray) -> int | None:
    """How many multipliers are outside the unit circle; None where that is not clear."""
    sizes = np.abs(multipliers[~np.isnan(multipliers)])
    return None if np.any(np.abs(sizes - 1.0) <= NEAR) else int(np.count_nonzero(sizes > 1.0))


def disagreements(branch, parameter: str) -> list[str]:
    """What no special point explains."""
    special = set(branch["special_point"].values.tolist())
    words, values = branch["word"].values, branch[parameter].values
    counts = [outside(each) for each in branch["multipliers"].values]
    found = []
    for k in range(branch.sizes["point"] - 1):
        if {k, k + 1} & special or words[k] != words[k + 1]:
            continue
        if None not in (counts[k], counts[k + 1]) and counts[k] != counts[k + 1]:
            found.append(f"multipliers between points {k} and {k + 1}")
        if k + 2 < values.size and k + 2 not in special:
            steps = np.diff(values[k : k + 3])
            if steps[0] * steps[1] < 0.0 and words[k + 1] == words[k + 2]:
                found.append(f"a turn at point {k + 1}")
    return found


@pytest.mark.slow
@pytest.mark.parametrize("number", range(SETS))
@pytest.mark.filterwarnings("ignore::nonsmooth.RunWarning")
def test_a_branch_agrees_with_itself(number):
    case = drawn(number)
    if case is None:
        pytest.skip("the model refuses these values")
    system, parameter, bounds = case
    try:
        branch = ns.continue_orbit(system, parameter, bounds, steps=120, transient=400)
    except ns.NonsmoothError as fault:  # motions that settle to no orbit of one period
        assert "orbit" in str(fault)
        pytest.skip("there is no orbit to begin with")
    told = branch.attrs["message"]
    assert branch.attrs["status"] == "completed"
    assert "error within nonsmooth" not in told
    found = disagreements(branch, parameter)
    assert not found or "no special point was found that tells why" in told


def test_disagreements_are_seen():
    """The check itself: a branch whose special points are taken away disagrees."""
    branch = ns.continue_orbit(ns.models.soft_impact(a=0.4), "a", (0.3, 0.9))
    assert disagreements(branch, "a") == []
    kinds = branch["special_kind"].values
    without = branch.isel(special=kinds == "bound", point=~np.isin(
        np.arange(branch.sizes["point"]), branch["special_point"].values[kinds == "flip"]
    ))  # fmt: skip
    assert any("multipliers" in each for each in disagreements(without, "a"))
