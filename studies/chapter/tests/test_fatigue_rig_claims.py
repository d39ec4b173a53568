"""Claims on the rig, its tests and lives: predicates that can come out either way, closed forms."""

import itertools
import json

import numpy as np
import pytest

from nonsmooth.excitation import Excitation
from nonsmooth.fatigue import Specimen
from nonsmooth_chapter import claim_ids, evaluate_claims
from nonsmooth_chapter.claims import _check, _table
from nonsmooth_chapter.fatigue.life_claims import ORDERS
from nonsmooth_chapter.fatigue.life_figures import fig18, fig19
from nonsmooth_chapter.fatigue.record_claims import passages
from nonsmooth_chapter.fatigue.records import chaotic, harmonic, loaded_rig
from nonsmooth_chapter.fatigue.rig import SET_25, rig_system, start_up, stays
from nonsmooth_chapter.fatigue.rig_claims import rig_of_fig_25
from nonsmooth_chapter.fatigue.rig_figures import fig24, fig25
from nonsmooth_chapter.judgement import DIFFERS, HOLDS, OPEN, verdict
from verdicts import changes, expected_verdicts, verdicts_of

ALL = [f"F{n:02d}" for n in range(1, 33)]
SLOW_RIG = ["F13", "F14", "F16", "F17", "F18", "F19"]  # waves and many runs
QUICK_RIG = [name for name in ALL if name not in SLOW_RIG]


def judged(name, evidence):
    return verdict(_check(name).judge(evidence), lacks_data=bool(_table()[name]["missing"]))


def finding(name, evidence):
    return _check(name).judge(evidence).true


def computed(name, **arguments):
    return _check(name).compute(**arguments)


def test_every_claim_on_rig_and_lives_is_judged():
    assert set(ALL) <= set(claim_ids())


@pytest.mark.slow
def test_quick_verdicts():
    rows = evaluate_claims(ids=QUICK_RIG)
    json.dumps(rows, allow_nan=False)
    assert changes(expected_verdicts(QUICK_RIG), verdicts_of(rows)) == []


def test_composition_and_load_ratios():
    evidence = computed("F01")
    assert evidence["sum"] == 100.0 and len(evidence["elements"]) == 9
    assert judged("F01", evidence | {"sum": 99.99}) == DIFFERS
    evidence = computed("F02")
    evidence["rows"][7]["computed"] = 0.35
    assert judged("F02", evidence) == DIFFERS


def test_crack_free_compliance_by_hand():
    """L^3/(48 E I) with I = B W^3/12."""
    evidence = computed("F03")
    value = 270.0**3 / (48 * 72.4e3 * 10 * 20**3 / 12)
    assert evidence["by_moments"] == pytest.approx(value, rel=1e-12)
    assert judged("F03", evidence | {"added_at_zero": 1e-9}) == DIFFERS
    assert judged("F03", evidence | {"by_formula": 1.001 * value}) == DIFFERS


def test_formulas_that_part_differ():
    evidence = computed("F04")
    assert judged("F04", evidence | {"span_ratio": 2.0}) == DIFFERS
    evidence["rows"][0]["worst"] = -0.03
    assert judged("F04", evidence) == DIFFERS


def test_sensor_holds_for_every_gain():
    evidence = computed("F05", points=5)
    assert judged("F05", evidence) == HOLDS
    assert judged("F05", evidence | {"worst": 1e-3}) == DIFFERS


@pytest.mark.parametrize("name", list(ORDERS))
def test_orders_of_lives_can_be_wrong(name):
    assert judged(name, computed(name)) == HOLDS
    assert judged(name, computed(name, names=ORDERS[name][::-1])) == DIFFERS


def test_pairs_of_tests_decide_on_the_maximum():
    evidence = computed("F11")
    assert judged("F11", evidence) == HOLDS
    assert evidence["joint"] == {"told": 16, "wrong": 0}
    assert judged("F11", evidence | {"joint": {"told": 16, "wrong": 1}}) == DIFFERS
    evidence["rows"][0]["wrong"] = 0
    assert judged("F11", evidence) == DIFFERS


