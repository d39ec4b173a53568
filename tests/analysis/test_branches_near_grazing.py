"""Branches near grazing and sliding, against motions of scipy's DOP853 with events."""

import numpy as np
import pytest
from scipy.optimize import fsolve

import nonsmooth as ns
from analysis.impact_truth import multipliers_of_motion, oscillator, period_of_motion

GEAR = """
name = "rattling gears"
states = ["u", "w"]
period = "1/n"
[parameters]
m = 0.8
c = 12.0
k = 2.0e5
half = 1.0e-4
T = 30.0
A = 45.0
n = 40.0
mu = 2.5
[surfaces.rub]
function = "w"
[equations]
u = "w"
w = "(T + A*cos(2*pi*n*t) - c*w - k*(u - clip(u, -half, half)) - mu*sign(rub))/m"
"""


def specials(branch):
    """Kinds and values of the special points, but for the end of the range."""
    kinds, values = branch["special_kind"].values.tolist(), branch["special_value"].values.tolist()
    return [(k, p) for k, p in zip(kinds, values, strict=True) if k != "bound"]


def assert_same(one, other, rel=1e-9):
    """The same special points, told from either end."""
    kinds = [kind for kind, _ in one]
    if kinds != [kind for kind, _ in other]:
        other = other[::-1]
    assert kinds == [kind for kind, _ in other]
    assert [p for _, p in one] == pytest.approx([p for _, p in other], rel=rel)


def assert_no_part_twice(branch, parameter):
    """No orbit lies on the way between two neighbouring points elsewhere on the branch.

    Between them the way is straight to the second order of a step; steps turn by 0.15 at most.
    """
    p, word = branch[parameter].values, branch["word"].values
    states = np.stack([branch["x"].values, branch["v"].values], axis=1)
    for j in range(p.size - 1):
        step = states[j + 1] - states[j]
        same = (word == word[j]) & (word == word[j + 1])
        between = (p - p[j]) * (p - p[j + 1]) < 0.0
        apart = np.abs(np.arange(p.size) - j - 0.5) > 4.0
        for i in np.flatnonzero(same & between & apart):
            share = (p[i] - p[j]) / (p[j + 1] - p[j])
            off = np.abs(states[j] + share * step - states[i]).max()
            assert off > 1e-2 * np.abs(step).max()


@pytest.mark.slow
@pytest.mark.parametrize("w", [0.8, 1.2, 2.0])
def test_a_branch_does_not_turn_back_at_a_graze(w):
    """Of two impacts down to w = 0.7077, of three from there on: a fold, and stable below it."""
    system = oscillator(w)
    branch = ns.continue_orbit(system, "w", (0.4, 2.5))
    assert bool(branch["admissible"].all())
    assert_no_part_twice(branch, "w")
    found = specials(branch)
    assert len({(kind, round(p, 8)) for kind, p in found}) == len(found)
    places = np.array([p for _, p in found])
    for wanted, kind in [(0.70768, "grazing"), (0.708933, "fold"), (0.669992, "grazing")]:
        near = int(np.argmin(np.abs(places - wanted)))
        assert places[near] == pytest.approx(wanted, abs=2e-6)
        assert found[near][0] == kind
    # every orbit there is a motion of scipy with as many impacts
    for k in np.flatnonzero((branch["w"].values < 0.72) & (branch["w"].values > 0.671))[::2]:
        if k in branch["special_point"].values:
            continue
        point = branch.isel(point=int(k))
        state = np.array([float(point["x"]), float(point["v"])])
        end, speeds = period_of_motion(system, float(point["w"]), state)
        assert np.abs(end - state).max() < 1e-7 * max(1.0, abs(point["multipliers"][0].item()))
        assert speeds.size == len(point["word"].item().split()) - 1


@pytest.mark.slow
@pytest.mark.parametrize(("w", "impacts"), [(0.71, 2), (0.68, 3)])
def test_motions_settle_to_the_branch_behind_grazes(w, impacts):
    system = oscillator(w)
    state = np.array([0.0, 0.0])
    for _ in range(60):
        state, speeds = period_of_motion(system, w, state)
    assert speeds.size == impacts
    branch = ns.continue_orbit(oscillator(1.2), "w", (w, 2.5))
    ends = [branch.isel(point=k) for k in (0, -1) if float(branch["w"][k]) == w]
    assert any(
        abs(float(end["x"]) - state[0]) < 1e-8
        and bool(end["stable"])
        and len(end["word"].item().split()) == impacts + 1
        for end in ends
    )


