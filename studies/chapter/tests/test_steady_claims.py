"""Steady motions of Fig. 7, and verdicts that move when the data of a machine do."""

from dataclasses import replace

import numpy as np
import pytest

from nonsmooth.fatigue import chapter_tests
from nonsmooth.models import moling
from nonsmooth_chapter import evaluate_claims
from nonsmooth_chapter.claims import _check
from nonsmooth_chapter.fatigue import life_claims
from nonsmooth_chapter.figures import draw_figure
from nonsmooth_chapter.judgement import DIFFERS, HOLDS
from nonsmooth_chapter.mole import history_claims
from nonsmooth_chapter.mole.model_claims import push
from nonsmooth_chapter.rotor import rig_claims

_PUSH = ("penetration", "resistance")


def verdicts(*names):
    return [row["verdict"] for row in evaluate_claims(ids=names)]


@pytest.fixture(scope="module")
def rows():
    return {row["id"]: row for row in evaluate_claims(ids=["M09", "M10", "M11", "M12"])}


@pytest.mark.slow
def test_periods_of_fig_7(rows):
    """From rest and from every random start four, two and one; a multiplier within the circle."""
    for name, period in (("M09", 4), ("M10", 2), ("M11", 1)):
        evidence = rows[name]["evidence"]
        assert rows[name]["verdict"] == HOLDS
        assert [each["period"] for each in evidence["attractors"]] == [period]
        assert evidence["unsettled"] == 0 and 0.0 < evidence["multiplier"] < 1.0


@pytest.mark.slow
def test_chaos_of_fig_7_beside_a_period(rows):
    """The chaotic motion is that from rest; a period-one motion coexists, and the row says so."""
    row = rows["M12"]
    assert row["verdict"] == HOLDS
    assert {each["period"] for each in row["evidence"]["attractors"]} == {0, 1}
    assert row["evidence"]["exponent"] > 20.0 * row["evidence"]["exponent_error"] > 0.0
    assert "find period 1" in row["computed"]


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("M09", {"period": 2}),
        ("M10", {"multiplier": 1.2}),
        ("M11", {"period": 0, "residual": 0.1}),
        ("M12", {"exponent": 0.01}),  # within its standard error
        ("M12", {"period": 3}),
        ("M12", {"spectra": [{"b": 0.19, "high_share": 0.004, "impacts_per_period": 2.0},
                             {"b": 0.1, "high_share": 0.0025, "impacts_per_period": 1.0}]}),
    ],
)  # fmt: skip
def test_other_evidence_turns_the_verdict(rows, name, change):
    assert not _check(name).judge(rows[name]["evidence"] | change).true


@pytest.mark.slow
def test_another_static_force_has_another_regime():
    """The period-one motion of Fig. 7(d) is not chaotic, that of (e) has no period of one."""
    assert not _check("M12").judge(_check("M12").compute(b=0.15, starts=20)).true
    assert not _check("M11").judge(_check("M11").compute(b=0.19, starts=20)).true


@pytest.mark.slow
def test_another_mole_has_other_verdicts(monkeypatch):
    """With a slider damped six times as much period four is gone, with ten times two as well."""
    monkeypatch.setattr(history_claims, "moling", lambda b: moling(b=b, xi=0.3))
    assert verdicts("M09", "M10", "M11") == [DIFFERS, HOLDS, HOLDS]
    monkeypatch.setattr(history_claims, "moling", lambda b: moling(b=b, xi=0.5))
    assert verdicts("M10") == [DIFFERS]


def test_another_rotor_has_other_verdicts(monkeypatch):
    """A rotor of twice the mass: neither its natural frequency nor its scaled data are printed."""
    assert verdicts("R01", "R03") == [HOLDS, HOLDS]
    rig = rig_claims.rig
    monkeypatch.setattr(rig_claims, "rig", lambda **given: replace(rig(**given), mass=19.4))
    assert verdicts("R01", "R03") == [DIFFERS, DIFFERS]


