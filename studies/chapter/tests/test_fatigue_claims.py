"""Claims on the cracked beam: predicates that can come out either way, and closed forms."""

import json

import numpy as np
import pytest

from nonsmooth_chapter import claim_ids, evaluate_claims
from nonsmooth_chapter.claims import _check, _table
from nonsmooth_chapter.fatigue.crack_claims import arc_distance, circle_criterion
from nonsmooth_chapter.fatigue.crack_motions import (
    beam,
    crack_at,
    motions,
    onset_along_growth,
    period_of,
    settling,
    tau_at,
)
from nonsmooth_chapter.fatigue.growing_crack import first_loss, label_share, scatter, separators
from nonsmooth_chapter.fatigue.growth_claims import BETWEEN
from nonsmooth_chapter.fatigue.life_figures import fig18, fig19, fig20
from nonsmooth_chapter.judgement import DIFFERS, HOLDS, OPEN, verdict
from verdicts import changes, expected_verdicts, verdicts_of

QUICK_CRACK = ["F33", "F34", "F35", "F40", "F41", "F42", "F43", "F44"]
SLOW_CRACK = [f"F{n}" for n in range(33, 60) if f"F{n}" not in QUICK_CRACK]


def judged(name, evidence):
    return verdict(_check(name).judge(evidence), lacks_data=bool(_table()[name]["missing"]))


def finding(name, evidence):
    return _check(name).judge(evidence).true


def computed(name, **arguments):
    return _check(name).compute(**arguments)


def test_every_claim_of_the_crack_is_judged():
    assert {f"F{n}" for n in range(33, 60)} <= set(claim_ids())


def test_stiffness_falls_and_by_how_much():
    evidence = computed("F33")
    assert judged("F33", evidence) == HOLDS
    assert evidence["closed"] == pytest.approx(48 * 72.4e3 * 10 * 20**3 / 12 / 270**3, rel=1e-12)
    assert judged("F33", evidence | {"least_fall": -1e-3}) == DIFFERS
    assert judged("F34", computed("F34")) == DIFFERS
    assert judged("F34", computed("F34", ratios=(0.1, 0.2))) == HOLDS
    assert judged("F35", computed("F35")) == DIFFERS
    assert judged("F35", computed("F35", ratios=(0.25, 0.3))) == HOLDS


def test_printed_law_and_shape():
    assert computed("F40")["law"] == pytest.approx(14.326875, rel=1e-12)
    assert judged("F40", computed("F40")) == HOLDS
    assert judged("F40", computed("F40", printed="14.329")) == DIFFERS
    assert judged("F41", computed("F41")) == DIFFERS
    assert judged("F41", computed("F41", last=5.2)) == HOLDS


def test_growth_curve():
    """a = 5 + 1e-3 exp(tau / 54734 - 7.8), by hand."""
    assert crack_at(tau_at(12.0)) == pytest.approx(12.0, rel=1e-12)
    assert tau_at(5.001) == pytest.approx(7.8 * 54734.0, rel=1e-12)
    assert judged("F42", computed("F42")) == HOLDS
    assert judged("F42", computed("F42", tau=910_000.0)) == DIFFERS
    assert judged("F43", computed("F43")) == HOLDS
    assert judged("F43", computed("F43", before=911_000.0)) == DIFFERS
    assert judged("F44", computed("F44")) == HOLDS
    assert judged("F44", computed("F44", end=2e6)) == DIFFERS
    assert judged("F44", computed("F44", share=1e-6)) == DIFFERS


def test_growth_is_linear_only_where_it_is():
    evidence = {
        "rows": [{"crack": 6.0, "departure": 0.01}], "before": 0.01, "share_of_time": 0.5,
        "onset": {"crack": 14.0},
    }  # fmt: skip
    assert judged("F58", evidence) == HOLDS
    assert judged("F58", evidence | {"before": 0.5}) == DIFFERS


@pytest.mark.parametrize("force", [0.0, 0.7, -1.3])
def test_circle_criterion_holds_for_every_force(force):
    """Where it does not reach 1, random starts of any force meet: closed and open may differ."""
    crack = 5.07
    assert circle_criterion(crack, 1.0) < 1.0
    waits = settling(beam(crack, d=force), starts=8, longest=600)
    assert waits["aperiodic"] == 0
    assert [row["period"] for row in motions(beam(crack, d=force), 16)] == [1]


def test_regimes_follow_the_start_at_rest():
    evidence = {
        "crack": 12.09, "attractors": [], "followed": [], "scan": {"cases": 1, "shares": {}},
        "settling": {"longest": None},
        "starts": [{"u": 0.0, "v": 0.0, "period": 0, "chaotic": True, "exponent": 0.3, "error": 0}],
    }  # fmt: skip
    assert finding("F46", evidence)
    assert judged("F46", evidence) == OPEN
    assert not finding("F48", evidence)
    evidence["starts"][0] |= {"period": 4}
    assert finding("F48", evidence) and not finding("F47", evidence)


def test_arcs_on_one_path():
    """Arcs of one circle that end at different places are on one path, of two circles not."""
    angle = np.linspace(0.5 * np.pi, 1.5 * np.pi, 400)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert arc_distance([circle, circle[100:300]]) < 1e-12
    assert arc_distance([circle, 0.5 * circle]) == pytest.approx(0.5, abs=0.26)


def orbits(periods, sizes, distance):
    rows = [
        {"ratio": r, "period": p, "amplitude": a, "slopes": 1.2, "crosses": True}
        for r, p, a in zip((0.32, 0.5, 0.7, 0.9), periods, sizes, strict=True)
    ]
    scan = dict.fromkeys(("cases", "period_one", "growing", "one_path", "crossing", "visible"), 1)
    return {
        "convention": {"guinea": {"rows": rows, "distance": distance}},
        "scan": scan | {"distance": distance, "slope": 1.2},
    }  # fmt: skip


