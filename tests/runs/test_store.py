"""Stores: what is written is what is read, and every way of going wrong is told."""

import errno
import json
import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.errors import OptionError, ResultWarning, RunError
from nonsmooth.runs.crew import run_tasks
from nonsmooth.runs.store import Damaged, Store, read_arrays, write_arrays
from nonsmooth.runs.stored_tasks import run_stored_tasks

ARRAYS = {
    "x": np.array([[1.0, np.nan], [-0.0, np.inf]]),
    "file": np.array(["wand", "∂Ω"]),  # also the name of an argument of numpy's own function
    "n": np.int64(3),
    "none": np.zeros((0, 4)),
}


def same(one, two):
    return set(one) == set(two) and all(
        np.asarray(one[k]).dtype == two[k].dtype
        and np.asarray(one[k]).shape == two[k].shape
        and np.asarray(one[k]).tobytes() == two[k].tobytes()
        for k in one
    )


def test_arrays_come_back_bit_for_bit(tmp_path):
    with Store.open(tmp_path / "s", {"a": 1}, 3) as store:
        store.put(1, ARRAYS)
        assert same(ARRAYS, store.get(1))
    with Store.open(str(tmp_path / "s"), {"a": 1}, 3) as store:
        assert store.done == {1}
        assert same(ARRAYS, store.get(1))
    with np.load(tmp_path / "s" / "000001.npz") as plain:  # as others read it
        assert plain["x"].tobytes() == ARRAYS["x"].tobytes()


@pytest.mark.slow
def test_no_changed_bit_and_no_missing_end_is_taken_for_data(tmp_path):
    path = tmp_path / "a.npz"
    write_arrays(path, ARRAYS)
    content = path.read_bytes()
    for i in range(len(content)):
        changed = bytearray(content)
        changed[i] ^= 1 << (i % 8)
        for wrong in (bytes(changed), content[:i]):
            path.write_bytes(wrong)
            with pytest.raises(Damaged):
                read_arrays(path)


def test_objects_are_not_pickled(tmp_path):
    with pytest.raises(ValueError, match="Object arrays"):
        write_arrays(tmp_path / "a.npz", {"x": np.array([{}], object)})
    assert list(tmp_path.iterdir()) == []


def test_the_protocol_is_told(tmp_path):
    protocol = {"system": "a\nb", "tolerance": 1e-12, "values": np.array([0.1, 2]), "mode": None}
    with Store.open(tmp_path / "s", protocol, 3):
        pass
    told = json.loads((tmp_path / "s" / "protocol.json").read_text(encoding="utf-8"))
    assert told["protocol"] == protocol | {"values": [0.1, 2.0]}
    assert (told["format"], told["tasks"]) == (1, 3)
    assert told["nonsmooth_version"]


@pytest.mark.parametrize(
    ("now", "n_tasks", "lines"),
    [
        ({"transient": 5}, 3, ["transient: 4 then, 5 now"]),
        ({"grid": np.array([1.0, 2.5])}, 3, ["grid[1]: 2.0 then, 2.5 now"]),
        ({"grid": np.array([1.0])}, 3, ["grid: [1.0, 2.0] then, [1.0] now"]),
        ({"system": "a = 1\nb = 3"}, 3, ["system: b = 2 then, b = 3 now"]),
        ({"system": "a = 1\nb = 2\nc"}, 3, ["system: nothing then, c now"]),
        ({"nested": {"q": [1, {"r": 3}]}}, 3, ["nested['q'][1]['r']: 2 then, 3 now"]),
        ({"long": np.ones(5000)}, 3, ["long: an array (5000,) of content"]),
        ({"new": 1}, 3, ["new: not given then, 1 now"]),
        ({}, 4, ["tasks: 3 then, 4 now"]),
        ({"transient": 4.0}, 3, ["transient: 4 then, 4.0 now"]),
        ({"transient": 5, "nan": 0.0}, 3, ["transient: 4 then", "nan: nan then, 0.0 now"]),
    ],
)
def test_other_options_are_refused_by_name(tmp_path, now, n_tasks, lines):
    before = {
        "system": "a = 1\nb = 2", "transient": 4, "grid": np.array([1.0, 2.0]),
        "long": np.zeros(5000), "nested": {"q": [1, {"r": 2}]}, "nan": float("nan"),
    }  # fmt: skip
    for protocol in (before, dict(reversed(before.items()))):  # order is no difference
        with Store.open(tmp_path / "s", protocol, 3) as store:
            store.put(0, ARRAYS)
    with pytest.raises(OptionError) as refused:
        Store.open(tmp_path / "s", before | now, n_tasks)
    for line in [*lines, "was begun with other options", "give another folder"]:
        assert line in str(refused.value)


