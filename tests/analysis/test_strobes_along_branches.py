"""Along a branch, the orbit at which an impact is just at a strobe is told before and behind it.

The truth is the reset itself: a ball between two walls has the speeds v and -r v there.
"""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import nonsmooth as ns

R, D = 0.7, 0.5
PAIR = ns.System(
    states=["x", "v"],
    parameters={"A": 1.5, "r": R, "d": D},
    period="2*pi",
    initial={"v": 0.5},
    modes={
        "fly": ns.Mode(
            {"x": "v", "v": "A*cos(t)"},
            exits=[
                ns.Exit("d - x", reset={"v": "-r*v"}, name="right"),
                ns.Exit("d + x", reset={"v": "-r*v"}, name="left"),
            ],
        )
    },
)


@pytest.fixture(scope="module")
def symmetric():
    return ns.continue_orbit(PAIR, "A", (0.5, 3.0))


@pytest.fixture(scope="module")
def of_two_periods(symmetric):
    """A branch of period two, whose second strobe is passed by an impact at A = 1.916."""
    kinds = symmetric["special_kind"].values.tolist()
    one = ns.continue_orbit(
        PAIR, "A", (0.5, 3.0), initial=symmetric, special=kinds.index("symmetry_breaking")
    )
    two = ns.continue_orbit(
        PAIR,
        "A",
        (0.5, 3.0),
        initial=one,
        special=one["special_kind"].values.tolist().index("flip"),
    )
    orbit = two.isel(point=5)
    values = {"A": float(orbit["A"])}
    phase = float(orbit["leg_time"][4]) / (2.0 * np.pi) - 1e-3
    there = ns.simulate(
        PAIR, {"x": float(orbit["x"]), "v": float(orbit["v"])}, parameters=values,
        times=[0.0, 2.0 * np.pi * phase],
    ).isel(time=-1)  # fmt: skip
    start = {"x": float(there["x"]), "v": float(there["v"])}
    first = ns.find_orbit(PAIR, start, period=2, phase=phase, parameters=values, transient=0)
    return ns.continue_orbit(PAIR, "A", (1.9, 2.3), initial=first, phase=phase, parameters=values)


def twins(branch):
    """Points at which a strobe is told twice, with the number of the strobe."""
    strobes = branch["strobes"].values
    same = np.abs(np.diff(branch["A"].values)) <= 1e-12
    jumps = np.abs(np.diff(strobes[..., 1], axis=0)) > 0.1
    return np.argwhere(jumps & same[:, None])


@pytest.mark.few(1)
@pytest.mark.parametrize(("name", "strobe"), [("symmetric", 0), ("of_two_periods", 1)])
def test_speeds_before_and_behind_the_impact(request, name, strobe):
    branch = request.getfixturevalue(name)
    found = twins(branch)
    assert strobe in found[:, 1]
    for point, number in found:
        pair = branch["strobes"].values[point : point + 2, number]
        assert np.allclose(np.abs(pair[:, 0]), D, rtol=0, atol=1e-10)  # at a wall
        before = np.argmax(np.abs(pair[:, 1]))
        assert pair[1 - before, 1] == pytest.approx(-R * pair[before, 1], abs=1e-9)
        assert pair[before, 0] * pair[before, 1] > 0.0  # towards the wall
        # a run from this very orbit meets all other strobes
        others = np.arange(branch.sizes["strobe_of_turn"]) != number
        one, other = branch["strobes"].values[point : point + 2, others]
        assert np.allclose(one, other, rtol=0, atol=1e-9)


def test_no_impact_passes_a_strobe_between_points(of_two_periods):
    """Between two of the same word no event changes sides, but where the orbit stands twice."""
    times, strobes = of_two_periods["leg_time"].values, of_two_periods["strobe_times"].values
    words, values = of_two_periods["word"].values, of_two_periods["A"].values
    alike = (words[1:] == words[:-1]) & (np.abs(np.diff(values)) > 1e-12)
    assert alike.sum() > 20
    for k in np.flatnonzero(alike):
        one, other = (strobes[i][None, :] - times[i][1:, None] for i in (k, k + 1))
        changes = (one * other < 0.0) & (np.minimum(np.abs(one), np.abs(other)) > 1e-9)
        assert not changes.any()


