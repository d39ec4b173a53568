"""Maps, exponents, basins, diagrams and regimes of motions that stick, slide and rest."""

import warnings

import numpy as np
import pytest
from mpmath import mp, mpf

import nonsmooth as ns
from analysis.test_sliding_branches import belt, exact
from periodic_orbits.references import belt as reference
from periodic_orbits.references import chatter
from periodic_orbits.test_sliding_orbits import belt as belt_alone
from periodic_orbits.test_sliding_orbits import wall


@pytest.fixture(autouse=True)
def no_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


@pytest.mark.slow
def test_strobes_of_a_motion_that_rests_in_every_period():
    strobes = ns.stroboscopic_map(wall(), {"x": -1.0}, transient=2, record=4)
    x, v = chatter.state_at(0.3, 0.8, 2 * mp.pi / mpf("0.3"))
    assert strobes["x"].values == pytest.approx(float(x), abs=1e-12)
    assert strobes["v"].values == pytest.approx(float(v), abs=1e-12)


def test_sections_where_the_belt_is_reached_and_left():
    """Stick from x = F_k - D to F_k + D with D = F_s - F_k, in a closed form of the period."""
    system, D = belt_alone(), 0.6 - 0.4
    period = 2 * D / 0.3 + 2 * np.pi - 2 * np.arctan(D / 0.3)
    entries = ns.poincare_section(system, section="stick", transient=20.0, record=4)
    assert entries["x"].values == pytest.approx(0.4 - D, abs=1e-13)
    assert np.diff(entries["time"].values) == pytest.approx(period, rel=1e-12)
    both = ns.poincare_section(system, section="slip", transient=20.0, record=6)
    assert sorted(both["x"].values.round(12)) == [0.2] * 3 + [0.6] * 3


def test_a_kind_of_events_is_no_section():
    with pytest.raises(ns.OptionError, match="kind of events; give the name of the exit, surface"):
        ns.poincare_section(belt_alone(), section="slide_entry")


def test_a_section_at_the_release_from_rest():
    points = ns.poincare_section(wall(), {"x": -1.0}, section="release", record=3)
    quarter = np.pi / 2 / 0.3  # the force changes its sign
    assert points["phase"].values == pytest.approx(quarter, rel=1e-12)
    assert np.all(points["x"].values == 0.0) and np.all(points["v"].values == 0.0)


def test_exponents_of_a_motion_that_sticks():
    system = belt(v_b=0.64)
    found = ns.lyapunov_spectrum(system, transient=30, record=200)
    orbit = ns.find_orbit(system, transient=20)
    there = exact(2.0, 0.64)
    entry, leave = orbit["leg_time"].values[1:3]
    entry, x, leave = reference.solved(
        lambda *u: reference.stick_and_lag(there, *u),
        (entry, float(orbit["leg_states"][1, 0]), leave),
    )
    wanted = float(mp.log(abs(reference.multiplier(there, entry, x, leave))) / there.period)
    exponents = found["lyapunov_exponent"].values
    # the mean over 200 periods of a motion that has come within rounding of its orbit
    assert exponents[0] == pytest.approx(wanted, abs=1e-6)
    assert exponents[1] == -np.inf
    assert float(found["exponent_sum"]) == -np.inf
    assert float(found["kaplan_yorke_dimension"]) == 0.0


def test_exponents_of_a_motion_that_rests():
    found = ns.lyapunov_spectrum(wall(), {"x": -1.0}, transient=3, record=20)
    assert found["lyapunov_exponent"].values.tolist() == [-np.inf, -np.inf]


def test_exponents_of_a_cycle_that_sticks():
    found = ns.lyapunov_spectrum(belt_alone(), transient=20, record=300)
    along, across = found["lyapunov_exponent"].values
    assert along == pytest.approx(0.0, abs=1e-12) and across == -np.inf