@pytest.mark.parametrize(
    ("now", "told"),
    [
        ({"record": 6, "longest": 96}, ["record"]),
        ({"longest": 96}, ["longest"]),
        ({"record": 6, "longest": 90, "follow": []}, ["record", "longest"]),
        ({"system": "a = 2", "changed_parameters": "a"}, ["system"]),
        ({"changed_parameters": "a"}, ["changed_parameters"]),
    ],
)
def test_what_follows_from_other_options_is_not_told_beside_them(tmp_path, now, told):
    before = {
        "system": "a = 1", "record": 5, "longest": 80, "changed_parameters": "",
        "follow": ["longest"],
    }  # fmt: skip
    Store.open(tmp_path / "s", before, 3).close()
    Store.open(tmp_path / "s", before | {"follow": []}, 3).close()  # given, and the same
    with pytest.raises(OptionError) as refused:
        Store.open(tmp_path / "s", before | now, 4 if "record" in now else 3)
    lines = [line.split(":")[0].strip() for line in str(refused.value).splitlines()[1:-1]]
    assert lines == told


def test_a_call_names_the_options_that_it_was_given(tmp_path):
    options = {"transient": 20, "record": 5, "store": tmp_path / "s"}
    ns.bifurcation_diagram(ns.models.soft_impact(), "omega", [0.8], **options)
    with pytest.raises(OptionError, match="other options:\n  transient: 20 then, 30 now\nrepeat"):
        ns.bifurcation_diagram(
            ns.models.soft_impact(), "omega", [0.8], **options | {"transient": 30}
        )


def test_options_that_are_given_are_told_together(tmp_path):
    Store.open(tmp_path / "s", {"record": 5, "longest": 80}, 3).close()
    with pytest.raises(OptionError, match="record: 5 then, 6 now\n  longest: 80 then, 90 now"):
        Store.open(tmp_path / "s", {"record": 6, "longest": 90}, 3)


def test_a_store_of_another_call_is_refused_as_such(tmp_path):
    """Options of two calls are not held beside each other; former stores do not name theirs."""
    path = tmp_path / "s"
    Store.open(path, {"call": "ensemble", "initial": 1}, 3).close()
    with pytest.raises(OptionError, match="another kind of call") as refused:
        Store.open(path, {"call": "waterfall", "values": 2}, 4)
    assert "results of ensemble, not of waterfall; give another" in str(refused.value)
    assert "then" not in str(refused.value)
    with pytest.raises(OptionError, match="other options:\n  initial: 1 then, 2 now\nrepeat"):
        Store.open(path, {"call": "ensemble", "initial": 2}, 3)
    Store.open(tmp_path / "former", {"initial": 1}, 3).close()
    Store.open(tmp_path / "former", {"call": "ensemble", "initial": 1}, 3).close()


@pytest.mark.parametrize("damage", ["cut", "flip", "empty"])
def test_damaged_chunks_are_told_and_not_done(tmp_path, damage):
    with Store.open(tmp_path / "s", {}, 4) as store:
        for i in range(3):
            store.put(i, ARRAYS)
    path = tmp_path / "s" / "000001.npz"
    content = bytearray(path.read_bytes())
    content[200] ^= 1
    path.write_bytes({"cut": content[:-1], "flip": content, "empty": b""}[damage])
    with pytest.warns(ResultWarning, match=r"damaged .* computed again: 000001\.npz"):
        store = Store.open(tmp_path / "s", {}, 4)
    with store:
        assert store.done == {0, 2}
        store.put(1, ARRAYS)
        path.unlink()
        with pytest.raises(RunError, match=r"000001\.npz was damaged on the way"):
            store.get(1)


