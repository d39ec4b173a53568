"""Maps in tiles: the same digits as in one process, whatever happens on the way."""

import errno
import json
import os
import pickle
import shutil
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth import Exit, Mode, OptionError, ResultWarning, RunError, System
from nonsmooth.cluster.task_progress import message_of
from nonsmooth.cluster.tile_store import TileStore
from nonsmooth.runs.claims import Claims

work_file = import_module("nonsmooth.cluster.work")  # the package has the verb by this name
SHORT = {"transient": 30, "record": 20, "evidence": 20, "confirm": 0, "longest": 60}
OVER = {"omega": np.linspace(0.7, 1.0, 7), "a": np.linspace(0.4, 1.0, 5)}


def plan(folder, **more):
    """A map of 7 times 5 points in six tiles, of which the last ones are smaller."""
    store = folder / "map.zarr"
    options = {"tile": 3, **SHORT, **more}
    ns.cluster.plan_map(store, ns.models.soft_impact(zeta=0.03), OVER, **options)
    return store


@pytest.fixture(scope="module")
def whole():
    """The same map from one process."""
    return ns.regime_map(ns.models.soft_impact(zeta=0.03), OVER, **SHORT)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """The map in tiles, all of which are done."""
    store = plan(tmp_path_factory.mktemp("finished"))
    job = ns.cluster.work(store, threads=2)
    assert job.attrs["status"] == "completed" and int(job["done"]) == 6
    return store


@pytest.fixture
def own(finished, tmp_path):
    """A copy of it, to be damaged."""
    return shutil.copytree(finished, tmp_path / "map.zarr")


def assert_same(store, whole):
    """Bit for bit, with types, attributes and the words."""
    grid = ns.cluster.open_map(store).load()
    assert list(grid.data_vars) == list(whole.data_vars)
    for name, variable in whole.variables.items():
        other = grid[name]
        values = other.values.astype(object) if name == "word" else other.values
        assert other.dims == variable.dims
        assert name == "word" or values.dtype == variable.dtype
        same = values.astype(variable.dtype).tobytes() == variable.values.tobytes()
        assert same, f"{name} differs"
        for key, value in variable.attrs.items():
            assert np.array_equal(other.attrs[key], value)
    told = {key: value for key, value in whole.attrs.items() if key != "message"}
    assert {key: grid.attrs[key] for key in told} == told


def test_the_digits_are_those_of_one_process(finished, whole):
    assert_same(finished, whole)
    assert set(np.unique(whole["regime"])) != {2}, "a map of one label would show little"


@pytest.mark.slow
def test_a_border_in_closed_form(tmp_path):
    """Critically damped, the steady amplitude is F / (1 + w^2); beyond 1.5 the motion stops."""
    system = System(
        states=["x", "v"],
        parameters={"w": 1.0, "F": 1.0},
        period="2*pi/w",
        modes={
            "m": Mode({"x": "v", "v": "-x - 2*v + F*cos(w*t)"}, exits=[Exit("1.5 - x", to="stop")])
        },
    )
    force, speed = np.linspace(1.0, 4.0, 9), np.linspace(0.3, 1.2, 6)
    ns.cluster.plan_map(
        tmp_path / "m.zarr", system, {"F": force, "w": speed}, tile=4, transient=60, record=10
    )
    ns.cluster.work(tmp_path / "m.zarr", threads=1)
    grid = ns.cluster.open_map(tmp_path / "m.zarr")
    names = np.array(grid["regime"].attrs["flag_meanings"].split())[grid["regime"].values]
    amplitude = force[None, :] / (1.0 + speed[:, None] ** 2)
    clear = np.abs(amplitude - 1.5) > 0.15  # the transient may reach a little higher
    expected = np.where(amplitude > 1.5, "absorbed", "periodic")
    assert np.array_equal(names[clear], expected[clear])