def rubbing(w, **options):
    return oscillator(w, r=0.7, g=0.3, z=0.05, f=0.2, **options)


@pytest.mark.slow
def test_a_flip_just_before_a_graze_is_found_from_everywhere():
    """The multiplier goes to minus infinity at the graze, and passes -1 between these values."""
    assert multipliers_of_motion(*_orbit_at(2.0264)).real.min() > -1.0
    assert multipliers_of_motion(*_orbit_at(2.0265)).real.min() < -1.0
    first = None
    for w in (1.3, 1.6, 1.8, 2.1, 2.6):
        branch = ns.continue_orbit(rubbing(w), "w", (1.25, 3.0))
        found = specials(branch)
        first = first or found
        assert_same(found, first)
        places = dict(found)
        assert 2.0264 < places["flip"] < 2.0265
        which = branch["special_kind"].values.tolist().index("grazing")
        assert branch["special_multiplier"].values[which] == np.inf
        w_of = branch["w"].values
        unstable = (w_of > places["flip"] + 1e-9) & (w_of < places["grazing"] - 1e-9)
        assert not branch["stable"].values[unstable].any()


def _orbit_at(w):
    """The orbit with one impact near the graze, by the fixed point of the map of scipy."""
    system = rubbing(w)

    def gap(state):
        return period_of_motion(system, w, state)[0] - state

    state = fsolve(gap, [-0.3165, 0.2016], xtol=1e-11)
    assert np.abs(gap(state)).max() < 1e-9
    assert period_of_motion(system, w, state)[1].size == 1
    return system, w, state


@pytest.mark.slow
def test_impacts_jump_over_a_surface_that_holds():
    """Where nothing sticks, an orbit is the same with static friction, and so is its branch."""
    plain = ns.continue_orbit(rubbing(1.3), "w", (1.25, 3.0))
    held = ns.continue_orbit(rubbing(1.3, hold=1), "w", (1.25, 3.0))
    assert_same(specials(plain), specials(held))
    stiffer = ns.continue_orbit(rubbing(1.3, hold=1.5), "w", (1.25, 3.0))
    for branch, hold in ((held, 1), (stiffer, 1.5)):
        system = rubbing(1.3, hold=hold)
        for k in range(1, branch.sizes["point"], 9):
            point = branch.isel(point=k)
            state = np.array([float(point["x"]), float(point["v"])])
            end, _ = period_of_motion(system, float(point["w"]), state)
            assert np.abs(end - state).max() < 1e-8


@pytest.mark.slow
def test_special_points_of_gears_do_not_depend_on_the_start():
    found = {}
    for n in (25.0, 34.5, 40.0):
        system = ns.System.from_toml(GEAR).with_parameters(n=n)
        branch = ns.continue_orbit(system, "n", (20.0, 60.0))
        assert (branch.attrs["end_first"], branch.attrs["end_last"]) == ("bound", "bound")
        assert bool(branch["admissible"].all())
        found[n] = specials(branch)
        # at its corner the contact is lost just where the gears are at rest beside one another
        which = int(np.argmin(np.abs(branch["special_value"].values - 36.318)))
        assert branch["special_kind"].values[which] == "corner"
        point = branch.isel(point=int(branch["special_point"][which]))
        u, w = point["leg_states"].values.T
        touching = np.abs(u - 1e-4) + np.abs(w) / (2 * np.pi * n)
        assert np.nanmin(touching) < 1e-10
    for n in (25.0, 34.5):
        assert_same(found[n], found[40.0], rel=1e-8)


@pytest.mark.slow
def test_changes_on_both_sides_of_a_symmetric_orbit_at_once_are_passed():
    """It touches both walls at w = 0.92326: a branch ended there, or went on, by where it began."""
    found = []
    for w in (0.7, 1.3, 2.0):
        branch = ns.continue_orbit(rubbing(w, both=True), "w", (0.65, 3.0))
        assert bool(branch["admissible"].all())
        assert_no_part_twice(branch, "w")
        found.append(specials(branch))
        assert_same(found[-1], found[0], rel=1e-8)
    places = {round(p, 4): kind for kind, p in found[0]}
    assert places[0.9233] == "grazing"
    assert places[0.9913] == "fold"