def two_walls() -> ns.System:
    """A hill between two walls: x'' = x. Slow starts rest at the wall that they roll to."""
    return ns.System(
        states=["x", "v"],
        parameters={"r": 0.5},
        modes={
            "between": ns.Mode(
                {"x": "v", "v": "x"},
                exits=[
                    ns.Exit("1 - x", reset={"v": "-r*v"}, sticks="right", name="right_wall"),
                    ns.Exit("1 + x", reset={"v": "-r*v"}, sticks="left", name="left_wall"),
                ],
            )
        },
    )


def test_a_ball_at_rest_is_a_fixed_point():
    ball = ns.System(
        states=["x", "v"],
        parameters={"g": 1.0, "r": 0.5},
        modes={
            "flight": ns.Mode(
                {"x": "v", "v": "-g"},
                exits=[ns.Exit("x", reset={"v": "-r*v"}, sticks="rest", name="impact")],
            )
        },
    )
    strobe = ns.StroboscopicMap(ball, period=1.0)
    found = ns.attractors(strobe, {"x": (0.1, 1.0), "v": (-1.0, 1.0)}, samples=60)
    assert found["kind"].values.tolist() == ["periodic"]
    assert found["period"].values.tolist() == [1]
    assert found["word"].values.tolist() == ["rest"]
    assert np.all(found["points"].values == 0.0)
    assert np.all(found["multiplier_real"].values == 0.0)
    assert float(found["fraction"][0]) == 1.0


def test_basins_of_two_places_of_rest():
    """The border is the stable direction of the top, v = -x; impacts below 1/r do not cross it."""
    strobe = ns.StroboscopicMap(two_walls(), period=1.0)
    axis = np.linspace(-0.9, 0.9, 10)
    found = ns.basins_of_attraction(strobe, {"x": axis, "v": axis + 0.03})
    assert sorted(found["points"].values[:, 0, 0]) == [-1.0, 1.0]
    place = found["points"].sel(state="x").values[:, 0]
    x, v = found["x"].values, found["v"].values[:, None]
    label = found["label"].transpose("v", "x").values
    assert np.all(place[label - 1] == np.sign(x + v))


def borders() -> list[float]:
    """Speeds of the belt at which the word changes, from the equations of each change."""
    *_, cross = reference.crossing(exact(2.0), (0.4596, 0.2127, 0.9, 0.511))
    *_, switch = reference.switching(exact(2.0), (0.518, 0.147, 0.756, 0.627))
    return [float(cross), float(switch), float(reference.grazing(exact(2.0)))]


WORDS = ("lag lead lag", "lag lead stick lag", "lag stick lag", "lag")


def test_words_of_a_diagram_change_where_sliding_does():
    values = np.sort(np.concatenate([np.add.outer(borders(), (-2e-3, 2e-3)).ravel(), [0.45]]))
    diagram = ns.bifurcation_diagram(belt(), "v_b", values, transient=300, record=4)
    wanted = [WORDS[k] for k in np.searchsorted(borders(), values)]
    assert diagram["word"].values[:, 0].tolist() == wanted
    assert np.all(diagram["period"].values == 1)


def test_words_of_a_regime_map_change_where_sliding_does():
    values = np.array([0.45, 0.55, 0.64, 0.7])
    found = ns.regime_map(belt(), {"v_b": values, "zeta": [0.05]})
    assert found["word"].values.ravel().tolist() == list(WORDS)


def test_a_motion_that_rests_is_locked():
    found = ns.regime(wall(), {"x": -1.0})
    assert found["regime"].item() == "locked"
    assert found["word"].item() == "free stuck free"
    assert float(found["exponent"]) == -np.inf
    run = ns.simulate(wall(), {"x": -1.0}, periods=4)
    period = run.attrs["period"]
    words = ns.phase_word(run, 2 * period, 3 * period)
    # rebounds behind the release come to rest in the next period
    assert words[:3] == ("free", "stuck", "free") and set(words[3:]) == {"free"}
    assert ns.find_orbit(wall(), word=words)["word"].item() == "free stuck free"
