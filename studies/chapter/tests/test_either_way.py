"""Predicates of claims that no other test turns over: other evidence, another finding."""

import pytest

from nonsmooth_chapter.claims import _check, _table
from nonsmooth_chapter.fatigue import growth_claims
from nonsmooth_chapter.fatigue.crack_motions import tau_at
from nonsmooth_chapter.judgement import DIFFERS, HOLDS, OPEN, verdict


def judged(name, evidence):
    return verdict(_check(name).judge(evidence), lacks_data=bool(_table()[name]["missing"]))


def finding(name, evidence):
    return _check(name).judge(evidence).true


def window(start, **change):
    """One protocol of Fig. 8(e): period one, chaos behind it, less progression there."""
    row = {
        "start": start, "interval": [0.11, 0.1665], "next_label": 0, "before": 33.0, "after": 20.0,
        "best_above": 25.0, "best_b": 0.162, "best": 33.1,
    }  # fmt: skip
    return row | change


BRANCH = {
    "end": 0.167, "stable_before": True, "stable_behind": False, "at_end": 33.0, "best_b": 0.163,
    "best": 33.2,
}  # fmt: skip


@pytest.mark.parametrize(
    ("change", "branch", "expected"),
    [
        ({}, {}, HOLDS),
        ({"next_label": 2}, {}, DIFFERS),
        ({"after": 34.0}, {}, DIFFERS),
        ({"best_above": 33.5}, {}, DIFFERS),
        ({"best_b": 0.2}, {}, DIFFERS),
        ({}, {"end": 0.2}, DIFFERS),
        ({}, {"stable_behind": True}, DIFFERS),
    ],
)
def test_end_of_the_best_interval(change, branch, expected):
    rows = [window("restart", **change), window("follow up", **change)]
    evidence = {"rows": rows, "step": 0.0015, "branch": BRANCH | branch}
    assert judged("M17", evidence) == expected


def test_protocols_that_disagree_on_the_interval_decide_nothing():
    rows = [window("restart"), window("follow up", next_label=2)]
    assert judged("M17", {"rows": rows, "step": 0.0015, "branch": BRANCH}) == OPEN


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({}, HOLDS),
        ({"windows": 0}, DIFFERS),
        ({"periodic_share": 0.6}, DIFFERS),
        ({"widest": 0.05}, DIFFERS),
    ],
)
def test_narrow_windows_among_chaos(change, expected):
    row = {"a": 0.3, "below": 0.09, "windows": 4, "widest": 0.004, "main_width": 0.07,
           "periodic_share": 0.1}  # fmt: skip
    rows = [row, row | {"a": 0.9} | change]
    assert judged("M19", {"columns": 600, "rows": rows}) == expected


@pytest.mark.parametrize(("share", "expected"), [(0.3, HOLDS), (0.001, OPEN)])
def test_progression_that_falls(share, expected):
    row = {"a": 0.3, "reading": "first 50", "largest_fall": 9.0, "at": 0.2, "share": 0.3}
    assert judged("M28", {"rows": [row, row | {"share": share}]}) == expected
    assert judged("M28", {"rows": [row | {"share": 0.001}]}) == DIFFERS


@pytest.mark.parametrize(
    ("change", "true"),
    [
        ({}, True),
        ({"bounds_second_half": [-80.0, 1.0]}, False),
        ({"largest_fall_of_v": 1e-3}, False),
        ({"sum_error": 1e-3}, False),
    ],
)
def test_bounded_oscillation_and_drift(change, true):
    evidence = {
        "b": 0.15, "periods": 1000, "bounds_first_half": [-69.0, 1.0],
        "bounds_second_half": [-68.9, 1.0], "largest_fall_of_v": -0.1, "v_end": 3e4,
        "sum_error": 0.0,
    }  # fmt: skip
    assert finding("M43", evidence | change) is true
    assert judged("M43", evidence | change) == OPEN  # the parameters of Fig. 11 are not printed