def test_portraits():
    good = orbits([1, 1, 1, 1], [0.1, 0.2, 0.3, 0.4], 0.01)
    bad = orbits([1, 1, 1, 2], [0.1, 0.3, 0.2, 0.4], 0.5)
    for name, expected in {"F36": OPEN, "F37": OPEN, "F38": HOLDS, "F39": HOLDS}.items():
        assert finding(name, good)
        assert judged(name, good) == expected
    for name in ("F36", "F37", "F38"):
        assert not finding(name, bad)
    assert judged("F38", bad) == OPEN  # one path for some of what the chapter lacks
    bad["scan"]["one_path"] = 0
    assert judged("F38", bad) == DIFFERS
    bad["convention"]["guinea"]["rows"][1]["crosses"] = False
    assert not finding("F39", bad)
    assert judged("F39", good | {"scan": good["scan"] | {"slope": 1.05}}) == OPEN


def stretch(period, first, last, chaotic=False):
    row = {
        "period": period, "from_crack": first, "to_crack": last, "strobes": 200,
        "from_tau": tau_at(first), "to_tau": tau_at(last),
    }  # fmt: skip
    return row if period else row | {"chaotic": chaotic}


def test_stretches_of_a_growing_crack():
    rows = [
        stretch(1, 5.1, 7.6), stretch(0, 7.6, 7.61), stretch(1, 7.61, 10.8),
        stretch(0, 10.8, 11.0, chaotic=True), stretch(2, 11.0, 12.0), stretch(0, 12.0, 12.1),
        stretch(3, 12.1, 13.0),
    ]  # fmt: skip
    history = {"stretches": rows}
    assert first_loss(history) == (10.8, "chaos")
    assert label_share(history, tau_at(11.5), tau_at(12.0), 2) == pytest.approx(1.0)
    chaos = label_share(history, tau_at(10.7), tau_at(12.0), "chaos")
    assert chaos == pytest.approx((tau_at(11.0) - tau_at(10.8)) / (tau_at(12.0) - tau_at(10.7)))
    assert [row["chaotic"] for row in separators(history, 10.7)] == [True, False]


def test_growing_and_fixed_cracks():
    row = {"crack": 10.0, "frozen": "period 1", "flow": "period 1", "fixed": ["period 1"],
           "from_rest": "period 1"}  # fmt: skip
    assert judged("F57", {"rows": [row]}) == HOLDS
    assert judged("F57", {"rows": [row, row | {"from_rest": "period 2"}]}) == DIFFERS
    assert judged("F57", {"rows": [row, row | {"frozen": BETWEEN}]}) == DIFFERS


def test_onset_and_scatter():
    """Chaos is born above 14 mm; noise of one part in a hundred scatters as much."""
    onset = onset_along_growth(0.1)
    assert onset["crack"] == pytest.approx(14.3, abs=0.11)
    assert onset["other_than_one"] == pytest.approx(10.7, abs=0.11)
    noise = 0.01 * np.random.default_rng(3).standard_normal(300)
    assert scatter(np.tile([0.5, -0.2, 0.1], 100) + noise) == pytest.approx(0.01, rel=0.1)


def test_monitoring_needs_a_place_a_detector_and_chaos_that_lasts():
    wrong = {"false": 0.04, "missed": 0.0, "low": 0.02, "high": 0.1}
    worse = wrong | {"missed": 0.1}
    alarms = [
        {"noise": 0.01, "healthy": 9, "chaotic": 9, "scatter": wrong, "zero_one": wrong,
         "amplitude": worse}
    ]  # fmt: skip
    evidence = {
        "onset": {"crack": 14.0}, "from_starts": {"crack": 14.0}, "share_of_time": 0.9,
        "aperiodic_behind": 0.8, "rows": [{"changed": {"eta": 1.1}, "followed": 14.1}],
        "alarms": alarms,
    }  # fmt: skip
    assert finding("F59", evidence)
    assert judged("F59", evidence) == OPEN
    for change in (
        {"aperiodic_behind": 0.1},
        {"rows": [{"changed": {"xi": 0.1}, "followed": None}]},
        {"alarms": [alarms[0] | {"scatter": wrong | {"false": 0.2}}]},
        {"alarms": [alarms[0] | {"scatter": wrong | {"missed": 0.06}, "amplitude": worse}]},
        {"alarms": [alarms[0] | {"amplitude": wrong}]},
        {"onset": {"crack": None}},
    ):
        assert not finding("F59", evidence | change)


def test_periods_of_strobes():
    assert period_of(np.tile([[0.0], [1.0], [0.5]], (40, 1))) == 3
    assert period_of(np.random.default_rng(0).random((200, 2))) == 0


@pytest.mark.slow
def test_verdicts():
    rows = {row["id"]: row for row in evaluate_claims(ids=QUICK_CRACK + SLOW_CRACK)}
    json.dumps(list(rows.values()), allow_nan=False)
    assert changes(expected_verdicts(rows), verdicts_of(rows.values())) == []


def test_a_test_has_one_colour_in_all_figures_of_crack_lengths():
    """Those of Table 3 in Figs. 18 to 20, by their mean load and amplitude."""
    colours: dict[str, set[str]] = {}
    for figure, _ in (fig18(), fig19(), fig20()):
        for line in figure.axes[0].lines:
            load, found, _ = str(line.get_label()).partition(" N: ")
            if found:
                colours.setdefault(load.partition(" ")[2], set()).add(line.get_color())
    assert len(colours) == 7 and all(len(used) == 1 for used in colours.values())
    assert len(set.union(*colours.values())) == 7