def test_other_fatigue_tests_have_other_verdicts(monkeypatch):
    """Two lives exchanged, one amplitude changed: their order, and the ratio of loads."""
    assert verdicts("F02", "F06") == [HOLDS, HOLDS]
    tests = chapter_tests().copy(deep=True)
    where = {str(name): k for k, name in enumerate(tests["test"].values)}
    lives = tests["life"].values
    lives[[where["hl150(100)"], where["hl200(100)"]]] = lives[
        [where["hl200(100)"], where["hl150(100)"]]
    ]
    tests["load_amplitude"].values[where["hl200(50)"]] = 80.0
    monkeypatch.setattr(life_claims, "chapter_tests", lambda: tests)
    assert verdicts("F02", "F06") == [DIFFERS, DIFFERS]


@pytest.mark.parametrize(
    ("arguments", "true"),
    [
        ({"dampings": (0.05,)}, True),
        # the damper adds 2 xi times the speed: far from the law however slow the push
        ({"dampings": (100.0,), "rates": (1e-4,)}, False),
        # a push less deep than the spring's deflection under the friction limit never slips
        ({"dampings": (0.05,), "rates": (1e-4,), "depth": 0.8}, False),
    ],
)
def test_another_soil_moves_the_finding(arguments, true):
    """The row stays open for want of a measured curve; what the predicate finds does not."""
    check = _check("M02")
    assert check.judge(check.compute(**arguments)).true is true


@pytest.mark.parametrize(
    "change",
    [
        {"fall_before_threshold": 1e-3},
        {"departure_from_threshold": 1e-3},
        {"reaches_threshold": False},
        {"rate": 1e-4, "law_distance": 0.02},
    ],
)
def test_each_part_of_the_soil_law_decides(change):
    row = push(0.05, 1.0)
    judge = _check("M02").judge
    assert judge({"pushes": [row]}).true
    assert not judge({"pushes": [row, row | change]}).true


def test_soil_figure_follows_its_parameters():
    """A slider damped more departs further from the law in fast pushes, and slips alike."""
    data = {xi: draw_figure("fig3b", xi=xi)[1] for xi in (0.05, 0.35)}
    fast = {
        xi: float(np.interp(0.5, *(each[name].values[-1, :1000] for name in _PUSH)))
        for xi, each in data.items()
    }
    # at depth 0.5 the speed is sqrt(0.5 (2.5 - 0.5)) times the rate: 2 xi 4 + 0.5 with xi 0.05
    assert fast[0.05] == pytest.approx(0.9, abs=1e-3)
    assert fast[0.35] == pytest.approx(1.0, abs=1e-12)
    assert all(each.attrs["xi"] == xi for xi, each in data.items())


def test_soil_figure_is_the_law_where_it_must_be():
    """Slow pushes follow min(depth, 1); the mole's resistance is limited and comes to nothing."""
    figure, data = draw_figure("fig3b")
    assert [ax.get_ylabel() for ax in figure.axes] == ["resistance [$P_f$]", "", ""]
    slow = data.isel(rate=0)
    half = slow.sizes["sample"] // 2
    depth = slow["penetration"].values[: half + 1]
    law = abs(slow["resistance"].values[: half + 1] - depth.clip(max=1.0)).max()
    # the damper adds 2 xi times the speed of the push, depth/2 times its rate at most
    assert law < 2 * 0.05 * 1.25 * 1e-4 * 1.01
    assert push(0.05, 1e-4, 2.5)["law_distance"] == pytest.approx(law, rel=0.02)
    for name in ("resistance", "mole_resistance"):
        force = data[name].values
        assert force.min() > -1e-9 and force.max() == pytest.approx(1.0, abs=1e-12)
    assert float(data["mole_resistance"][-1]) == pytest.approx(0.0, abs=1e-9)
    # it slips by the progression of one period, which claim M11 has too
    assert float(data["mole_penetration"].max()) == pytest.approx(31.345 + 1.0, abs=0.03)