def test_what_is_not_done_reads_as_interrupted(tmp_path, whole):
    store = plan(tmp_path)
    job = ns.cluster.work(store, tiles=[1, 4], threads=1)
    assert job["state"].values.tolist() == [[0, 2, 0], [0, 2, 0]]
    grid = ns.cluster.open_map(store)
    assert grid.attrs["status"] == "interrupted"
    assert grid.attrs["message"] == "2 of 6 tiles are done"
    there = np.zeros((5, 7), bool)
    there[:, 3:6] = True
    assert np.array_equal(grid["regime"].values[there], whole["regime"].values[there])
    names = np.array(grid["regime"].attrs["flag_meanings"].split())
    assert set(names[grid["regime"].values[~there]]) == {"interrupted"}
    assert not np.any(grid["computed"].values[~there]) and np.all(grid["computed"].values[there])
    assert np.all(np.isnan(grid["events"].values[~there]))
    ns.cluster.work(store, threads=1)
    assert_same(store, whole)


@pytest.mark.slow
def test_pictures_take_it(finished):
    grid = ns.cluster.open_map(finished)
    ax = ns.plot.regime_map(grid.isel(omega=slice(None, None, 2)), words=True)
    assert ax.get_xlabel()


def test_a_tile_of_which_nothing_is_known_is_written_too(tmp_path):
    """All values of such a tile are those that arrays are filled with; it is whole all the same."""
    limited = System(
        states=["x"], parameters={"a": 1.0, "b": 1.0}, period="1", equations={"x": "-x*a"},
        require={"b < 2": "b is too large"},
    )  # fmt: skip
    store = tmp_path / "map.zarr"
    ns.cluster.plan_map(store, limited, {"a": [1.0, 2.0], "b": [2.5, 3.0]}, **SHORT)
    ns.cluster.work(store, threads=1)  # all warnings are errors here
    ns.cluster.work(store, threads=1)
    opened = TileStore.open(store)
    assert opened.damaged(opened.at(0)) == ""


@pytest.mark.parametrize(
    ("harm", "told"),
    [
        (lambda path: path.write_bytes(path.read_bytes()[:-9]), "the checksum of K is wrong"),
        (lambda path: path.write_bytes(b""), "the checksum of K is wrong"),
        (lambda path: path.write_bytes(b"\0" * 40), "the checksum of K is wrong"),
        (lambda path: path.unlink(), "K is missing"),
        (lambda path: _flip(path), "the checksum of K is wrong"),
    ],
)
def test_a_damaged_chunk_is_told_and_computed_again(own, whole, harm, told):
    harm(own / "K" / "c" / "1" / "2")
    with pytest.warns(ResultWarning, match=f"computed again: tile 5 .{told}"):
        ns.cluster.work(own, threads=1)
    assert_same(own, whole)


def test_a_damaged_chunk_of_an_open_map_is_told_by_its_file(own):
    """When its values are read, and not before; other variables are as they were."""
    grid = ns.cluster.open_map(own)
    _flip(own / "K" / "c" / "1" / "2")
    assert np.isfinite(grid["period"].values).all()
    with pytest.raises(ns.RunError, match=r"K/c/1/2 is damaged; nonsmooth\.cluster\.work"):
        grid["K"].load()
    assert grid["K"][:2, :2].values.shape == (2, 2)  # of another tile


def test_an_open_map_goes_to_other_processes(finished):
    sent = pickle.loads(pickle.dumps(ns.cluster.open_map(finished)))
    xr.testing.assert_identical(sent, ns.cluster.open_map(finished))


def _flip(path):
    """One bit of a chunk."""
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 4
    path.write_bytes(content)


def test_a_torn_mark_does_not_count(own, whole):
    (own / "tiles" / "seconds" / "c" / "0" / "1").write_bytes(b"")
    with pytest.warns(ResultWarning, match="tile 1 .the checksum of tiles/seconds is wrong"):
        ns.cluster.work(own, threads=1)
    assert_same(own, whole)


# ---------------------------------------------------------------- plans


def test_the_same_plan_goes_on_and_another_one_is_refused(tmp_path):
    store = plan(tmp_path)
    ns.cluster.work(store, tiles=[0], threads=1)
    plan(tmp_path)
    assert int(ns.cluster.progress(store)["done"]) == 1
    soft, wider = ns.models.soft_impact(zeta=0.03), {**OVER, "a": np.linspace(0.4, 1.1, 5)}
    for system, over, more, difference in (
        (soft, OVER, {"record": 22}, "record: 20 then, 22 now"),
        (soft, OVER, {"tile": 2}, "tile: 3 then, 2 now"),
        (soft, OVER, {"initial": {"x": 0.1}}, "initial"),
        (ns.models.soft_impact(zeta=0.04), OVER, {}, "0.03.* then, .*0.04"),
        (soft, wider, {}, r"\['a'\]\[1\]: 0.55 then, 0.57"),
    ):
        with pytest.raises(OptionError, match=difference):
            ns.cluster.plan_map(store, system, over, **({"tile": 3, **SHORT} | more))


