"""The claims as data, and verdicts that follow from evidence and from nothing else."""

import inspect
import json

import pytest

from nonsmooth import OptionError
from nonsmooth_chapter import claim_ids, evaluate_claims
from nonsmooth_chapter.claims import _check, _table
from nonsmooth_chapter.judgement import DIFFERS, HOLDS, OPEN, verdict
from nonsmooth_chapter.whole_chapter import LONGEST_FIRST
from test_basin_claims import SLOW
from test_fatigue_claims import SLOW_CRACK
from test_fatigue_rig_claims import SLOW_RIG
from test_orbit_claims import SLOW_ORBITS
from test_rotor_claims import SLOW_ROTOR
from test_sweep_claims import LONG
from verdicts import changes, expected_verdicts, verdicts_of

KEYS = ["id", "where", "printed", "computed", "protocol", "verdict", "evidence"]
SLOW_SMOOTHING = {"G3"}  # Taylor steps through narrow switches: as long as all others here
COUNTS = {"G": 3, "M": 57, "F": 59, "R": 57}


@pytest.fixture(scope="module")
def rows():
    """Verdicts that take seconds; those from diagrams have tests of their own."""
    long = {*LONG, *SLOW, *SLOW_ORBITS, *SLOW_CRACK, *SLOW_RIG, *SLOW_ROTOR, *SLOW_SMOOTHING}
    quick = [name for name in claim_ids() if name not in long]
    return {row["id"]: row for row in evaluate_claims(ids=quick)}


def judged(name, **arguments):
    """Verdict of a claim for other parameters than the chapter's."""
    check = _check(name)
    finding = check.judge(check.compute(**arguments))
    return verdict(finding, lacks_data=bool(_table()[name]["missing"]))


def test_table_has_every_claim_once():
    """Names are stable and complete: G1-G3, M01-M57, F01-F59, R01-R57."""
    names = list(_table())
    expected = [
        f"{letter}{number:0{1 if letter == 'G' else 2}d}"
        for letter, count in COUNTS.items()
        for number in range(1, count + 1)
    ]
    assert names == expected
    assert names == claim_ids()


def test_rows_of_the_table_are_complete():
    """Each says what is claimed and where, what is computed, by which rule, and who judges."""
    filled = {"where", "claim", "looks_at", "rule", "module", "evidence", "judge", "together"}
    for name, row in _table().items():
        assert set(row) == {*filled, "section", "parameters", "missing"}, name
        assert row["section"] in (1, 2, 3, 4)
        assert all(row[part] for part in filled), name


def test_every_claim_is_judged_by_functions_that_exist():
    """Evidence needs no argument beside those of the table, and its judge the evidence only."""
    for name in claim_ids():
        check = _check(name)
        assert check.claim == name and check.protocol
        inspect.signature(check.compute).bind()
        inspect.signature(check.judge).bind({})


def test_groups_of_the_table_are_known():
    """A group that is spelt in two ways would compute the same twice."""
    modules = {row["module"] for row in _table().values()}
    named = {row["together"] for row in _table().values()} - modules
    assert named <= set(LONGEST_FIRST)


@pytest.mark.slow
def test_rows_have_the_same_keys(rows):
    """Every row can be printed, and written as JSON without infinities."""
    for name, row in rows.items():
        assert list(row) == KEYS
        assert row["id"] == name
        assert row["verdict"] in (HOLDS, DIFFERS, OPEN)
        assert row["computed"] and row["evidence"]
    json.dumps(list(rows.values()), allow_nan=False)


def test_quick_verdicts_are_those_of_the_table(rows):
    """A verdict that turns over is noticed, by its name."""
    assert changes(expected_verdicts(rows), verdicts_of(rows.values())) == []


def test_table_of_verdicts_is_complete():
    """One for each claim, in their order, and nothing but a verdict."""
    assert list(expected_verdicts()) == claim_ids()
    assert set(expected_verdicts().values()) == {HOLDS, DIFFERS, OPEN}


def test_changes_of_verdicts_are_told():
    """By name, with what was there before."""
    before, after = {"M01": HOLDS, "M02": HOLDS}, {"M01": HOLDS, "M02": DIFFERS, "M03": OPEN}
    assert changes(before, after) == [
        "M02: holds, now differs",
        "M03: none, now not determinable",
    ]


def test_missing_data_leave_a_claim_open(rows):
    """A row with a dagger says so, and names what is missing."""
    for name, row in rows.items():
        if bool(_table()[name]["missing"]):
            assert row["verdict"] == OPEN or "shown for" in row["protocol"]
            assert "does not give" in row["protocol"]


