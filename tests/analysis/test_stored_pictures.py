"""A picture that was interrupted goes on where it was, and its result is the same to the bit."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from effort import HANG
from nonsmooth.runs.packed_datasets import pack_dataset, unpack_dataset
from nonsmooth.runs.store import Store, read_arrays, write_arrays

REGION = {"x": (-2.0, 2.0), "v": (-2.0, 2.0)}
OPTIONS = {"columns": 5, "samples": 8, "searches": 1, "record": 200}


def picture(store=None, **changed):
    """Attractors of several kinds, a graze, a flip with its branch, and a search."""
    soft = ns.models.soft_impact(omega=0.8)
    return ns.bifurcation_picture(soft, "a", (0.5, 0.8), REGION, **OPTIONS | changed, store=store)


@pytest.fixture(scope="module")
def straight():
    return picture()


def chunks(folder):
    return {path.name: path.read_bytes() for path in folder.glob("[0-9]*.npz")}


def interrupting(monkeypatch, after):
    """Ctrl-C while the chunk after so many is written, which is lost; and how many were begun."""
    begun = []

    def put(self, i, arrays, original=Store.put):
        begun.append(i)
        if len(begun) > after:
            raise KeyboardInterrupt
        original(self, i, arrays)

    monkeypatch.setattr(Store, "put", put)
    return begun


@pytest.mark.slow
def test_a_store_changes_nothing(straight, tmp_path) -> None:
    xr.testing.assert_identical(picture(tmp_path / "store"), straight)
    again = picture(tmp_path / "store")
    xr.testing.assert_identical(again, straight)
    assert straight.attrs["status"] == "completed" and straight.sizes["branch"] >= 2
    # columns up and down, the search, and each branch
    assert len(chunks(tmp_path / "store")) >= 5 + 4 + 1 + straight.sizes["branch"]


@pytest.mark.slow
def test_an_interruption_at_any_chunk_loses_nothing(straight, tmp_path, monkeypatch) -> None:
    """At each call one more chunk is done, until there are no more."""
    store = tmp_path / "store"
    for turn in range(60):
        with monkeypatch.context() as patch:
            begun = interrupting(patch, 1)
            found = picture(store)
        if found.attrs["status"] == "completed":
            break
        assert begun == [turn, turn + 1]
        assert found.attrs["message"].startswith("interrupted by the user")
    xr.testing.assert_identical(found, straight)
    assert len(chunks(store)) in (turn, turn + 1)


@pytest.mark.slow
def test_a_killed_process_is_gone_on_from(straight, tmp_path) -> None:
    """The process ends as one that is killed does: nothing is tidied up.

    The lock keeps other threads from writing one more chunk meanwhile.
    """
    store = tmp_path / "store"
    code = f"""
import os
import threading
import nonsmooth as ns
from nonsmooth.runs.store import Store

ONE_AT_A_TIME = threading.Lock()

def put(self, i, arrays, original=Store.put):
    with ONE_AT_A_TIME:
        original(self, i, arrays)
        if len(self.done) == 7:
            os._exit(9)

Store.put = put
soft = ns.models.soft_impact(omega=0.8)
ns.bifurcation_picture(
    soft, "a", (0.5, 0.8), {REGION!r}, **{OPTIONS!r}, store={str(store)!r}
)
"""
    work = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, timeout=HANG, check=False
    )
    assert work.returncode == 9, work.stderr.decode()
    done = chunks(store)
    assert len(done) == 7
    xr.testing.assert_identical(picture(store), straight)
    assert {name: data for name, data in chunks(store).items() if name in done} == done


@pytest.mark.slow
def test_a_damaged_chunk_is_done_again(straight, tmp_path) -> None:
    store = tmp_path / "store"
    picture(store)
    whole = chunks(store)
    for name in ("000002.npz", "000006.npz", "000010.npz"):
        (store / name).write_bytes(whole[name][:-1])
    with pytest.warns(ns.ResultWarning, match="damaged files, which are computed again"):
        found = picture(store)
    xr.testing.assert_identical(found, straight)
    assert chunks(store) == whole


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"columns": 6}, "columns: 5 then, 6 now"),
        ({"longest": 3}, "longest: 2 then, 3 now"),
        ({"seed": 1}, "seed: 0 then, 1 now"),
        ({"record": 300}, "record: 200 then, 300 now"),
        ({"steps": 50}, "steps: 1000 then, 50 now"),
        ({"parameters": {"zeta": 0.02}}, "zeta = 0.01"),
    ],
)
def test_other_options_are_refused_by_name(tmp_path, monkeypatch, changed, told) -> None:
    with monkeypatch.context() as patch:
        interrupting(patch, 0)
        picture(tmp_path / "store")
    with pytest.raises(ns.OptionError, match="was begun with other options") as refused:
        picture(tmp_path / "store", **changed)
    assert told in str(refused.value)


@pytest.mark.slow
def test_points_that_are_kept_may_change(tmp_path) -> None:
    picture(tmp_path / "store")
    done = chunks(tmp_path / "store")
    fewer = picture(tmp_path / "store", points=10)
    assert fewer.sizes["strobe"] == 10 and chunks(tmp_path / "store") == done


def test_datasets_come_back_to_the_bit(tmp_path) -> None:
    data = xr.Dataset(
        {
            "z": ("k", np.array([1 + 2j, np.nan]), {"flag_values": np.array([0, 1], np.int8)}),
            "word": ("k", np.array(["", "free contact"])),
            "flag": ("k", np.array([True, False])),
            "one": ((), np.float32(0.1)),
        },
        {"k": ("k", [3, 4]), "time": ("k", [0.1, np.inf])},
        {"a": 1, "b": 0.1, "c": "text\n", "d": np.float64(0.1), "e": np.arange(3), "f": [1, 2]},
    )
    write_arrays(tmp_path / "data.npz", pack_dataset(data))
    back = unpack_dataset(read_arrays(tmp_path / "data.npz"))
    xr.testing.assert_identical(back, data)
    assert {name: back[name].dtype for name in back.variables} == {
        name: data[name].dtype for name in data.variables
    }
    assert back["z"].attrs["flag_values"].dtype == np.int8
    assert type(back.attrs["d"]) is np.float64
