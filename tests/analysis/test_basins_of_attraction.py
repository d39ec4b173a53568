"""Basins against closed forms, and the two methods against each other."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from scipy import ndimage

import nonsmooth as ns
from analysis.wells import forced_wells, narrow_well, runaway

SIDE = np.linspace(-2.0, 2.0, 40)
SQUARE = {"x": SIDE, "y": SIDE}


@pytest.mark.parametrize("method", ["recurrences", "cell mapping", "generalised cell mapping"])
def test_wells_are_told_apart_by_their_line(method: str) -> None:
    basins = ns.basins_of_attraction(forced_wells(), SQUARE, method=method, samples=64)
    assert basins["label"].dims == ("y", "x")
    x, y = np.meshgrid(SIDE, SIDE)
    off = np.abs(x + y) > 1e-9  # on the line itself the field has no answer
    expected = np.where(x + y > 0, 2, 1)
    assert np.array_equal(basins["label"].values[off], expected[off])
    # a start on the line ends there, at once: both sides lead away
    assert set(basins["label"].values[~off]) <= {-1, -2, 1, 2}


def test_a_basin_of_a_single_row_of_cells_is_found() -> None:
    """No sampled start lies in it: 2 of 1000 in width, and 16 samples."""
    row = np.linspace(-2.0, 2.0, 401)
    basins = ns.basins_of_attraction(
        narrow_well(0.004), {"x": row, "y": np.array([-1.0, 0.0, 1.0])}, samples=16
    )
    inside = np.abs(row - 0.4) < 0.004
    assert inside.sum() == 1
    expected = np.where(inside, 2, np.where(row < 0.4, 1, 3))
    assert np.array_equal(basins["label"].values, np.broadcast_to(expected, (3, 401)))


@pytest.mark.parametrize("method", ["recurrences", "cell mapping", "generalised cell mapping"])
def test_starts_that_run_away_are_labelled(method: str) -> None:
    side = np.linspace(-1.9, 1.9, 20)
    basins = ns.basins_of_attraction(runaway(), {"x": side, "y": side}, method=method, samples=64)
    expected = np.where(np.abs(side) < 1.0, 1, -1)
    assert np.array_equal(basins["label"].values, np.broadcast_to(expected, (20, 20)))
    assert basins.attrs["ended_cells"] == np.sum(expected == -1) * 20
    assert float(basins["fraction"][0]) == pytest.approx(np.mean(expected == 1))


@pytest.mark.parametrize("method", ["recurrences", "cell mapping", "generalised cell mapping"])
def test_cells_behind_a_wall_are_inadmissible(method: str) -> None:
    wall = ns.System(
        states=["x", "v"],
        period="2*pi",
        modes={
            "free": ns.Mode(
                {"x": "v", "v": "cos(t) - x - 0.5*v"},
                exits=[ns.Exit("1 - x", reset={"v": "-0.8*v"}, name="impact")],
            )
        },
    )
    side = np.linspace(-2.1, 2.1, 22)
    basins = ns.basins_of_attraction(wall, {"x": side, "v": side}, method=method, samples=64)
    x = np.broadcast_to(side, (22, 22))
    assert np.all((basins["label"].values == -2) == (x > 1.0))
    assert float(basins["fraction"].sum()) == pytest.approx(1.0)


@pytest.mark.slow
def test_two_methods_agree_on_an_oscillator_with_a_soft_stop() -> None:
    """More than three cells from another label, 99 % of the cells."""
    system, side = ns.models.soft_impact(omega=0.82), np.linspace(-3.0, 3.0, 120)
    region = {"x": side, "v": side}
    one = ns.basins_of_attraction(system, region, samples=200)
    other = ns.basins_of_attraction(system, region, method="cell mapping")
    assert one["period"].values.tolist() == other["period"].values.tolist() == [2, 5]
    assert one["points"].values[:, :2] == pytest.approx(other["points"].values[:, :2], abs=1e-9)
    label = one["label"].values
    away = ndimage.maximum_filter(label, 7) == ndimage.minimum_filter(label, 7)
    assert away.sum() > 500
    assert np.mean(label[away] == other["label"].values[away]) > 0.99


def test_labels_are_where_runs_go() -> None:
    """Each of some cells by `simulate`, for 600 periods, to the nearest attractor."""
    system, side = ns.models.soft_impact(omega=0.86), np.linspace(-3.0, 3.0, 41)
    basins = ns.basins_of_attraction(system, {"x": side, "v": side}, samples=200)
    generator = np.random.default_rng(5)
    for i, j in generator.integers(0, 41, (12, 2)):
        run = ns.simulate(
            system, {"x": side[j], "v": side[i]}, periods=600, samples_per_period=1, events=False
        )
        end = np.array([run["x"][-1], run["v"][-1]])
        distance = np.linalg.norm(basins["points"].values - end, axis=2)
        assert np.nanmin(distance) < 1e-6
        nearest = 1 + int(np.nanargmin(distance) // distance.shape[1])
        assert int(basins["label"][i, j]) == nearest


@pytest.mark.slow
def test_the_mole_has_a_section_with_a_completion() -> None:
    mole = ns.models.moling(a=0.3, b=0.1, xi=0.1, omega=1.45)
    region = {"p": np.linspace(-3, 1, 24), "y": np.linspace(-1, 1, 20)}
    basins = ns.basins_of_attraction(
        mole, region, completion={"q": "max(0, p - g)"}, samples=200, record=4000
    )
    assert basins["label"].shape == (20, 24)
    assert basins["period"].values.tolist() == [4, 12, 0]
    assert basins.attrs["inadmissible_cells"] == 0
    assert float(basins["fraction"].sum()) == pytest.approx(1.0)
    with pytest.raises(ns.OptionError, match="q is not in the region"):
        ns.basins_of_attraction(mole, region, method="cell mapping")
    # chaos or a cycle, by the strobes of each cell after 2000 periods
    y, p = (axis.ravel() for axis in np.meshgrid(region["y"], region["p"], indexing="ij"))
    starts = {"p": p, "y": y, "q": np.maximum(0.0, p - mole.parameter_values["g"])}
    late = ns.ensemble(mole, starts, transient=2000, record=48)["y"].values
    four, twelve = (np.ptp(late[:, ::n], axis=1) < 1e-6 for n in (4, 12))
    found = np.where(four, 4, np.where(twelve, 12, 0))
    assert np.array_equal(basins["period"].values[basins["label"].values.ravel() - 1], found)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["cell mapping", "generalised cell mapping"])
def test_cells_on_a_slaved_surface_stand_for_points_on_it(method: str) -> None:
    """The mole in three dimensions: q has cells, and contact lives on p = q + g."""
    mole = ns.models.moling(a=0.3, b=0.15, xi=0.1, omega=0.5)
    region = {
        "p": np.linspace(-2, 1, 20), "y": np.linspace(-1, 1, 12), "q": np.linspace(-0.2, 1.2, 12),
    }  # fmt: skip
    mapped = ns.basins_of_attraction(mole, region, method=method, record=2000)
    followed = ns.basins_of_attraction(mole, region, samples=100, record=2000)
    assert mapped["label"].dims == ("q", "y", "p")
    assert mapped["period"].values.tolist() == followed["period"].values.tolist()
    both = (mapped["label"].values > 0) & (followed["label"].values > 0)
    assert np.mean(mapped["label"].values[both] == followed["label"].values[both]) > 0.9
    # where a centre is inadmissible, a point of the cell may not be
    assert np.all(followed["label"].values[mapped["label"].values == -2] == -2)


@pytest.mark.slow
def test_the_number_of_threads_changes_nothing() -> None:
    mole = ns.models.moling(a=0.3, b=0.1, xi=0.1, omega=1.45)
    region = {"p": np.linspace(-3, 1, 50), "y": np.linspace(-1, 1, 50)}
    one, three = (
        ns.basins_of_attraction(
            mole, region, completion={"q": "max(0, p - g)"}, samples=100, record=2000,
            threads=threads,
        )
        for threads in (1, 3)
    )  # fmt: skip
    xr.testing.assert_identical(one, three)


def test_a_store_goes_on_where_it_was(tmp_path, monkeypatch) -> None:
    from nonsmooth.analysis.basins import by_recurrences

    region = {"x": np.linspace(-2, 2, 64), "y": np.linspace(-2, 2, 64)}
    whole = ns.basins_of_attraction(forced_wells(), region, samples=64)
    ns.basins_of_attraction(forced_wells(), region, samples=64, store=tmp_path / "store")
    chunks = sorted((tmp_path / "store").glob("*.npz"))
    assert len(chunks) == 4
    for path in chunks[1:3]:
        path.unlink()
    computed = []
    real = by_recurrences._label

    def counting(*arguments):
        computed.append(1)
        return real(*arguments)

    monkeypatch.setattr(by_recurrences, "_label", counting)
    again = ns.basins_of_attraction(forced_wells(), region, samples=64, store=tmp_path / "store")
    assert len(computed) == 2
    xr.testing.assert_identical(whole, again)
    with pytest.raises(ns.OptionError, match="match"):
        ns.basins_of_attraction(
            forced_wells(), region, samples=64, match=1e-5, store=tmp_path / "store"
        )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"region": {"x": SIDE}}, "two states"),
        ({"region": {"x": SIDE, "z": SIDE}}, "'z'"),
        ({"region": {"x": SIDE[::-1], "y": SIDE}}, "increasing"),
        ({"region": {"x": [], "y": SIDE}}, "finite"),
        ({"region": {"x": SIDE, "y": [1.0]}}, "two increasing"),
        ({"region": {"x": SIDE, "y": (-1.0, 2.0)}}, r"is a range.*np.linspace\(-1, 2, 200\)"),
        ({"region": {"x": SIDE, "y": (-1.0, 2.0, 50)}}, r"is a range.*np.linspace\(-1, 2, 50\)"),
        ({"region": {"x": np.arange(1e5), "y": np.arange(1e6)}}, "cells"),
        ({"method": "magic"}, "cell mapping"),
        ({"threads": 0}, "threads"),
        ({"longest": -5}, "longest"),
        ({"method": "cell mapping", "store": "somewhere"}, "store"),
    ],
)
def test_bad_input_is_named(change: dict, message: str) -> None:
    options = {"region": SQUARE, **change}
    with pytest.raises(ns.OptionError, match=message):
        ns.basins_of_attraction(forced_wells(), **options)


@pytest.mark.parametrize("name", ["label", "attractor", "multiplier", "fraction", "probability"])
def test_states_called_like_parts_of_the_result(name: str) -> None:
    pair = ns.System(states=[name, "y"], period=1.0, equations={name: f"-{name}", "y": "-y"})
    with pytest.raises(ns.OptionError, match=f"{name}.*another name"):
        ns.basins_of_attraction(pair, {name: SIDE, "y": SIDE})
    assert ns.attractors(pair, {name: (-1, 1)}, samples=8).sizes["attractor"] == 1


@pytest.mark.slow
def test_starts_whose_other_states_follow():
    """A rotor outside its ring's clearance: the ring's place is that of a run from there."""
    system = ns.models.rotor(eta=0.9, eps_x=1.0)
    region = {"x": [-1.3, 0.2, 1.2], "y": [-1.2, 0.1]}
    found = ns.basins_of_attraction(system, region, samples=8, record=200)
    assert (found["label"] == 1).all()
    for x in region["x"]:
        end = ns.simulate(system, {"x": x, "y": -1.2}, periods=200).isel(time=-1)
        for name in ("x", "y", "vx", "vy", "sx", "sy"):
            settled = found["points"].sel(attractor=1, state=name).values[0]
            assert float(end[name]) == pytest.approx(float(settled), abs=1e-8)
    with pytest.raises(ns.OptionError, match=r"completion\['sx'\] = 'log\(x\)' is nan"):
        ns.basins_of_attraction(system, region, completion={"sx": "log(x)"})
