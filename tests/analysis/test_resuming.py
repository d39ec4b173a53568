"""Long work in a folder goes on after it was killed, or after the disk was full."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from effort import HANG

SYSTEM = "import numpy as np, nonsmooth as ns\nsystem = ns.models.soft_impact()\n"
WORK = {
    "ensemble": (
        "ns.ensemble(system, {'x': np.linspace(-1, 1, 2000)}, transient=TRANSIENT, record=3,"
        " store=STORE)"
    ),
    "diagram": (
        "ns.bifurcation_diagram(system, 'omega', np.linspace(0.6, 0.9, 200), transient=TRANSIENT,"
        " record=20, at='impact', store=STORE)"
    ),
}
VERBS = pytest.mark.parametrize("verb", WORK)


def here(verb, store, transient):
    """Dataset of the work, done in this process."""
    names = {"ns": ns, "np": np, "system": ns.models.soft_impact()}
    return eval(WORK[verb], names | {"STORE": store, "TRANSIENT": transient})


def elsewhere(verb, store, transient, before=""):
    """The work in a process of its own."""
    code = f"{SYSTEM}{before}\nSTORE, TRANSIENT = {str(store)!r}, {transient}\n{WORK[verb]}"
    return subprocess.Popen(
        [sys.executable, "-c", code], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL
    )


def chunks(store):
    return {path.name: path.read_bytes() for path in Path(store).glob("[0-9]*.npz")}


# The process ends after three chunks as one that is killed does: nothing is tidied up. The lock
# keeps other threads from writing a fourth chunk meanwhile.
KILLED = """
import os
import threading
from nonsmooth.runs.store import Store

ONE_AT_A_TIME = threading.Lock()

def put(self, i, arrays, original=Store.put):
    with ONE_AT_A_TIME:
        original(self, i, arrays)
        if len(self.done) == 3:
            os._exit(9)

Store.put = put
"""


@pytest.mark.slow
@VERBS
def test_after_a_kill_the_rest_is_done(verb, tmp_path):
    transient = 10
    work = elsewhere(verb, tmp_path / "killed", transient, KILLED)
    told = work.communicate(timeout=HANG)[1].decode()
    assert work.returncode == 9, told
    done = chunks(tmp_path / "killed")
    times = {name: (tmp_path / "killed" / name).stat().st_mtime_ns for name in done}
    assert len(done) == 3
    assert not (tmp_path / "killed" / "result.nc").exists()

    resumed = here(verb, tmp_path / "killed", transient)
    assert all((tmp_path / "killed" / name).stat().st_mtime_ns == t for name, t in times.items())
    straight = here(verb, tmp_path / "straight", transient)
    assert len(chunks(tmp_path / "straight")) > len(done)
    assert chunks(tmp_path / "killed") == chunks(tmp_path / "straight")
    xr.testing.assert_identical(resumed.load(), straight.load())
    assert resumed.attrs["message"].split(";")[0] == "completed"
    xr.testing.assert_identical(resumed, here(verb, None, transient))
    if verb == "ensemble":
        files = [tmp_path / name / "result.nc" for name in ("killed", "straight")]
        assert files[0].read_bytes() == files[1].read_bytes()


LIMIT = "import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, (BYTES, BYTES))"


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="there are no limits of file size")
@pytest.mark.parametrize(
    ("verb", "size", "file"),
    [
        ("ensemble", 100, r"protocol\.json"),
        ("ensemble", 3000, r"\d{6}\.npz"),
        ("ensemble", 100_000, r"result\.nc"),
        ("diagram", 8000, r"\d{6}\.npz"),
    ],
)
def test_a_file_that_finds_no_room(verb, size, file, tmp_path):
    """What is written with too little room is told in one line, and goes on with enough."""
    store = tmp_path / "s"
    work = elsewhere(verb, store, 10, LIMIT.replace("BYTES", str(size)))
    told = work.communicate(timeout=HANG)[1].decode()
    assert work.returncode == 1, told
    last = told.splitlines()[-1]
    assert last.startswith("nonsmooth.errors.RunError: ")
    assert re.search(f" {file} could not be written: File too large", last)
    assert "make room and repeat the same call" in last
    names = {path.name for path in store.iterdir()}
    assert not any(re.fullmatch(file, name) for name in names)
    assert not any(name.startswith(".") for name in names)
    before = chunks(store)
    result = here(verb, store, 10)
    assert before.items() <= chunks(store).items()
    xr.testing.assert_identical(result.load(), here(verb, None, 10))


@VERBS
def test_damaged_chunks_are_computed_again(verb, tmp_path):
    whole = here(verb, tmp_path / "s", 10)
    right = chunks(tmp_path / "s")
    name = sorted(right)[1]
    (tmp_path / "s" / name).write_bytes(right[name][:-7])
    with pytest.warns(ns.ResultWarning, match=f"computed again: {name} ") as told:
        again = here(verb, tmp_path / "s", 10)
    assert [str(each.filename) for each in told] == ["<string>"]  # the line that asked for it
    assert chunks(tmp_path / "s") == right
    xr.testing.assert_identical(again.load(), whole.load())


@VERBS
def test_other_options_are_refused(verb, tmp_path):
    here(verb, tmp_path / "s", 10)
    with pytest.raises(ns.OptionError, match="transient: 10 then, 11 now"):
        here(verb, tmp_path / "s", 11)


def test_a_diagram_of_a_point_of_a_dataset(tmp_path):
    """Attributes do not tell one point from another; the store does."""
    system = ns.models.soft_impact()
    run = ns.simulate(system, periods=3)
    options = {"transient": 5, "record": 5, "store": tmp_path / "s"}
    ns.bifurcation_diagram(system, "omega", [0.7], initial=run.isel(time=10), **options)
    with pytest.raises(ns.OptionError, match=r"initial_states\[0\]\[0\]"):
        ns.bifurcation_diagram(system, "omega", [0.7], initial=run.isel(time=20), **options)


def test_refused_and_ended_columns_come_back(tmp_path):
    system = ns.System(
        states=["x", "v"],
        parameters={"a": 1.0},
        period="2*pi",
        outputs={"twice": "2*x"},
        require={"a < 5": "the force is small"},
        modes={
            "m": ns.Mode(
                {"x": "v", "v": "-4*x - v + a*cos(t)"}, exits=[ns.Exit("0.5 - x", to="stop")]
            )
        },
    )
    for start in ("restart", "follow down"):
        found = [
            ns.bifurcation_diagram(
                system, "a", [0.5, 3.0, 7.0], initial=[None, {"x": 0.1}], transient=20, record=5,
                start=start, store=store,
            )
            for store in (None, tmp_path / start, tmp_path / start)
        ]  # fmt: skip
        words = ["completed", "stopped", "refused"]
        assert found[0]["status"].values.tolist() == [[word] * 2 for word in words]
        assert found[1].identical(found[0])
        assert found[2].identical(found[0])