def test_records_that_are_not_there_leave_the_tests_of_the_mole_open():
    """Other parameters give another history, but there is nothing to compare it with."""
    evidence = {
        "parameters": {}, "regime": {"period": 1}, "impacts_per_period": 1.0,
        "progression_per_period": 0.0178, "largest_p": 1.0, "least_p": -1.7, "word": "",
    }  # fmt: skip
    for name in ("M05", "M06"):
        assert judged(name, evidence) == OPEN
        told = _check(name).judge(evidence | {"impacts_per_period": 3.0}).computed
        assert "impacts per period 3" in told


def test_sides_that_part_or_lose_contact():
    row = {"f1": 3.0, "f2": 2.0, "phases": ["i"], "apart": 1e-15, "amplitude": 1.0}
    evidence = {"rows": [row], "periods": 100}
    assert judged("F22", evidence) == HOLDS
    assert judged("F22", {"rows": [row, row | {"apart": 1e-3}]}) == DIFFERS
    assert judged("F22", {"rows": [row, row | {"phases": ["i", "iii"]}]}) == DIFFERS


def stretch(period, first, last, chaotic=False):
    row = {"period": period, "from_crack": first, "to_crack": last, "strobes": 500,
           "from_tau": tau_at(first), "to_tau": tau_at(last)}  # fmt: skip
    return row if period else row | {"chaotic": chaotic}


AS_PRINTED = (
    stretch(1, 5.1, 10.8), stretch(0, 10.8, 10.9, chaotic=True), stretch(2, 10.9, 12.3),
    stretch(0, 12.3, 12.4, chaotic=True), stretch(3, 12.4, 13.5),
    stretch(0, 13.5, 13.7, chaotic=True), stretch(2, 13.7, 15.0),
    stretch(0, 15.0, 15.2, chaotic=True), stretch(2, 15.2, 17.0),
)  # fmt: skip
OTHERWISE = (
    stretch(1, 5.1, 9.0), stretch(2, 9.0, 12.3), stretch(1, 12.3, 13.0), stretch(3, 13.0, 17.0),
)  # fmt: skip


def growing(stretches):
    return {"grows": "frozen", "start": [0.0, 0.0], "first": 0.0, "stretches": list(stretches)}


def test_a_history_as_printed_is_found_and_another_is_not(monkeypatch):
    """Labels along the growth decide F49 and F51 to F56; all stay open for want of s and d."""
    names = ("F49", "F51", "F52", "F53", "F54", "F55", "F56")
    monkeypatch.setattr(growth_claims, "scanned_histories", lambda: (growing(OTHERWISE),))
    for stretches, expected in ((AS_PRINTED, [True] * 7), (OTHERWISE, [False] * 7)):
        monkeypatch.setattr(
            growth_claims, "convention_histories", lambda each=stretches: (growing(each),)
        )
        evidence = {name: _check(name).compute() for name in names}
        found = [finding(name, evidence[name]) for name in names]
        if stretches is OTHERWISE:
            expected[2] = True  # period two near 12 mm is there too
        assert found == expected
        assert {judged(name, evidence[name]) for name in names} == {OPEN}


def test_points_that_turn_back():
    run = {"grows": "frozen", "start": [0.0, 0.0], "first": 0.0, "true": True,
           "value": {"u": 0.0, "v": 0.4}}  # fmt: skip
    scan = {"cases": 9, "true": 3}
    assert finding("F50", {"runs": [run], "scan": scan})
    assert not finding("F50", {"runs": [run | {"true": False}], "scan": scan})


def test_table_of_forces():
    evidence = _check("R07").compute(count=50)
    assert judged("R07", evidence) == HOLDS
    evidence["rows"][2]["difference"] = 1e-3
    assert judged("R07", evidence) == DIFFERS


def test_contact_by_radius_is_right_for_a_centred_ring():
    """A few samples behind a contact, before the ring is back, tell both conditions apart."""
    evidence = _check("R11").compute(motions=(("A", 0.0, 3.0),), periods=4)
    assert judged("R11", evidence) == DIFFERS
    assert evidence["rows"][0]["eccentric"] < 1e-3
    assert judged("R11", {"rows": [evidence["rows"][0] | {"free_outside": 0}]}) == HOLDS


