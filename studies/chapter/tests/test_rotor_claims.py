"""Claims of section 4: predicates that can come out either way, all verdicts in the long checks."""

import json

import numpy as np
import pytest

from nonsmooth_chapter import claim_ids, evaluate_claims
from nonsmooth_chapter.claims import _check, _table
from nonsmooth_chapter.judgement import DIFFERS, HOLDS, OPEN, verdict
from nonsmooth_chapter.rotor.speed_sweeps import CHAOTIC, UNKNOWN, Sweep, _nearest
from verdicts import changes, expected_verdicts, verdicts_of

QUICK = ["R01", "R02", "R03", *(f"R{n:02d}" for n in (*range(5, 15), 29, *range(33, 38)))]
SLOW_ROTOR = [f"R{n:02d}" for n in range(1, 58) if f"R{n:02d}" not in QUICK]


def judged(name, evidence):
    return verdict(_check(name).judge(evidence), lacks_data=bool(_table()[name]["missing"]))


def computed(name, **arguments):
    return _check(name).compute(**arguments)


def test_every_claim_of_the_section_is_judged():
    assert {f"R{n:02d}" for n in range(1, 58)} <= set(claim_ids())


def test_damping_that_fits_both_times_would_hold():
    assert judged("R02", computed("R02")) == DIFFERS
    assert judged("R02", computed("R02", printed=(105.0, 105.0))) == HOLDS


def test_scaled_data_are_compared_digit_by_digit():
    evidence = computed("R03")
    assert judged("R03", evidence) == HOLDS
    evidence["computed"]["eta_m"] = 0.00291
    assert judged("R03", evidence) == DIFFERS


@pytest.mark.parametrize(
    ("difference", "period", "expected"),
    [(0.01, 1, HOLDS), (0.05, 1, OPEN), (0.2, 1, DIFFERS), (0.01, 2, DIFFERS)],
)
def test_heavy_ring(difference, period, expected):
    """Small by every measure, by some, by none; another period is never negligible."""
    orbit = {
        "stiffness": 50.0, "period": period, "massless_period": 1, "contacts": 2.0,
        "massless_contacts": 2.0, "difference": difference,
    }  # fmt: skip
    evidence = {"ratio": 1 / 17, "speed": 13.1, "ring_over_forcing": {"1": 20.0}, "orbits": [orbit]}
    assert judged("R04", evidence) == expected


def test_regimes_need_all_five():
    """Without preload there are I and V only."""
    assert judged("R05", computed("R05", preloads=((0.1, 0.1),), side=21)) == HOLDS
    evidence = computed("R05", preloads=((0.0, 0.0),), side=21)
    assert evidence["rows"][0]["present"] == ["I", "V"]
    assert judged("R05", evidence) == DIFFERS


def test_curves_and_tables():
    """Curves hold up to the corner; the tables as printed do not, as corrected they would."""
    evidence = computed("R06", points=20)
    assert all(row["valid"] == 1.0 for row in evidence["rows"])
    assert all(row["beyond"] == 0.0 for row in evidence["rows"] if row["beyond"] is not None)
    for name in ("R08", "R09"):
        evidence = computed(name)
        assert judged(name, evidence) == DIFFERS
        for row in evidence["rows"]:
            row |= {"printed": row["corrected"], "printed_without_root": 0}
        assert judged(name, evidence) == HOLDS


def test_gradient_of_the_corrected_energy_is_the_force():
    for row in computed("R08")["rows"]:
        assert row["corrected_gradient"] < 1e-8
    assert max(row["printed_gradient"] for row in computed("R08")["rows"]) > 0.01


def test_release_as_printed_loses_signs():
    """arccos keeps the upper half plane, arctan the right one: half of all pairs go wrong."""
    evidence = computed("R10", count=20_000)
    assert evidence["share"] == pytest.approx(0.5, abs=0.02)
    assert judged("R10", evidence | {"share": 0.0}) == HOLDS


def test_free_ring_beyond_its_preload():
    """At s = 2 Delta one spring pulls with Delta + s = 3 Delta: 1.5 times the printed rate."""
    evidence = computed("R13")
    ratios = [row["rate_of_springs"] / row["rate_printed"] for row in evidence["rows"]]
    assert ratios == pytest.approx([1.0, 1.0, 1.5], rel=1e-12)
    assert judged("R13", evidence | {"rows": evidence["rows"][:2]}) == HOLDS


def change(last, becomes, printed="2.165", after=None, width=2e-4):
    row = {"start": "restart", "last": last, "first": last + width, "becomes": becomes,
           "others": []}  # fmt: skip
    branch = {"period": 1, "kind": "flip", "eta": 2.2, "multiplier": [-1.0, 0.0]}
    return {
        "printed": printed, "before": 1, "after": after, "by_protocol": [row], "branch": branch,
    }  # fmt: skip


def test_place_and_period_decide():
    assert judged("R16", change(2.1645, 3)) == HOLDS
    assert judged("R16", change(2.16, 3)) == DIFFERS
    assert judged("R18", change(3.803, 4, "3.803", 4)) == HOLDS
    assert judged("R18", change(3.803, 5, "3.803", 4)) == DIFFERS


def test_orbit_decides_where_columns_are_wide_apart():
    """It flips at 2.2: between the columns it decides, outside of them nothing does."""
    assert judged("R16", change(2.199, 3, "2.200", width=0.0015)) == HOLDS
    assert judged("R16", change(2.199, 3, "2.203", width=0.0015)) == DIFFERS
    assert judged("R16", change(2.164, 3, width=0.0015)) == OPEN


