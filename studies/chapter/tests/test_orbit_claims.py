"""Claims from orbits and branches: predicates both ways, and all of them in the long checks."""

import json

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.models import moling
from nonsmooth_chapter import evaluate_claims
from nonsmooth_chapter.claims import _check, _table
from nonsmooth_chapter.judgement import DIFFERS, HOLDS, OPEN, verdict
from nonsmooth_chapter.mole.orbits import (
    FOUR_PHASES,
    best_stable,
    first_sheet,
    four_phase_branch,
    near_observed,
    observed,
    turn_word,
)
from nonsmooth_chapter.mole.sweep_claims import cascade
from verdicts import changes, expected_verdicts, verdicts_of

SLOW_ORBITS = ["M14", *(f"M{n}" for n in range(30, 42)), "M56"]


def judged(name, evidence):
    return verdict(_check(name).judge(evidence), lacks_data=bool(_table()[name]["missing"]))


def test_turns_begin_with_progression_wherever_they_are_cut():
    """The same orbit, cut in progression, in contact or in flight, has one word."""
    words = {
        turn_word(ns.find_orbit(moling(), phase=phase)) for phase in (0.0, 0.06, 0.1, 0.5, 0.97)
    }
    assert words == {FOUR_PHASES}


def test_branch_of_fig10_agrees_with_motions():
    """Where the branch is solid, motions near it settle to its progression."""
    branch = four_phase_branch("b", (0.02, 0.6), a=0.5)
    places = np.flatnonzero(observed(branch))
    assert places.size > 10
    for k in places[[3, places.size // 2]]:
        orbit = branch.isel(point=int(k))
        system = moling(a=0.5, b=float(orbit["b"]), xi=0.01)
        run = ns.simulate(system, periods=300, samples_per_period=1)
        gain = np.diff(run["v"].values)[-1]
        assert gain == pytest.approx(float(orbit["v_per_period"]), rel=1e-6)


def test_parts_of_a_branch():
    branch = four_phase_branch("b", (0.02, 0.2), xi=0.05)
    part = near_observed(branch)
    assert set(part["special_kind"].values) <= {"fold", "flip"}
    assert observed(part).sum() == observed(branch).sum()
    for k, kind in zip(part["special_point"].values, part["special_kind"].values, strict=True):
        if kind == "fold":  # numbers of points count from the new beginning
            assert abs(part["b"].values[k] - branch["b"].values).min() == 0.0
    sheet = first_sheet(branch)
    assert np.all(np.diff(sheet["b"]) > 0.0)
    assert sheet["b"].values[-1] == pytest.approx(branch["b"].values.max())
    best = best_stable(branch)
    assert observed(branch)[best]
    assert best_stable(branch.isel(point=~observed(branch))) == -1


@pytest.mark.slow
def test_cascade_is_supercritical():
    """Doubled orbits are stable below each flip; the coefficient comes from motions alone."""
    evidence = _check("M14").compute()
    assert judged("M14", evidence) == DIFFERS
    for row in evidence["rows"]:
        assert row["slope"] == pytest.approx(-1.0, abs=1e-3)
        assert row["coefficient"] > 0.0
        assert row["doubled_stable"] == row["doubled_below"] == row["doubled_points"] > 0
        assert row["single_stable"] == {"below": False, "above": True}
    for row in evidence["rows"]:
        row.update(doubled_stable=0, coefficient=-1.0)
    assert judged("M14", evidence) == HOLDS
    first, second, third = cascade()
    assert [each.attrs["period"] for each in (first, second, third)] == [1, 2, 4]


def test_amplitude_of_the_doubled_orbit_grows_as_a_root():
    """At a supercritical flip the square of the distance of its two halves is linear in b."""
    double = cascade()[1]
    flip = 0.110011731
    b = flip - np.array([4e-4, 1e-4])
    apart = []
    for value in b:
        run = ns.simulate(
            moling(b=value), double.isel(point=int(np.abs(double["b"].values - value).argmin())),
            periods=4000, samples_per_period=1, events=False, parameters={},
        )  # fmt: skip
        apart.append(abs(float(run["y"][-1] - run["y"][-2])))
    assert apart[0] / apart[1] == pytest.approx(2.0, rel=0.05)


def test_start_of_progression_at_an_impact_fails():
    quick = {"sets": {"7(d)": ({"a": 0.3, "b": 0.15, "xi": 0.05, "omega": 0.1},)}, "starts": ({},)}
    check = _check("M32")
    direct = check.compute(**quick)
    assert judged("M32", direct) == DIFFERS
    assert judged("M32", check.compute(**quick, fast=())) == HOLDS
    assert any(row["entered"] == "impact>progression" for row in direct["rows"])


def test_words_decide():
    def rows(*words):
        return {"starts": 1, "rows": [{"figure": "9", "sets": 1, "words": each} for each in words]}

    assert judged("M30", rows({FOUR_PHASES: 1}, {FOUR_PHASES: 2, "contact": 5})) == HOLDS
    assert judged("M30", rows({FOUR_PHASES: 1}, {"contact": 5})) == DIFFERS


def test_minima_as_printed_decide():
    def row(**change):
        known = {
            "a": 0.3, "b": 0.1, "least": 0.0, "closes": True, "closes_as_motion": True,
            "orbits": 1, "stable": True, "from_rest": 1,
        }  # fmt: skip
        return known | change

    none = row(closes=False, closes_as_motion=False, orbits=0, stable=False)
    assert judged("M33", {"rows": [row(), none]}) == HOLDS
    assert judged("M33", {"rows": [row(), row(stable=False)]}) == OPEN
    assert judged("M33", {"rows": [row(orbits=0, stable=False)]}) == DIFFERS
    # what the printed F lacks, a force held below the friction limit, decides nothing
    assert judged("M33", {"rows": [row(closes_as_motion=False)]}) == HOLDS


@pytest.mark.slow
def test_minimum_beyond_the_window_is_no_motion():
    evidence = _check("M33").compute(sets=((0.3, 0.175),))
    (row,) = evidence["rows"]
    assert not row["closes_as_motion"] and not row["orbits"] and row["from_rest"] != 1


def slope(value, rising, reading="stable"):
    return {
        "value": value, "reading": reading, "steps": 5, "rising": rising, "from": 0.1, "to": 1,
        "slopes": [-1.0, 1.0],
    }  # fmt: skip


@pytest.mark.parametrize(
    ("name", "shares", "expected"),
    [
        ("M35", [0.0, 0.0], HOLDS),
        ("M35", [0.0, 0.1], OPEN),  # it depends on what the chapter does not print
        ("M35", [1.0, 0.5], DIFFERS),
        ("M37", [1.0, 1.0], HOLDS),
        ("M37", [0.9, 0.0], DIFFERS),
    ],
)
def test_slopes_decide(name, shares, expected):
    rows = [slope(0.3 + 0.1 * k, share) for k, share in enumerate(shares)]
    assert judged(name, {"over": "omega", "curve": "a", "rows": rows}) == expected


@pytest.mark.parametrize(
    ("gains", "expected"), [([1.0, 2.0], HOLDS), ([1.0, -1.0], OPEN), ([-1.0, -2.0], DIFFERS)]
)
def test_order_of_curves_decides(gains, expected):
    rows = [
        {
            "reading": "stable", "low": 0.1, "high": 0.2, "common": 3, "least_gain": gain,
            "range": [0.1, 0.2],
        }
        for gain in gains
    ]  # fmt: skip
    for name in ("M36", "M38"):
        assert judged(name, {"over": "a", "curve": "b", "values": [1, 2], "rows": rows}) == expected


def test_maximum_and_breakdown_decide():
    row = {"a": 0.3, "at": 0.16, "per_period": 3.0, "inner_maxima": [0.16], "end": 0.17,
           "ends_in": "fold", "at_end": 2.9}  # fmt: skip
    assert judged("M39", {"rows": [row]}) == judged("M40", {"rows": [row]}) == HOLDS
    far = row | {"a": 0.5, "at": 0.1}
    assert judged("M40", {"rows": [row, far]}) == OPEN
    assert judged("M40", {"rows": [far]}) == DIFFERS
    assert judged("M40", {"rows": [row | {"ends_in": "bound"}]}) == DIFFERS
    assert judged("M39", {"rows": [row | {"inner_maxima": []}]}) == DIFFERS


def test_ratio_decides():
    row = {"xi": 0.01, "a": 0.3, "ratio": 1.9, "per_period": 1.0, "swept_ratio": 2.1,
           "swept": 1.0, "swept_period": 1}  # fmt: skip
    assert judged("M56", {"rows": [row]}) == HOLDS
    assert judged("M56", {"rows": [row | {"ratio": 1.7}]}) == OPEN
    assert judged("M56", {"rows": [row | {"ratio": 1.7, "swept_ratio": 1.0}]}) == DIFFERS


@pytest.mark.slow
def test_full_rows():
    """All rows, as they are printed; verdicts follow from the evidence alone."""
    rows = evaluate_claims(ids=SLOW_ORBITS)
    assert changes(expected_verdicts(SLOW_ORBITS), verdicts_of(rows)) == []
    for each in rows:
        assert judged(each["id"], each["evidence"]) == each["verdict"]
    json.dumps(rows, allow_nan=False)
