"""The command that draws up a bifurcation picture, beside the verb."""

import json

import numpy as np
import pytest

import nonsmooth as ns

GIVEN = (
    "picture", "soft_impact", "omega=0.8", "--over", "a=0.3:0.5", "--over", "x=-2:2",
    "--over", "v=-2:2", "--values", "3", "--starts", "4", "--searches", "0",
)  # fmt: skip


@pytest.mark.slow
def test_the_command_says_what_the_verb_finds(call, tmp_path):
    saved = tmp_path / "picture.nc"
    found = json.loads(call(*GIVEN, "--json", "--save", str(saved)).stdout)
    expected = ns.bifurcation_picture(
        ns.models.soft_impact(omega=0.8), "a", (0.3, 0.5), {"x": (-2, 2), "v": (-2, 2)},
        columns=3, samples=4, searches=0,
    )  # fmt: skip
    assert found["status"] == "completed" and found["between"] == [0.3, 0.5]
    assert len(found["attractors"]) == expected.sizes["attractor"]
    assert [row["period"] for row in found["branches"]] == expected["branch_period"].values.tolist()
    assert saved.exists()


def test_the_first_attractor_is_the_motion_that_never_touches(call):
    """It has period 1 while the amplitude of the free mass is below the gap e."""
    result = call(*GIVEN)
    soft = ns.models.soft_impact(omega=0.8).parameter_values
    omega, zeta = soft["omega"], soft["zeta"]
    free = 0.5 * omega**2 / np.hypot(1.0 - omega**2, 2.0 * zeta * omega)
    assert free < soft["e"]
    assert result.exit_code == 0 and "periodic" in result.stdout


@pytest.mark.parametrize(
    ("over", "said"),
    [
        (("a=0.3:0.5",), "one parameter"),
        (("x=-1:1",), "one parameter"),
        (("a=0.3:0.5", "zeta=0:1", "x=-1:1"), "one parameter"),
        (("q=0:1", "x=-1:1"), "unknown parameter or state 'q'"),
        (("a=0.5:0.3", "x=-1:1"), "empty range"),
    ],
)
def test_wrong_ranges_are_named(call, over, said):
    options = [word for each in over for word in ("--over", each)]
    result = call("picture", "soft_impact", *options)
    assert result.exit_code == 2 and said in result.stderr


def test_a_bifurcation_picture_goes_on_from_its_store(call, tmp_path):
    words = (*GIVEN, "--store", tmp_path / "store")
    first = call(*words)
    assert first.exit_code == 0, first.stderr
    assert len(list((tmp_path / "store").glob("[0-9]*.npz"))) >= 3 + 2 + 1
    assert call(*words).stdout == first.stdout
    other = call(*words, "--longest", "3")
    assert other.exit_code == 2 and "longest: 2 then, 3 now" in other.stderr
