"""Work in which motions follow each other: an interruption keeps it, and it goes on from there."""

import threading

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth.runs import crew

SPEEDS = np.linspace(0.7, 0.9, 256)


def diagram(**options):
    return ns.bifurcation_diagram(
        ns.models.soft_impact(), "omega", SPEEDS, start="follow down", transient=40, record=10,
        threads=1, **options,
    )  # fmt: skip


def section_diagram(**options):
    bounce = ns.PoincareMap(ns.models.soft_impact(), "v", direction=1)
    return ns.bifurcation_diagram(
        bounce, "omega", SPEEDS, start="follow up", transient=10, record=5, threads=1, **options
    )


def contacts(**options):
    return ns.contact_statistics(
        ns.models.soft_impact(), "omega", SPEEDS, start="follow up", transient=40, record=10,
        threads=1, **options,
    )  # fmt: skip


def regimes(**options):
    return ns.regime_map(
        ns.models.soft_impact(), {"omega": SPEEDS[:40], "zeta": [0.01, 0.05]}, start="follow up",
        transient=40, record=20, evidence=200, confirm=200, threads=1, **options,
    )  # fmt: skip


@pytest.fixture
def interrupted(monkeypatch):
    """Ctrl-C when the third result of a task has come, once."""
    calls, take = [], crew.take

    def takes(*arguments):
        result = take(*arguments)
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return result

    monkeypatch.setattr(crew, "take", takes)


@pytest.mark.few(1)
@pytest.mark.parametrize("work", [diagram, section_diagram, contacts])
def test_a_chain_keeps_its_columns_and_goes_on(work, interrupted, tmp_path):
    part = work(store=tmp_path / "s")
    assert part.attrs["status"] == "interrupted"
    done = part.sizes["parameter"]
    assert 32 <= done < SPEEDS.size
    assert f"{done} " in part.attrs["message"]
    whole = work()
    kept = whole.sel(parameter=part["parameter"].values)
    for name in part.data_vars:
        np.testing.assert_array_equal(part[name].values, kept[name].values)
    resumed = work(store=tmp_path / "s")
    xr.testing.assert_identical(resumed, whole)


def test_a_chain_that_is_not_stored_keeps_its_columns(interrupted):
    assert 32 <= diagram().sizes["parameter"] < SPEEDS.size


def test_rows_of_a_map_keep_their_points_and_go_on(interrupted, tmp_path):
    part = regimes(store=tmp_path / "s")
    names = np.array(part["regime"].attrs["flag_meanings"].split())[part["regime"].values]
    done = int(np.count_nonzero(names != "interrupted"))
    assert 32 <= done < names.size
    assert f"{done} of {names.size} points are done and kept" in part.attrs["message"]
    xr.testing.assert_identical(regimes(store=tmp_path / "s"), regimes())


def test_points_of_a_task_that_is_stopped_are_kept(monkeypatch):
    """Points whose verdicts stand are in the result, though others of their task go on."""
    from queue import Empty

    from nonsmooth.analysis.regimes import regime_run

    look, take = regime_run._Motions.look, crew.take
    rounds, is_third = [], threading.Event()

    def looks(motions, *arguments):
        if len(rounds) == 2:  # two looks have settled most of the points
            is_third.set()
            assert motions.group.stop.wait(60.0)
        rounds.append(1)
        return look(motions, *arguments)

    def takes(*arguments):
        try:
            return take(*arguments)
        except Empty:
            if is_third.is_set():
                raise KeyboardInterrupt from None
            raise

    monkeypatch.setattr(regime_run._Motions, "look", looks)
    monkeypatch.setattr(crew, "take", takes)
    grid = ns.regime_map(
        ns.models.soft_impact(), {"omega": np.linspace(0.7, 0.9, 16), "a": [0.7]},
        transient=50, longest=3000, threads=1,
    )  # fmt: skip
    assert grid.attrs["status"] == "interrupted"
    assert 3 <= int(grid["computed"].sum()) < 16


def test_an_ensemble_says_how_many_runs_are_done(interrupted):
    runs = ns.ensemble(
        ns.models.soft_impact(), {"x": np.linspace(-0.5, 0.5, 4000)}, transient=200, record=1,
        threads=1,
    )  # fmt: skip
    done = int(np.count_nonzero(runs["status"].values == "completed"))
    assert 0 < done < 4000
    assert runs.attrs["message"].endswith(f"{done} of 4000 runs are done and kept")
