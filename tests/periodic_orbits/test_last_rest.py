"""Rests that end rebounds just before a release, however short, and the branch up to the last."""

import pytest
from mpmath import mp, mpf

import nonsmooth as ns
from nonsmooth.errors import OptionError
from periodic_orbits.references.last_rest import (
    CAM_SPEED,
    TABLE,
    rest_on_cam,
    rest_on_table,
)


def cam_follower(w: float) -> ns.System:
    """A follower that a cam throws off; it rebounds on it, rides on it, and is thrown off again."""
    return ns.System(
        states=["y", "v"],
        parameters={
            "m": 0.3, "k": 2000.0, "c": 2.0, "d": 0.01, "A": 0.008, "w": w, "r": 0.3, "g": 9.81,
        },
        period="2*pi/w",
        definitions={"h": "A*(1 - cos(w*t))/2", "hd": "A*w*sin(w*t)/2"},
        modes={
            "lifted": ns.Mode(
                {"y": "v", "v": "-k*(y + d)/m - c*v/m - g"},
                exits=[ns.Exit("y - h", reset={"v": "-r*v + (1 + r)*hd"}, sticks="rides")],
            )
        },
    )  # fmt: skip


def ball(r: str, gamma: float) -> ns.System:
    """A ball on a table at gamma sin t; it begins at rest there."""
    return ns.System(
        states=["h", "u"],
        parameters={"G": gamma, "r": float(r)},
        period="2*pi",
        definitions={"s": "G*sin(t)", "sv": "G*cos(t)"},
        initial={"h": 0.0, "u": gamma},
        modes={
            "flight": ns.Mode(
                {"h": "u", "u": "-1"},
                exits=[ns.Exit("h - s", reset={"u": "-r*u + (1 + r)*sv"}, sticks="rides")],
            )
        },
    )


# below the last rest; flights as low as 1e-12 of the terms of their guard are known to 1e-4, and
# what follows from them as long as the distance from there is clear of that
@pytest.mark.parametrize("below", [1.4e-3, 2e-5, 5e-6, 1e-6, 1e-7])
def test_an_orbit_that_rests_briefly_before_its_release(below):
    w = float(CAM_SPEED) - below
    orbit = ns.find_orbit(cam_follower(w), transient=20)
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    assert orbit["word"].item() == "lifted rides lifted" and bool(orbit["admissible"])
    assert orbit["multipliers"].values.tolist() == [0.0, 0.0]


@pytest.mark.parametrize("w", [248.0876, 248.09])
def test_how_long_it_rests(w):
    """The log has the end of all rebounds, to what the last ones that are followed are known to."""
    run = ns.simulate(cam_follower(w), {"y": 0.004, "v": 0.0}, periods=20)
    kinds, times = run["event_kind"].values, run["event_time"].values
    rest = times[kinds == "release"][-1] - times[kinds == "chatter"][-1]
    assert rest == pytest.approx(float(rest_on_cam(mpf(w))), rel=1e-4)


@pytest.mark.parametrize("beyond", [1e-4, 1e-5])
def test_no_rest_just_beyond(beyond):
    """Where the last rebound lasts until behind the release, no motion rests."""
    w = float(CAM_SPEED) + beyond
    orbit = ns.find_orbit(cam_follower(w), transient=400)
    assert orbit.attrs["status"] == "completed" and "rides" not in orbit["word"].item()


def end_of(branch) -> tuple[str, float]:
    assert bool(branch["admissible"].all())
    return branch["special_kind"].values[-1], float(branch["special_value"][-1])


def test_the_branch_ends_at_the_last_rest():
    """To 1e-11: rounding of flights as above, by the slope of their rates over the parameter."""
    branch = ns.continue_orbit(
        cam_follower(248.09), "w", (248.0, 248.2), direction="up", transient=20
    )
    kind, value = end_of(branch)
    assert kind == branch.attrs["end_last"] == "lost"
    assert value == pytest.approx(float(CAM_SPEED), rel=1e-11)
    assert "rebounds end just at the release" in branch.attrs["message"]
    assert set(branch["special_kind"].values) == {"lost"}
    with pytest.raises(OptionError, match="rounding of the last rebounds"):
        ns.continue_special(branch, 0, "r", (0.25, 0.35))


@pytest.mark.slow
def test_the_last_rest_from_the_other_side():
    """Behind it grazes accumulate; motions that rest tell where that is."""
    branch = ns.continue_orbit(
        cam_follower(248.092), "w", (248.0, 248.2), direction="down", transient=400
    )
    places = dict(zip(branch["special_kind"].values, branch["special_value"].values, strict=True))
    assert places["lost"] == pytest.approx(float(CAM_SPEED), rel=1e-11)


@pytest.mark.few(1)
@pytest.mark.parametrize(("r", "gamma"), [("0.3", 1.9), ("0.5", 1.55), ("0.6", 1.4), ("0.8", 1.2)])
def test_the_last_rest_of_a_ball_on_a_table(r, gamma):
    branch = ns.continue_orbit(ball(r, gamma), "G", (1.05, 2.2), direction="up")
    kind, value = end_of(branch)
    assert kind == branch.attrs["end_last"] == "lost"
    assert value == pytest.approx(float(TABLE[r]), rel=1e-11)


@pytest.mark.slow
def test_the_references_rest_on_one_side():
    """Of the last rests by which the tests above judge: 1e-17 to either side."""
    with mp.workdps(40):
        below, above = 1 - mpf(10) ** -17, 1 + mpf(10) ** -17
        assert (
            rest_on_cam(mpf(CAM_SPEED) * below) > 0 and rest_on_cam(mpf(CAM_SPEED) * above) is None
        )
        for r, gamma in TABLE.items():
            assert rest_on_table(mpf(gamma) * below, r) > 0
            assert rest_on_table(mpf(gamma) * above, r) is None