@pytest.mark.slow
def test_many_may_plan_the_same_job_at_once(tmp_path):
    gate, faults = threading.Barrier(6), []

    def begin():
        gate.wait()
        try:
            plan(tmp_path)
        except Exception as fault:
            faults.append(fault)

    crew = [threading.Thread(target=begin) for _ in range(6)]
    for each in crew:
        each.start()
    for each in crew:
        each.join()
    assert faults == []
    assert [path.name for path in tmp_path.iterdir()] == ["map.zarr"]
    assert int(ns.cluster.progress(tmp_path / "map.zarr")["tiles"]) == 6


def change_plan(store, **changes):
    path = store / "tiles" / "zarr.json"
    whole = json.loads(path.read_text())
    whole["attributes"]["plan"] |= changes
    path.write_text(json.dumps(whole))


def test_stores_of_other_versions_are_refused(tmp_path):
    store = plan(tmp_path)
    change_plan(store, version="0.0.9")
    for verb in (ns.cluster.work, ns.cluster.forecast):
        with pytest.raises(OptionError, match=r"nonsmooth 0\.0\.9.*install that version"):
            verb(store)
    with pytest.raises(OptionError, match=r"begun with nonsmooth 0\.0\.9"):
        plan(tmp_path)
    assert int(ns.cluster.progress(store)["tiles"]) == 6  # to read is allowed
    for number in (0, 1, 3):
        change_plan(store, format=number)
        for verb in (ns.cluster.work, ns.cluster.progress, ns.cluster.open_map):
            with pytest.raises(OptionError, match=rf"has the format {number}, .*reads 2; use"):
                verb(store)


def test_what_is_no_store_is_refused(tmp_path):
    with pytest.raises(OptionError, match="there is nothing; make one with"):
        ns.cluster.work(tmp_path / "none.zarr")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "notes.txt").write_text("mine")
    with pytest.raises(OptionError, match="no store; make one"):
        ns.cluster.progress(tmp_path / "other")
    over = {"omega": [0.7, 0.8], "a": [0.5, 0.6]}
    with pytest.raises(OptionError, match="not empty; give a new folder"):
        ns.cluster.plan_map(tmp_path / "other", ns.models.soft_impact(), over)
    assert (tmp_path / "other" / "notes.txt").read_text() == "mine"
    with pytest.raises(OptionError, match="does not exist; make it first"):
        ns.cluster.plan_map(tmp_path / "no" / "m.zarr", ns.models.soft_impact(), over)
    with pytest.raises(OptionError, match="is a file"):
        ns.cluster.open_map(tmp_path / "other" / "notes.txt")
    (tmp_path / "empty").mkdir()
    ns.cluster.plan_map(tmp_path / "empty", ns.models.soft_impact(), over)


# ---------------------------------------------------------------- what goes wrong at work


def test_a_full_disk_is_told_and_what_is_done_stays(tmp_path, whole, monkeypatch):
    store, put, written = plan(tmp_path), TileStore.put, []

    def full(own, tile, found, seconds):
        if len(written) == 3:
            # some variables have been written, and then there is no room
            own._array("regime")[tile.rows, tile.columns] = found["regime"].values
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written.append(tile)
        put(own, tile, found, seconds)

    monkeypatch.setattr(TileStore, "put", full)
    with pytest.raises(RunError, match=r"No space left.*What is done is kept: make room"):
        ns.cluster.work(store, threads=1)
    job = ns.cluster.progress(store)
    assert (int(job["done"]), int(job["failed"]), int(job["claimed"])) == (3, 0, 0)
    monkeypatch.setattr(TileStore, "put", put)
    ns.cluster.work(store, threads=1)
    assert_same(store, whole)


def test_a_folder_that_takes_no_files_is_told(tmp_path, monkeypatch):
    store = plan(tmp_path)

    def locked(own, tile):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(Claims, "take", locked)
    with pytest.raises(OptionError, match="give a folder in which files may be made"):
        ns.cluster.work(store, threads=1)