@pytest.mark.parametrize(("deviation", "expected"), [(1e-15, HOLDS), (1e-6, DIFFERS)])
def test_distance_that_is_kept(deviation, expected):
    row = {"set": "A", "delta": 0.1, "eta": 3.0, "samples": 9, "deviation": 0.0,
           "least_force": 0.01}  # fmt: skip
    assert judged("R12", {"rows": [row, row | {"deviation": deviation}]}) == expected
    assert judged("R12", {"rows": [row, row | {"least_force": -0.01}]}) == DIFFERS


@pytest.mark.parametrize(("ratio", "expected"), [(0.01, HOLDS), (0.05, OPEN), (0.3, DIFFERS)])
def test_work_of_the_dampers(ratio, expected):
    row = {"set": "A", "delta": 0.1, "eta": 3.0, "ratio": 0.001}
    assert judged("R14", {"periods": 24, "rows": [row, row | {"ratio": ratio}]}) == expected


def test_columns_that_still_move():
    row = {"delta": 0.0, "columns": 101, "periodic": 70, "unsettled": 0, "worst": 1e-9, "where": []}
    late = row | {"unsettled": 1, "worst": 0.1, "where": [2.2]}
    assert judged("R15", {"dropped": 300, "later": 2500, "rows": [row, row]}) == HOLDS
    assert judged("R15", {"dropped": 300, "later": 2500, "rows": [row, late]}) == DIFFERS


def panel(**change):
    row = {
        "panel": "d", "set": "A", "delta": 0.03, "eta": 3.0, "range": 1.0, "hits": 9,
        "hits_with_jump": 9, "at_zero": 9, "at_preload": 4, "crossings_of_preload": 4,
        "elsewhere": 0, "largest_at_zero": 0.1, "largest_at_preload": 0.01, "extreme": 0.2,
        "begun_anew": 0,
    }  # fmt: skip
    return row | change


def test_jumps_and_amplitudes_of_the_ring():
    assert judged("R35", {"rows": [panel()]}) == HOLDS
    assert judged("R35", {"rows": [panel(at_preload=3)]}) == DIFFERS
    assert judged("R35", {"rows": [panel(at_preload=0, crossings_of_preload=0)]}) == DIFFERS
    for name in ("R36", "R37"):
        assert judged(name, {"rows": [panel(), panel(extreme=0.1)]}) == HOLDS
        assert judged(name, {"rows": [panel(), panel(extreme=0.3)]}) == DIFFERS


def swept(start, **change):
    row = {"start": start, "chaotic_share": 0.6, "from": 15.0, "to": 26.0,
           "periods_between": [1, 2, 3], "step": 0.2}  # fmt: skip
    return row | change


def test_chaotic_range_of_the_rig():
    others = [swept("restart", chaotic_share=0.1), swept("follow down", chaotic_share=0.1)]
    assert judged("R38", {"rows": [*others, swept("follow up")]}) == HOLDS
    assert judged("R38", {"rows": [*others, swept("follow up", chaotic_share=0.4)]}) == DIFFERS
    assert judged("R38", {"rows": [*others, swept("follow up", periods_between=[1, 2])]}) == DIFFERS


def motion(**change):
    row = {
        "start": "follow up", "speed": 30.1, "regime": "chaotic", "period": 0, "exponent": 0.3,
        "error": 0.02, "motions": [{"period": 0, "share": 1.0, "chaotic": True}],
    }  # fmt: skip
    return row | change


def test_motions_of_the_rig():
    for name in ("R39", "R40", "R47"):
        assert judged(name, {"rows": [motion()]}) == HOLDS
        assert judged(name, {"rows": [motion(exponent=0.05)]}) == DIFFERS
        assert judged(name, {"rows": [motion(regime="periodic", period=2)]}) == DIFFERS
    assert judged("R46", {"rows": [motion(regime="periodic", period=2)]}) == HOLDS
    assert judged("R46", {"rows": [motion()]}) == DIFFERS


def ends(*kinds, first=14.74):
    return [
        {"period": 2**k, "speed": first + 0.5 * k, "kind": kind, "multiplier": [-1.0, 0.0]}
        for k, kind in enumerate(kinds)
    ]