def test_orders_follow_from_loads_that_rise():
    """The proof for all constants; Walker's law with gamma = 1 is that of Paris, outside of it."""
    evidence = computed("F12", far=((3.0, 0.5),))
    assert judged("F12", evidence) == HOLDS
    falling = [row | {"range": row["range"][::-1]} for row in evidence["loads"]]
    assert judged("F12", evidence | {"loads": falling}) == OPEN
    evidence = computed("F12", far=((3.0, 1.0),))
    assert {row["claim"] for row in evidence["broken"]} == {"F06"}
    assert judged("F12", evidence) == OPEN  # false, but not for every value of what is missing


def test_printed_ratios_of_lives():
    row = {"rig": "r", "law": "l", "least": 1, "median": 2, "most": 9, "cases": 4, "near": 1}
    evidence = {"stated": 4.05, "printed": "4", "rows": [row], "most_at_equal_load": 3.0}
    assert finding("F13", evidence) and judged("F13", evidence) == OPEN
    assert not finding("F13", evidence | {"stated": 5.2})
    assert judged("F15", computed("F15", printed=(4.0, 6.0))) == HOLDS


def test_bending_frequency_by_hand():
    value = np.pi / 2 / 0.27**2 * np.sqrt(72.4e9 * 0.02**2 / 12 / 2780)
    assert computed("F20")["frequency"] == pytest.approx(value, rel=1e-12)
    assert judged("F20", computed("F20", frequency=100.0)) == DIFFERS


def test_contacts_are_stiffer_by_less_than_ten_times():
    assert computed("F21")["ratio"] == pytest.approx(1 / (0.002012 * 7.828**2), rel=1e-12)
    for ratio, expected in ((20.0, HOLDS), (8.0, DIFFERS)):
        assert judged("F21", {"ratio": ratio, "shared": 0.1}) == expected


def test_phases_of_the_model_can_be_told_from_the_printed_ones():
    evidence = computed("F23", periods=4)
    assert judged("F23", evidence) == HOLDS
    evidence["rows"][0]["rates_apart"] = 1e-3
    assert judged("F23", evidence) == DIFFERS


def test_order_of_phases():
    rows = [
        (name, float(k), k + 1.0) for k, name in enumerate(["iv", "iii", "iv", "ii", "iv", "iii"])
    ]
    assert passages(rows) == []
    evidence = computed("F25")
    assert evidence["steady_passages"] == 0
    assert judged("F25", evidence) == HOLDS
    told = evidence["rows"][1]
    for change in ({"before": ""}, {"mass_1": 0.4}, {"durations": [0.5, 0.3, 0.6, 0.4]}):
        assert judged("F25", evidence | {"rows": [told | change]}) == DIFFERS
    evidence["rows"] = evidence["rows"][:1]  # the start itself, before which nothing was hit
    assert judged("F25", evidence) == DIFFERS
    evidence = computed("F24", starts=2)
    assert judged("F24", evidence | {"start_up": evidence["steady"]}) == DIFFERS


def test_stays_cover_the_run_without_gaps():
    run = start_up(rig_system())
    rows = stays(run)
    assert rows[0][1] == 0.0 and rows[-1][2] == pytest.approx(float(run["time"][-1]))
    assert all(a[2] == b[1] and a[0] != b[0] for a, b in itertools.pairwise(rows))


def test_rest_and_followers():
    evidence = computed("F26")
    assert evidence["relaxation"] == pytest.approx(2 * 0.002 / 7.828, rel=1e-12)
    assert judged("F26", evidence | {"relaxation": 0.1}) == DIFFERS
    evidence = computed("F27")
    evidence["rows"][0]["near"] = 0.5
    assert judged("F27", evidence) == DIFFERS