@pytest.mark.slow
@pytest.mark.parametrize("hold", [pytest.param(None, marks=pytest.mark.slow), 1])
def test_changes_of_sliding_do_not_depend_on_the_start(hold):
    found = []
    for w in (0.7, 1.3, 2.0):
        branch = ns.continue_orbit(rubbing(w, hold=hold), "w", (0.6, 3.0))
        assert bool(branch["admissible"].all())
        found.append([p for _, p in specials(branch)])
        assert found[-1] == pytest.approx(found[0], rel=1e-8)
    assert len(found[0]) > 10


@pytest.mark.slow
def test_messages_do_not_name_tests():
    branch = ns.continue_orbit(rubbing(1.3, hold=1), "w", (0.5, 3.0))
    said = [branch.attrs["message"], *branch["special_detail"].values.tolist()]
    for name in ("gain:", "graze:", "corner:", "enter:", "slide:", "leg:", "rate:", "short:"):
        assert not any(name in text for text in said)


def random_oscillator(seed):
    """One wall or two, with friction or without, and a frequency to begin with."""
    random = np.random.default_rng(seed)
    w, z, r, g, f = (random.uniform(*ends) for ends in RANGES)
    kind = random.integers(3)
    return oscillator(w, z=z, r=r, g=g, f=f * (kind > 0), both=kind == 2)


RANGES = [(0.6, 2.2), (0.02, 0.2), (0.2, 0.8), (0.1, 0.8), (0.05, 0.25)]


LONGEST = {2, 15}  # of the seeds
SEEDS = [pytest.param(k, marks=[pytest.mark.slow] * (k in LONGEST)) for k in range(30)]


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_every_point_of_a_branch_is_a_motion(seed):
    """None is inadmissible, none is passed twice, and none changes its stability for no reason."""
    system = random_oscillator(seed)
    try:
        branch = ns.continue_orbit(system, "w", (0.5, 2.6), steps=40)
    except ns.OptionError as fault:  # chaotic, or at the end of rebounds
        assert "no orbit to begin with" in str(fault)
        return
    assert "fault" not in (branch.attrs["end_first"], branch.attrs["end_last"])
    assert bool(branch["admissible"].all())
    assert_no_part_twice(branch, "w")
    if "special point was found that tells why" in branch.attrs["message"]:
        return  # told
    sizes = np.abs(branch["multipliers"].values)
    special = set(branch["special_point"].values.tolist())
    for k in range(branch.sizes["point"] - 1):
        pair = sizes[k : k + 2]
        clear = np.all(np.isfinite(pair)) and np.all(np.abs(pair - 1.0) > 1e-6)
        if clear and not special & {k, k + 1}:
            assert np.ptp(np.count_nonzero(pair > 1.0, axis=1)) == 0


def test_a_contact_where_positions_are_zero():
    """A cable begins to slacken at P* = m g/k |k - m w**2 + i w c|, found from the slack side.

    In the slack mode nothing holds the mass, so rounding is that of lengths of metres: the instants
    of short contacts are known to that over a small speed.
    """
    k, m, c, g, w = 1e6, 250.0, 200.0, 9.81, 40.0
    cable = ns.System(
        states=["x", "v"],
        parameters={"P": 1480.0},
        period=f"2*pi/{w}",
        equations={"x": "v", "v": f"{g} + P/{m}*cos({w}*t) - {c / m}*v - {k / m}*max(x, 0)"},
    )
    slack = ns.find_orbit(cable, {"x": 0.005}, word="flow[+] flow[-] flow[+]", transient=0)
    branch = ns.continue_orbit(cable, "P", (0.0, 6000.0), initial=slack, direction="down")
    assert branch["special_kind"].values.tolist() == ["bound", "grazing"]
    expected = m * g / k * abs(k - m * w**2 + 1j * w * c)
    assert branch["special_value"].values[1] == pytest.approx(expected, rel=1e-11)