def test_the_line_reaches_the_jump_from_either_side(symmetric):
    (point, _), *_ = twins(symmetric)
    value = float(symmetric["A"][point])
    ax = ns.plot.branch(symmetric, "v")
    drawn = np.concatenate(
        [line.get_xydata() for line in ax.lines if str(line.get_gid()).startswith("branch")]
    )
    plt.close(ax.figure)
    for speed in symmetric["v"].values[point : point + 2]:
        near = np.abs(drawn - [value, speed]) <= 1e-9
        assert near.all(axis=1).any()
    # and no line leads over it
    between = np.sort(symmetric["v"].values[point : point + 2]) + np.array([0.1, -0.1])
    over = (
        (np.abs(drawn[:, 0] - value) <= 1e-9)
        & (drawn[:, 1] > between[0])
        & (drawn[:, 1] < between[1])
    )
    assert not over.any()


def clocked(begin):
    """The same ball, whose forcing is a clock that is set back once per period."""
    return ns.System(
        states=["x", "v", "c"],
        parameters={"A": 1.5, "r": R, "d": D},
        period="2*pi",
        initial={"v": 0.5, "c": begin},
        modes={
            "fly": ns.Mode(
                {"x": "v", "v": "A*cos(c)", "c": "1"},
                exits=[
                    ns.Exit("d - x", reset={"v": "-r*v"}, name="right"),
                    ns.Exit("d + x", reset={"v": "-r*v"}, name="left"),
                    ns.Exit("2*pi - c", reset={"c": "c - 2*pi"}, name="tick"),
                ],
            )
        },
    )


@pytest.fixture(scope="module", params=[0.0, 0.7], ids=["strobe at the tick", "later"])
def by_clock(request):
    return request.param, ns.continue_orbit(clocked(request.param), "A", (0.5, 3.0))


def test_a_clock_shows_what_the_forcing_does(by_clock, symmetric):
    """An impact passes the tick where it passes the strobe of the driven ball, in closed form."""
    begin, branch = by_clock
    assert branch["A"].values.min() == 0.5
    assert branch["A"].values.max() == 3.0
    (point, _), *others = twins(branch)
    assert not others
    if begin == 0.0:
        assert float(branch["A"][point]) == pytest.approx(
            float(symmetric["A"][twins(symmetric)[0][0]]), abs=1e-11
        )
    pair = branch["strobes"].values[point : point + 2, 0]
    assert np.allclose(np.abs(pair[:, 0]), D, rtol=0, atol=1e-10)
    speeds = pair[:, 1]
    before = np.argmax(np.abs(speeds))
    assert speeds[1 - before] == pytest.approx(-R * speeds[before], abs=1e-9)
    # each state is on the side of the next orbit there
    for side, neighbour in ((0, point - 1), (1, point + 2)):
        assert np.sign(branch["strobes"].values[neighbour, 0, 1]) == np.sign(speeds[side])


def test_the_line_of_a_clock_reaches_the_jump_from_either_side(by_clock):
    begin, branch = by_clock
    (point, _), *_ = twins(branch)
    value, pair = float(branch["A"][point]), branch["strobes"].values[point : point + 2, 0, 1]
    behind = ns.bifurcation_diagram(clocked(begin), "A", [1.0, 2.0], transient=20, record=10)
    ax = ns.plot.branch(branch, "v", diagram=behind)
    lines = [line.get_xydata() for line in ax.lines if str(line.get_gid()).startswith("branch")]
    plt.close(ax.figure)
    drawn = np.concatenate(lines)
    for speed in pair:
        assert (np.abs(drawn - [value, speed]) <= 1e-9).all(axis=1).any()
    for line in lines:  # no line leads over the jump
        there = np.abs(line[:, 0] - value) <= 1e-9
        over = there[1:] & there[:-1]
        assert not np.any(over & (np.abs(np.diff(line[:, 1])) > 0.1))