def test_a_tile_that_fails_is_recorded_and_the_others_go_on(tmp_path, whole, monkeypatch):
    store, compute = plan(tmp_path), work_file.tile_map

    def faulty(question, levels, rows, columns, runner, stop):
        if (rows.start, columns.start) == (3, 0):
            raise ValueError("this tile is jinxed")
        return compute(question, levels, rows, columns, runner, stop)

    monkeypatch.setattr(work_file, "tile_map", faulty)
    job = ns.cluster.work(store, threads=2)
    assert (int(job["done"]), int(job["failed"])) == (5, 1)
    assert job["failed_tile"].values.tolist() == [3]
    assert job["reason"].values.tolist() == ["ValueError: this tile is jinxed"]
    assert job["state"].values.tolist() == [[2, 2, 2], [3, 2, 2]]
    monkeypatch.setattr(work_file, "tile_map", compute)
    assert int(ns.cluster.work(store, threads=1)["done"]) == 5  # it is not tried again unasked
    ns.cluster.work(store, threads=1, retry=True)
    assert int(ns.cluster.progress(store)["failed"]) == 0
    assert_same(store, whole)


@pytest.mark.slow
def test_no_tile_is_begun_after_the_time(tmp_path, monkeypatch):
    store, compute = plan(tmp_path), work_file.tile_map

    def slow(*given):
        time.sleep(0.3)
        return compute(*given)

    monkeypatch.setattr(work_file, "tile_map", slow)
    job = ns.cluster.work(store, threads=1, max_seconds=0.4)
    assert 1 <= int(job["done"]) <= 2 and job.attrs["status"] == "incomplete"


def test_an_interruption_keeps_what_is_done(tmp_path, whole, monkeypatch, interrupts):
    store, put = plan(tmp_path), TileStore.put

    def interrupted(own, tile, found, seconds):
        put(own, tile, found, seconds)
        if len(own.done()) == 2:
            os.kill(os.getpid(), 2)

    monkeypatch.setattr(TileStore, "put", interrupted)
    job = ns.cluster.work(store, threads=1)
    assert job.attrs["status"] == "interrupted" and 2 <= int(job["done"]) < 6
    assert not list((store / "tiles" / "claims").iterdir())
    monkeypatch.setattr(TileStore, "put", put)
    ns.cluster.work(store, threads=1)
    assert_same(store, whole)


@pytest.mark.slow
def test_an_executor_gives_the_same_digits(tmp_path, whole):
    store = plan(tmp_path)
    with ThreadPoolExecutor(2) as pool:
        job = ns.cluster.work(store, executor=pool)
    assert job.attrs["status"] == "completed"
    assert_same(store, whole)


def test_faults_in_an_executor_come_out(tmp_path, monkeypatch):
    store = plan(tmp_path)

    def full(own, tile, found, seconds):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(TileStore, "put", full)
    with ThreadPoolExecutor(1) as pool, pytest.raises(RunError, match="make room"):
        ns.cluster.work(store, executor=pool)
    for wrong in ({"executor": 3}, {"client": 3}):
        with pytest.raises(OptionError, match=next(iter(wrong))):
            ns.cluster.work(store, **wrong)


# ---------------------------------------------------------------- claims


@pytest.mark.parametrize("name", ["zarr.json", "regime/zarr.json", "omega/zarr.json"])
@pytest.mark.parametrize("damage", ["missing", "empty", "zeros", "braces"])
def test_damaged_descriptions_are_told_by_name(tmp_path, name, damage):
    store = plan(tmp_path)
    path = store / name
    damaged = {"empty": b"", "zeros": b"\0" * 9, "braces": b"{}"}
    path.write_bytes(damaged[damage]) if damage in damaged else path.unlink()
    verbs = [ns.cluster.open_map]
    if name == "zarr.json":  # which all of them look at
        verbs += [ns.cluster.progress, ns.cluster.work]
    for verb in verbs:
        with pytest.raises(OptionError, match=f"{name} in it is damaged or missing"):
            verb(store)


