"""Impacts per period of the mole beside an independent integration by scipy."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth_chapter.mole.independent import adaptive_mole_run

MOLE = {"xi": 0.05, "omega": 0.1, "g": 0.02, "phi": np.pi / 2}


def truth(a, b, settle, period):
    """Impacts, events and drift per period of scipy's mole, and how far its period is closed."""
    window = 2.0 * np.pi / MOLE["omega"]
    run = adaptive_mole_run({"a": a, "b": b, **MOLE}, np.arange(settle + period + 1) * window)
    before = np.array(["no_contact", *run.switch_modes[:-1]])
    late = np.array(run.switch_times) > settle * window
    change = run.states[-1] - run.states[-1 - period]
    hits = np.count_nonzero(late & (before == "no_contact"))
    return hits / period, late.sum() / period, change[3] / period, np.abs(change[:3]).max()


@pytest.mark.few(1)
@pytest.mark.parametrize(("b", "impacts"), [(0.15, 1), (0.187, 2), (0.203, 3)])
def test_the_mole_hits_without_a_reset(b, impacts):
    hits, events, drift, _ = truth(0.3, b, 20, 1)
    assert hits == impacts
    mole = ns.models.moling(b=b)
    found = ns.regime(mole)
    column = ns.bifurcation_diagram(mole, "b", [b], transient=100, record=10).squeeze()
    for each in (found, column):
        assert each["impacts"].item() == hits
        assert each["events"].item() == events
        # scipy's tolerance is 1e-12 of v, some hundreds, at each of 5000 steps
        assert each["v_per_period"].item() == pytest.approx(drift, abs=1e-6)
    spectrum = ns.lyapunov_spectrum(mole, transient=20, record=10)
    assert spectrum.attrs["n_impacts"] == 10 * hits
    assert spectrum.attrs["n_events"] == 10 * events


@pytest.mark.slow
def test_means_are_those_of_whole_periods():
    """128 periods hold the period of 6 no whole number of times."""
    hits, events, drift, closed = truth(0.1, 0.042, 40, 6)
    column = ns.bifurcation_diagram(
        ns.models.moling(a=0.1), "b", [0.042], transient=400, record=128
    ).squeeze()
    assert column["period"] == 6
    assert column["impacts"].item() == hits
    assert column["events"].item() == events
    # what is left open over a period bounds what the drift over it may be off
    assert closed < 1e-3
    assert column["v_per_period"].item() == pytest.approx(drift, abs=closed)
    assert column["v_per_time"].item() == pytest.approx(drift * 0.1 / (2 * np.pi), abs=closed)


@pytest.mark.slow
def test_means_over_iterates_are_those_of_whole_periods():
    """Two impacts per period are two iterates; 7 of them are no whole number of periods."""
    _, events, drift, _ = truth(0.3, 0.187, 20, 1)
    bounce = ns.PoincareMap(ns.models.moling(), "impact")
    column = ns.bifurcation_diagram(bounce, "b", [0.187], transient=100, record=7).squeeze()
    assert column["period"] == 2
    assert column["impacts"].item() == 1.0
    assert column["events"].item() == events / 2
    assert column["v_per_iterate"].item() == pytest.approx(drift / 2, abs=1e-6)
    assert column["v_per_time"].item() == pytest.approx(drift * 0.1 / (2 * np.pi), abs=1e-6)
