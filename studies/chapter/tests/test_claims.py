"""The claims as data, and verdicts that follow from evidence and from nothing else."""

import json
from importlib import resources

import pytest
from chapter.test_basin_claims import SLOW
from chapter.test_fatigue_claims import SLOW_CRACK
from chapter.test_fatigue_rig_claims import SLOW_RIG
from chapter.test_orbit_claims import SLOW_ORBITS
from chapter.test_rotor_claims import SLOW_ROTOR
from chapter.test_sweep_claims import LONG

from nonsmooth import OptionError
from nonsmooth_chapter import claim_ids, evaluate_claims
from nonsmooth_chapter.claim_modules import CLAIM_MODULES
from nonsmooth_chapter.claims import _checks, _checks_in, _table
from nonsmooth_chapter.judgement import DIFFERS, HOLDS, OPEN, verdict

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
    check = _checks()[name]
    finding = check.judge(check.compute(**arguments))
    return verdict(finding, lacks_data=_table()[name]["dagger"])


def test_table_has_every_claim_once():
    """Names are stable and complete: G1-G3, M01-M57, F01-F59, R01-R57."""
    text = resources.files("nonsmooth_chapter").joinpath("claims.json").read_text("utf-8")
    names = [row["id"] for row in json.loads(text)["claims"]]
    expected = [
        f"{letter}{number:0{1 if letter == 'G' else 2}d}"
        for letter, count in COUNTS.items()
        for number in range(1, count + 1)
    ]
    assert names == expected
    assert names == claim_ids()


def test_rows_of_the_table_are_complete():
    """Missing data are named where the dagger stands, and only there."""
    for row in _table().values():
        assert list(row) == [
            "id", "section", "where", "claim", "parameters", "compute", "dagger", "missing",
        ]  # fmt: skip
        assert row["section"] in (1, 2, 3, 4)
        assert row["claim"] and row["where"] and row["compute"]
        assert bool(row["missing"]) == row["dagger"]


def test_every_claim_has_one_check():
    """All are judged, none twice, and each in the module that is said to judge it."""
    listed = [name for claims in CLAIM_MODULES.values() for name in claims.split()]
    assert sorted(listed) == sorted(claim_ids()) and len(listed) == len(set(listed))
    for module, claims in CLAIM_MODULES.items():
        assert [check.claim for check in _checks_in(module)] == claims.split(), module
    assert list(_checks()) == claim_ids()
    assert all(check.protocol for check in _checks().values())


def test_rows_have_the_same_keys(rows):
    """Every row can be printed, and written as JSON without infinities."""
    for name, row in rows.items():
        assert list(row) == KEYS
        assert row["id"] == name
        assert row["verdict"] in (HOLDS, DIFFERS, OPEN)
        assert row["computed"] and row["evidence"]
    json.dumps(list(rows.values()), allow_nan=False)


def test_missing_data_leave_a_claim_open(rows):
    """A row with a dagger says so, and names what is missing."""
    for name, row in rows.items():
        if _table()[name]["dagger"]:
            assert row["verdict"] == OPEN or "shown for" in row["protocol"]
            assert "does not give" in row["protocol"]


def test_verdicts_follow_from_the_evidence(rows):
    """Judging the same evidence again gives the same verdict: nothing else goes in."""
    for name, row in rows.items():
        finding = _checks()[name].judge(row["evidence"])
        assert verdict(finding, lacks_data=_table()[name]["dagger"]) == row["verdict"]


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
    assert verdict(_checks()[name].judge(evidence), lacks_data=False) == turned


def test_a_count_of_touches_that_sees_none_tells_nothing(rows):
    """The run that was made to touch is the control of the count."""
    evidence = rows["G2"]["evidence"]
    assert evidence["control"] == 1
    assert _checks()["G2"].judge(evidence | {"control": 0}).true is None


def test_smoothing_makes_motions_of_its_own():
    """Two widths of one kind, of the eight that are judged; without such motions it does not."""
    check = _checks()["G3"]
    evidence = check.compute(widths=(0.04, 0.02), kinds=("sqrt",))
    assert verdict(check.judge(evidence), lacks_data=False) == HOLDS
    none = [row | {"only_smoothed": []} for row in evidence["rows"]]
    assert verdict(check.judge(evidence | {"rows": none}), lacks_data=False) == DIFFERS


@pytest.mark.slow
def test_smoothing_by_all_widths():
    """As it is printed, from four widths of two kinds."""
    (row,) = evaluate_claims(ids=SLOW_SMOOTHING)
    assert list(row) == KEYS and row["verdict"] == HOLDS
    assert verdict(_checks()["G3"].judge(row["evidence"]), lacks_data=False) == HOLDS
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