def test_drafts_of_a_killed_process_are_cleared(tmp_path):
    with Store.open(tmp_path / "s", {}, 1):
        pass
    for name in (".000000.77.npz", ".protocol.77.json", ".result.77.nc"):
        (tmp_path / "s" / name).write_bytes(b"half")
    (tmp_path / "s" / "notes.txt").write_text("mine")
    with Store.open(tmp_path / "s", {}, 1) as store:
        assert store.done == set()
    assert {p.name for p in (tmp_path / "s").iterdir()} == {"lock", "notes.txt", "protocol.json"}


def test_places_that_are_no_store(tmp_path):
    (tmp_path / "file").write_text("x")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("x")
    (tmp_path / "odd").mkdir()
    (tmp_path / "odd" / "protocol.json").write_text("[1, 2")
    for name, message in (
        ("file", "is a file"),
        ("file/s", "is a file, or lies in one"),
        ("no/s", "make it first"),
        ("mine", "not empty: it holds 'thesis.tex'"),
        ("odd", "none that this version can read"),
    ):
        with pytest.raises(OptionError, match=message):
            Store.open(tmp_path / name, {}, 1)
    with pytest.raises(OptionError, match="give the path of a folder"):
        Store.open(3, {}, 1)
    assert [p.name for p in (tmp_path / "mine").iterdir()] == ["thesis.tex"]


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="a folder that Linux has")
def test_a_folder_that_takes_no_others():
    with pytest.raises(OptionError, match="no folder can be made in '/proc'"):
        Store.open("/proc/s", {}, 1)


HOLD = """
import sys
from nonsmooth.runs.store import Store
store = Store.open(sys.argv[1], {}, 2)
print("held", flush=True)
sys.stdin.read()
"""