def test_doublings_of_the_rig():
    cascade = ends("flip", "flip", "fold")
    assert judged("R42", {"ends": cascade, "sequence": [1, 2, 4, 0]}) == HOLDS
    assert judged("R42", {"ends": cascade[:1], "sequence": [1, 2, 0]}) == DIFFERS
    assert judged("R42", {"ends": cascade, "sequence": [1, 2, 4]}) == DIFFERS
    assert judged("R43", {"ends": cascade}) == HOLDS
    assert judged("R43", {"ends": ends("flip", first=15.2)}) == DIFFERS
    assert judged("R43", {"ends": ends("fold")}) == DIFFERS


def test_routes_by_eccentricity():
    """Doublings with one eccentricity, none with the other, whatever the preload."""
    flips, folds = ends("flip", "flip"), ends("fold")

    def rows(*each):
        return {"rows": [{"set": str(k), "ends": one} for k, one in enumerate(each)]}

    assert judged("R48", rows(folds, flips, folds, flips)) == HOLDS
    assert judged("R48", rows(folds, folds, flips, flips)) == DIFFERS
    # a search that failed does not make two routes unlike, nor alike
    lost = ends("flip", "not found")
    assert judged("R48", rows(flips, lost, folds, flips)) == OPEN
    assert judged("R48", rows(folds, lost, folds, flips)) == HOLDS


def test_crisis_and_what_is_left_above():
    beside = [{"start": "follow up", "speed": 26.3, "periods": [1]}]

    def found(to, *distances):
        meetings = [{"period": 1, "distance": each} for each in distances]
        return {"rows": [swept("follow up", to=to)], "motions": beside, "meetings": meetings}

    assert judged("R44", found(26.1, 0.5, 0.001)) == HOLDS
    assert judged("R44", found(26.1, 0.5)) == DIFFERS
    assert judged("R44", found(26.1)) == DIFFERS
    assert judged("R44", found(24.0, 0.001)) == DIFFERS
    assert judged("R44", found(None)) == DIFFERS


@pytest.mark.parametrize(
    ("motions", "kind", "expected"),
    [
        (["period 1"], "none", HOLDS),
        (["period 1", "no period"], "none", HOLDS),  # not settled
        (["period 1", "period 3"], "none", DIFFERS),
        (["chaos"], "none", DIFFERS),
        (["period 1"], "flip", DIFFERS),
        (["period 1"], "not found", OPEN),
    ],
)
def test_period_one_alone(motions, kind, expected):
    evidence = {
        "rows": [{"speed": 30.0, "motions": motions}], "starts": 13,
        "branch": {"kind": kind, "speed": 30.0},
    }  # fmt: skip
    assert judged("R45", evidence) == expected


def test_theoretical_half_of_the_orbits():
    """It can refute the claim, and cannot prove it without the measured orbits."""
    periodic = motion(regime="periodic", period=1)
    assert judged("R49", {"rows": [periodic, periodic]}) == OPEN
    assert judged("R49", {"rows": [periodic, motion()]}) == DIFFERS


def near_the_printed_torus(kind="none", largest=0.6, period=2):
    """Orbit of period two about 3.107, followed and column by column, and what starts find."""
    end = {"eta": 3.11, "kind": kind, "multiplier": [0.6, 0.0], "changes": []}
    return {
        "delta": 0.1, "eta": "3.107", "ends": [end, end], "found": True, "multipliers": [],
        "largest": 0.6, "near": [{"eta": 3.0, "largest": 0.6}, {"eta": 3.2, "largest": largest}],
        "motions": [{"period": period, "exponent": 0.0, "error": 0.01, "chaotic": False}],
    }  # fmt: skip


@pytest.mark.parametrize(
    ("evidence", "with_preload", "without"),
    [
        (near_the_printed_torus(), DIFFERS, HOLDS),
        (near_the_printed_torus(kind="torus"), HOLDS, DIFFERS),
        (near_the_printed_torus(period=0), HOLDS, DIFFERS),
        # an orbit that is unstable or not there beside the place is no sign of a torus at it
        (near_the_printed_torus(largest=1.2), DIFFERS, DIFFERS),
        (near_the_printed_torus(largest=None), DIFFERS, DIFFERS),
    ],
)
def test_torus_with_preload_and_none_without(evidence, with_preload, without):
    assert judged("R22", evidence) == with_preload
    assert judged("R23", evidence) == without