def test_verdicts_follow_from_the_evidence(rows):
    """Judging the same evidence again gives the same verdict: nothing else goes in."""
    for name, row in rows.items():
        finding = _check(name).judge(row["evidence"])
        assert verdict(finding, lacks_data=bool(_table()[name]["missing"])) == row["verdict"]


@pytest.mark.parametrize(
    ("name", "arguments", "before", "after"),
    [
        ("M03", {"cam_frequency": 6.6}, DIFFERS, DIFFERS),  # then (a) is the one that fails
        ("M04", {"hertz_c": "9.0"}, HOLDS, DIFFERS),
        ("M16", {"forces": (0.05, 0.095)}, HOLDS, DIFFERS),
        ("M15", {"forces": (0.095,), "span": (100.0, 300.0)}, HOLDS, DIFFERS),
    ],
)
def test_parameters_move_a_verdict(rows, name, arguments, before, after):
    """Verdicts are decided by computed numbers: other data, another verdict."""
    assert rows[name]["verdict"] == before
    assert judged(name, **arguments) == after


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("G1", {"adaptive_difference": 1e-3}),
        ("G1", {"engine_switches": 0}),
        ("M07", {"differences": [1e-6]}),
        ("M08", {"deviations": [1e-6]}),
        ("M42", {"rows": [{"b": 0.1, "apart": 1e-6, "same_switches": True}]}),
        ("M42", {"rows": [{"b": 0.1, "apart": 0.0, "same_switches": False}]}),
        ("M44", {"rows": [{"b": 0.1, "force": [0.0, 1.1], "change": 0.0, "stretches": 1}]}),
        ("M44", {"rows": [{"b": 0.1, "force": [0.0, 0.9], "change": 1e-6, "stretches": 1}]}),
        ("G2", {"rows": [{"model": "m", "kinds": {"switch": 5}, "touches": 1}]}),
        ("M45", {"rows": [{"b": 0.0, "gain": 1.0, "printed_error": 0.0, "corrected_error": 0.0}]}),
        ("M46", {"none_pulling": 0, "other_mode": 0}),
    ],
)
def test_evidence_turns_a_verdict_over(rows, name, change):
    """Each predicate can come out either way."""
    evidence = rows[name]["evidence"] | change
    if name == "M08":
        evidence["largest_x"] = [1.0]
    turned = {HOLDS: DIFFERS, DIFFERS: HOLDS}[rows[name]["verdict"]]
    assert verdict(_check(name).judge(evidence), lacks_data=False) == turned


def test_a_count_of_touches_that_sees_none_tells_nothing(rows):
    """The run that was made to touch is the control of the count."""
    evidence = rows["G2"]["evidence"]
    assert evidence["control"] == 1
    assert _check("G2").judge(evidence | {"control": 0}).true is None


@pytest.mark.slow
def test_smoothing_makes_motions_of_its_own():
    """Two widths of one kind, of the eight that are judged; without such motions it does not."""
    check = _check("G3")
    evidence = check.compute(widths=(0.04, 0.02), kinds=("sqrt",))
    assert verdict(check.judge(evidence), lacks_data=False) == HOLDS
    none = [row | {"only_smoothed": []} for row in evidence["rows"]]
    assert verdict(check.judge(evidence | {"rows": none}), lacks_data=False) == DIFFERS


@pytest.mark.slow
def test_smoothing_by_all_widths():
    """As it is printed, from four widths of two kinds."""
    (row,) = evaluate_claims(ids=SLOW_SMOOTHING)
    assert list(row) == KEYS and row["verdict"] == HOLDS
    assert verdict(_check("G3").judge(row["evidence"]), lacks_data=False) == HOLDS
    json.dumps(row, allow_nan=False)


def test_second_test_of_the_cam_says_which_panel(rows):
    """Partly true is reported with the part that fails."""
    assert "15.5 Hz for (a) agrees" in rows["M03"]["computed"]
    assert "13.2 Hz for (c) does not agree" in rows["M03"]["computed"]


def test_selection():
    """By section, by name, and both."""
    assert claim_ids(1) == ["G1", "G2", "G3"]
    assert [row["id"] for row in evaluate_claims(ids=["M04", "M03"])] == ["M03", "M04"]
    assert evaluate_claims(1, ids=["M03"]) == []
    assert evaluate_claims(4, ids=["M03"]) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"section": 5}, "sections 1, 2, 3, 4"),
        ({"ids": ["M99"]}, "unknown claim 'M99'"),
        ({"section": 5, "ids": ["M03"]}, "sections 1, 2, 3, 4"),
    ],
)
def test_errors(arguments, message):
    """Unknown names list the known ones."""
    with pytest.raises(OptionError, match=message):
        evaluate_claims(**arguments)