def test_two_processes_refuse_each_other(tmp_path):
    folder = tmp_path / "s"
    other = subprocess.Popen(
        [sys.executable, "-c", HOLD, folder], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    try:
        assert other.stdout.readline() == b"held\n"
        with pytest.raises(OptionError, match=f"in use by process {other.pid}"):
            Store.open(folder, {}, 2)
    finally:
        other.kill()  # what it leaves behind locks nobody out
        other.communicate()
    assert (folder / "lock").read_text() == str(other.pid)
    with Store.open(folder, {}, 2) as store:
        store.put(0, ARRAYS)
        with pytest.raises(OptionError, match=f"in use by process {os.getpid()}"):
            Store.open(folder, {}, 2)
    with Store.open(folder, {}, 2) as store:
        assert store.done == {0}


@pytest.mark.parametrize(
    ("code", "kind", "message"),
    [
        (errno.ENOSPC, RunError, "make room and repeat the same call"),
        (errno.EDQUOT, RunError, "make room and repeat the same call"),
        (errno.EIO, RunError, "repeat the same call"),
        (errno.EROFS, OptionError, "in which files may be made"),
        (errno.EACCES, OptionError, "in which files may be made"),
    ],
)
def test_what_cannot_be_written_leaves_what_was(tmp_path, monkeypatch, code, kind, message):
    whole = Path.write_bytes

    def half(path, content):
        whole(path, bytes(content)[: len(content) // 2])
        raise OSError(code, os.strerror(code))

    with Store.open(tmp_path / "s", {}, 3) as store:
        store.put(0, ARRAYS)
        with monkeypatch.context() as patch:
            patch.setattr(Path, "write_bytes", half)
            with pytest.raises(kind, match=message) as told:
                store.put(1, ARRAYS)
        assert "000001.npz could not be written" in str(told.value)
        assert store.done == {0}
    assert {p.name for p in (tmp_path / "s").iterdir()} == {"000000.npz", "lock", "protocol.json"}
    with Store.open(tmp_path / "s", {}, 3) as store:
        assert store.done == {0}


def tasks(count, began):
    def task(i):
        def run(worker, stop):
            began.append(i)
            return i * i

        return run

    return [task(i) for i in range(count)]


@pytest.mark.parametrize("threads", [1, 3])
def test_done_tasks_are_left_out(threads):
    began, kept = [], {}
    assert run_tasks(
        tasks(100, began), object, threads=threads, label="x", keep=kept.__setitem__,
        done=set(range(0, 100, 2)),
    )  # fmt: skip
    assert sorted(began) == list(range(1, 100, 2))
    assert kept == {i: i * i for i in range(1, 100, 2)}


def test_results_that_nobody_takes_do_not_pile_up():
    """The memory of long work: workers wait where what they found is not written yet."""
    began, most = [], []

    def keep(i, result):
        most.append(len(began) - len(most))
        threading.Event().wait(0.002)

    assert run_tasks(tasks(200, began), object, threads=2, label="x", keep=keep)
    assert len(most) == 200
    assert max(most) <= 20


def test_stored_tasks_run_once(tmp_path):
    def work(count, found, began, stop_at=None):
        def keep(i, result):
            first_time = i not in found
            found[i] = result
            if i == stop_at and first_time:
                raise KeyboardInterrupt

        return run_stored_tasks(
            tasks(count, began), object, store=tmp_path / "s", protocol={"a": 1}, threads=1,
            label="x", keep=keep, pack=lambda value: {"value": np.array(value)},
            unpack=lambda arrays: int(arrays["value"]),
        )  # fmt: skip

    first, found, second, again = [], {}, [], {}
    assert not work(50, found, first, stop_at=5)
    assert 6 <= len(found) < 50
    assert work(50, again, second)
    assert again == {i: i * i for i in range(50)}
    assert sorted(second) == [i for i in range(50) if i not in found]


def test_who_shares_a_store_does_not_wait_for_others_that_read_it(tmp_path, monkeypatch):
    """What is there may be large; the lock is for the protocol alone."""
    with Store.open(tmp_path / "s", {}, 2, shared=True) as store:
        store.put(0, ARRAYS)
    original, inside = Store._find, []

    def find(self, n_tasks):
        monkeypatch.setattr(Store, "_find", original)
        inside.append(Store.open(tmp_path / "s", {}, 2, shared=True))
        original(self, n_tasks)

    monkeypatch.setattr(Store, "_find", find)
    assert Store.open(tmp_path / "s", {}, 2, shared=True).done == inside[0].done == {0}


def test_a_finished_store_is_read_where_nothing_may_be_written(tmp_path, monkeypatch):
    with Store.open(tmp_path / "s", {}, 2, shared=True) as store:
        store.put(0, ARRAYS)
        store.put(1, ARRAYS)

    def refuse(*_):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr("nonsmooth.runs.store.lock", refuse)
    found = Store.open(tmp_path / "s", {}, 2, shared=True)
    assert found.read_only and found.done == {0, 1} and same(ARRAYS, found.get(1))
    (tmp_path / "s" / "000001.npz").unlink()
    with pytest.raises(OptionError, match="in which files may be made"):
        Store.open(tmp_path / "s", {}, 2, shared=True)
    with pytest.raises(OptionError, match="in which files may be made"):
        Store.open(tmp_path / "new", {}, 2, shared=True)


def test_a_protocol_that_appears_while_the_folder_is_read_is_no_stranger(tmp_path, monkeypatch):
    """Two processes begin at once: one writes it between two looks of the other."""
    whole, looks = Path.iterdir, []

    def late(path):
        if path.name == "s" and not looks:
            looks.append(path)
            with Store.open(tmp_path / "s", {}, 2, shared=True) as first:
                first.put(0, ARRAYS)
        return whole(path)

    monkeypatch.setattr(Path, "iterdir", late)
    assert Store.open(tmp_path / "s", {}, 2, shared=True).done == {0}


def test_strange_entries_are_told(tmp_path):
    with Store.open(tmp_path / "s", {}, 2, shared=True):
        pass
    (tmp_path / "s" / "000000.npz").mkdir()
    with pytest.warns(ResultWarning, match=r"damaged files.*000000\.npz"):
        Store.open(tmp_path / "s", {}, 2, shared=True)
    (tmp_path / "s" / "000000.npz").rmdir()
    (tmp_path / "s" / "claims").rmdir()
    (tmp_path / "s" / "claims").write_text("mine")
    with pytest.raises(RunError, match="File exists"):
        Store.open(tmp_path / "s", {}, 2, shared=True)