def test_data_of_the_rig_by_hand():
    """k_Ls = k_s/theta^2, omega_Ls = Omega/eta, P = f k_Ls A_b minus and plus the weight."""
    leaf = 1e3 * Specimen().closed_stiffness / 7.828**2
    mass = leaf / (2 * np.pi * 19.15 / 2.5) ** 2
    evidence = computed("F29")
    assert evidence["mass"] == pytest.approx(mass, rel=1e-12)
    assert evidence["P1"] == pytest.approx(5.44 * leaf * 2.8e-3 - mass * 9.80665, rel=1e-12)
    assert evidence["P2"] == pytest.approx(3.52 * leaf * 2.8e-3 + mass * 9.80665, rel=1e-12)
    assert judged("F29", evidence | {"P1": -1.0}) == DIFFERS
    assert judged("F29", evidence | {"stress": 400.0}) == DIFFERS


def test_preloads_and_reduction_can_fail():
    evidence = computed("F30")
    evidence["rows"][0]["lost"]["above"] = ["iii"]
    assert judged("F30", evidence) == DIFFERS
    evidence = computed("F32", ladder=(0.002012, 0.0002012), periods=30)
    assert evidence["simulated"]["chapter"] == pytest.approx(evidence["errors"]["chapter"][0], 0.05)
    stays_wrong = {name: [each[0], each[0]] for name, each in evidence["errors"].items()}
    assert judged("F32", evidence | {"errors": stays_wrong}) == DIFFERS
    evidence = computed("F31", periods=1.0)
    assert judged("F31", evidence | {"coupling": 0.1}) == DIFFERS


def test_mean_load_of_a_test_and_its_amplitude():
    """At rest the load is the mean; at 6.4 mm its amplitude is what the base was set for."""
    rig = loaded_rig("Fig. 24", 9.0, 100.0)
    assert float(rig.to_si(start_up(rig.system(), 1))["load"][0]) == pytest.approx(100.0, rel=1e-9)
    load = harmonic("Fig. 25", 6.4, 100.0)["load"].values
    assert 0.5 * np.ptp(load) == pytest.approx(100.0, rel=1e-3)


def test_a_harmonic_record_shakes_as_the_sine_does():
    """The rig on a record against its own forcing, both from rest."""
    rig = loaded_rig("Fig. 25", 8.0, 0.0)
    omega = 2 * np.pi * 20.0
    times = np.arange(2001) / 4000.0
    base = -1e-3 * rig.base_amplitude * omega**2 * np.sin(omega * times)
    run = chaotic("Fig. 25", 8.0, 0.0, Excitation(times, base), 0.0)
    true = rig.to_si(start_up(rig.system(), 10, 200))
    assert np.allclose(run["X3"].values, true["X3"].values, atol=1e-6)
    assert run.attrs["phases"] == "i"


def test_figures_of_lives_end_where_table_3_does():
    for figure, data in (fig18(), fig19()):
        at_end = data["time_49"].isel(crack=-1).values
        assert at_end == pytest.approx(data["life"].values, rel=1e-9)
        assert np.all(data["time"].isel(crack=0).values == 0.0)
        assert any("not available" in str(text.get_text()) for text in figure.texts)


def test_figures_of_histories():
    _, data = fig24()
    assert "i" not in data.attrs["steady_phases"].split()
    _, data = fig25()
    peak = 2.8e-3 * (2 * np.pi * 19.15) ** 2
    assert float(np.abs(data["base"]).max()) == pytest.approx(peak, rel=1e-5)
    assert rig_of_fig_25().parameters()["f2"] == pytest.approx(SET_25["f2"], rel=1e-12)


@pytest.mark.slow
def test_verdicts():
    rows = evaluate_claims(ids=ALL)
    json.dumps(rows, allow_nan=False)
    assert changes(expected_verdicts(ALL), verdicts_of(rows)) == []