def test_stores_of_calls_and_files_in_the_path_are_told(tmp_path):
    ns.bifurcation_diagram(
        ns.models.soft_impact(), "omega", [0.7, 0.8], transient=5, record=5, store=tmp_path / "s"
    )
    for verb in (ns.cluster.work, ns.cluster.open_map, ns.cluster.forecast):
        with pytest.raises(OptionError, match="that of a call with store=, and no map in tiles"):
            verb(tmp_path / "s")
    (tmp_path / "file").write_text("x")
    with pytest.raises(OptionError, match="lies in a file"):
        ns.cluster.progress(tmp_path / "file" / "map")


class Given(Exception):
    """What a cluster raises for a task whose workers died."""


Given.__module__ = "distributed.scheduler"


class Unlucky(ThreadPoolExecutor):
    """Gives up one of the tiles so many times."""

    times = 0

    def submit(self, call, path, identity, number, patience):
        if number == 4 and self.times:
            self.times -= 1
            return super().submit(self.lose)
        return super().submit(call, path, identity, number, patience)

    def lose(self):
        raise Given("4 workers died")


@pytest.mark.parametrize(("times", "failed"), [(3, []), (4, [4])])
def test_a_tile_that_is_given_up_is_tried_again_but_not_for_ever(tmp_path, times, failed):
    """Its workers may have died of something else."""
    store = plan(tmp_path)
    with Unlucky(2) as pool:
        pool.times = times
        job = ns.cluster.work(store, executor=pool)
    assert job["failed_tile"].values.tolist() == failed
    assert int(job["done"]) == 6 - len(failed)


@pytest.mark.slow
def test_tiles_of_a_living_worker_are_waited_for(tmp_path, whole):
    """And taken over when it falls silent, though somebody has claimed all of them."""
    store = plan(tmp_path)
    opened = TileStore.open(store)
    gone = Claims(opened.job, 0.2)
    sign = store / "tiles" / "workers" / f"{gone.worker}.json"
    sign.write_text(json.dumps({"place": "another machine", "process": 1}))
    assert all(gone.take(opened.at(number).key) for number in range(6))
    assert int(ns.cluster.progress(store)["claimed"]) == 6
    began = time.monotonic()
    job = ns.cluster.work(store, threads=2, patience=0.5)
    assert time.monotonic() - began > 0.5 and job.attrs["status"] == "completed"
    assert_same(store, whole)


# ---------------------------------------------------------------- cost


def test_a_forecast_counts_what_is_left(tmp_path):
    store = plan(tmp_path)
    cost = ns.cluster.forecast(store, sample=8, threads=1)
    assert int(cost["points"]) == 35 and float(cost["seconds"]) > 0.0
    ns.cluster.work(store, threads=1, tiles=[0, 1])
    less = ns.cluster.forecast(store, sample=8, threads=1)
    assert int(less["points"]) == 35 - 18
    ns.cluster.work(store, threads=1)
    none = ns.cluster.forecast(store)
    assert int(none["points"]) == 0 and float(none["seconds"]) == 0.0
    chunks = [each for each in store.rglob("c/*/*") if each.is_file()]
    assert float(none["bytes"]) == sum(each.stat().st_size for each in chunks)


def test_numbers_of_tiles_and_sizes(tmp_path):
    store = plan(tmp_path)
    with pytest.raises(OptionError, match="there is no tile 6; they are counted from 0 to 5"):
        ns.cluster.work(store, tiles=[6])
    over = {"omega": np.linspace(0.7, 0.8, 3000), "a": np.linspace(0.1, 0.2, 3000)}
    with pytest.raises(OptionError, match="take a larger tile="):
        ns.cluster.plan_map(tmp_path / "m.zarr", ns.models.soft_impact(), over, tile=2)
    with pytest.raises(OptionError, match="at most 1024"):
        ns.cluster.plan_map(tmp_path / "m.zarr", ns.models.soft_impact(), over, tile=2000)
    with pytest.raises(OptionError, match="initial: give the states as numbers"):
        ns.cluster.plan_map(
            tmp_path / "m.zarr", ns.models.soft_impact(), over, initial=xr.Dataset()
        )


def test_one_tile_is_not_many():
    assert message_of("tiles", 1, 1, 0, 0) == "the only tile is done"
    assert message_of("tasks", 2, 2, 0, 0) == "all 2 tasks are done"