def shift(change, kinds, value=0.03):
    return {"change": change, "route": "orbit", "shift": value, "kinds": kinds}


def test_shifts_compare_like_with_like():
    names = ("end of period one", "four to two", "end of period two")
    rows = [shift(name, ["flip", "flip"]) for name in names]
    assert judged("R24", {"rows": rows}) == HOLDS
    assert judged("R24", {"rows": [*rows, shift(names[0], ["flip", "flip"], -0.1)]}) == DIFFERS
    assert judged("R24", {"rows": [*rows, shift(names[0], ["flip", "fold"], -0.1)]}) == HOLDS
    assert judged("R24", {"rows": [*rows[:2], shift(names[2], ["flip", "fold"])]}) == OPEN


def beyond(*found):
    rows = [
        {"eta": 2.211 + 0.001 * k, "regime": regime, "period": n, "message": ""}
        for k, (regime, n) in enumerate(found)
    ]
    branch = {"period": 1, "kind": "flip", "eta": 2.2, "multiplier": [-1.0, 0.0]}
    return {"delta": 0.1, "end": 2.21, "rows": rows, "branch": branch, "again": []}


def test_what_period_one_goes_to():
    three, torus = ("periodic", 3), ("quasi-periodic", 0)
    assert judged("R25", beyond(three, three)) == HOLDS
    assert judged("R25", beyond(three, ("periodic", 1))) == DIFFERS
    assert judged("R26", beyond(torus, torus)) == HOLDS
    assert judged("R26", beyond(torus, ("chaotic", 0))) == DIFFERS


def test_nearest_change_of_labels():
    """Columns that have not settled may lie between, other periods not."""
    labels = np.array([4, 4, UNKNOWN, 2, 4, 3, 2, 4, 2])
    sweep = Sweep("restart", np.arange(9.0), labels, None, None)
    assert _nearest(sweep, 4, 2, 0.0) == (1, 3)
    assert _nearest(sweep, 4, 2, 9.0) == (7, 8)
    assert _nearest(sweep, 4, None, 4.4) == (4, 5)
    assert _nearest(sweep, 5, None, 4.4) is None


def test_printed_numbers_of_the_sections():
    evidence = computed("R29")
    assert judged("R29", evidence) == DIFFERS
    first, second = evidence["rows"]
    exchanged = [first | {"section": "2.181"}, second | {"section": "2.223"}]
    assert judged("R29", {"rows": exchanged}) == HOLDS


def test_jumps_of_the_ring():
    evidence = computed("R34")
    assert judged("R34", evidence) == HOLDS
    evidence["rows"][0]["at_preload"] -= 1
    assert judged("R34", evidence) == DIFFERS
    evidence = computed("R33")
    evidence["rows"][1]["hits_with_jump"] = 0
    assert judged("R33", evidence) == DIFFERS


def scan(labels, contacts=1.0):
    """Force and amplitude that grow with speed, small above the last chaos."""
    last = max(k for k, label in enumerate(labels) if label == CHAOTIC)
    return [
        {
            "speed": 7.0 + k, "label": label, "contacts": contacts,
            "force": float(k), "amplitude": 0.1 + 0.01 * k if k <= last else 0.05,
        }
        for k, label in enumerate(labels)
    ]  # fmt: skip


def test_contacts_forces_and_amplitudes():
    labels = [1, 1, 2, CHAOTIC, CHAOTIC, CHAOTIC, 1, 1, 1, 1]
    evidence = {"rows": {"40": scan(labels), "41": scan(labels)}}
    assert [judged(f"R{n}", evidence) for n in range(50, 54)] == [HOLDS] * 4
    worse = {"rows": {"40": scan(labels), "41": scan(labels, contacts=2.0)}}
    assert judged("R50", worse) == DIFFERS
    for row in worse["rows"]["41"]:
        row |= {"force": 1.0 - row["force"], "amplitude": 1.0}
    assert [judged(f"R{n}", worse) for n in (51, 53)] == [DIFFERS] * 2
    short = {"rows": {"40": scan(labels[:-3]), "41": scan(labels)}}
    assert judged("R52", short) == DIFFERS


def test_preload_and_chaos():
    shares = [{"restart": 0.2, "follow up": 0.3}, {"restart": 0.3, "follow up": 0.2}]
    assert judged("R54", {"shares": shares, "columns": 1001}) == HOLDS
    assert judged("R54", {"shares": shares[::-1], "columns": 1001}) == DIFFERS
    assert judged("R54", {"shares": shares, "columns": 101}) == DIFFERS  # within the sampling
    rows = [
        {"set": name, "delta": delta, "share": 0.2 + delta} for name in "AB" for delta in (0.0, 0.1)
    ]
    assert judged("R55", {"rows": rows, "columns": 101}) == DIFFERS
    rows[-1]["share"] = 0.15
    assert judged("R55", {"rows": rows, "columns": 101}) == DIFFERS  # within the sampling
    rows[-1]["share"] = 0.02
    assert judged("R55", {"rows": rows, "columns": 101}) == HOLDS


def test_missing_measurements_leave_claims_open():
    for name in ("R41", "R49", "R56", "R57"):
        assert bool(_table()[name]["missing"])


@pytest.mark.slow
def test_verdicts():
    rows = {row["id"]: row for row in evaluate_claims(section=4)}
    assert set(rows) == {f"R{n:02d}" for n in range(1, 58)}
    json.dumps(list(rows.values()), allow_nan=False)
    assert changes(expected_verdicts(rows), verdicts_of(rows.values())) == []
