"""Processes that make the same call with the same folder share its tasks, whoever is killed."""

import subprocess
import sys
import time

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from effort import HANG
from nonsmooth.runs.store import Store

BEGIN = "import os, sys, numpy as np, nonsmooth as ns\nsystem = ns.models.soft_impact()\n"
GRID = "{'omega': np.linspace(0.7, 0.9, 16), 'zeta': np.linspace(0.01, 0.05, 12)}"
WORK = {
    "ensemble": (
        "ns.ensemble(system, {'x': np.linspace(-1, 1, 3000)}, transient=300, record=2,"
        " threads=1, store=STORE)"
    ),
    "diagram": (
        "ns.bifurcation_diagram(system, 'omega', np.linspace(0.6, 0.9, 300), transient=300,"
        " record=20, threads=1, store=STORE)"
    ),
    "chain": (
        "ns.bifurcation_diagram(system, 'omega', np.linspace(0.6, 0.9, 300), transient=300,"
        " record=20, start='follow up', threads=1, store=STORE)"
    ),
    "basins": (
        "ns.basins_of_attraction(ns.StroboscopicMap(system), {'x': np.linspace(-1, 1, 60),"
        " 'v': np.linspace(-1, 1, 60)}, threads=1, store=STORE)"
    ),
    "refined map": (
        f"ns.regime_map(system, {GRID}, refine=1, transient=60, record=20, evidence=40,"
        " confirm=0, longest=120, threads=1, store=STORE)"
    ),
}
# tells which tasks this process has written
TELLING = """
from nonsmooth.runs.store import Store

def put(self, i, arrays, original=Store.put):
    original(self, i, arrays)
    print(self.folder.name, i, flush=True)

Store.put = put
"""


def here(verb, store):
    """The dataset of the work, done in this process."""
    return eval(WORK[verb], {"ns": ns, "np": np, "system": ns.models.soft_impact(), "STORE": store})


def begin(verb, store):
    """The work in a process of its own."""
    code = f"{BEGIN}{TELLING}\nSTORE = {str(store)!r}\n{WORK[verb]}.load().to_netcdf(sys.argv[1])"
    target = store.with_name(f"{time.monotonic_ns()}.nc")
    work = subprocess.Popen(
        [sys.executable, "-c", code, target],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    work.target = target
    return work


@pytest.mark.parametrize("verb", WORK)
@pytest.mark.slow
def test_two_processes_do_each_task_once(verb, tmp_path):
    crew = [begin(verb, tmp_path / "shared") for _ in range(2)]
    told = [each.communicate(timeout=HANG) for each in crew]
    assert [(each.returncode, error) for each, (_, error) in zip(crew, told, strict=True)] == [
        (0, "")
    ] * 2
    did = [set(said.split("\n")) - {""} for said, _ in told]
    assert not did[0] & did[1]
    alone = here(verb, tmp_path / "alone")
    assert len(did[0] | did[1]) == len(list((tmp_path / "alone").rglob("[0-9]*.npz")))
    for each in crew:
        with xr.open_dataset(each.target, decode_times=False) as found:
            xr.testing.assert_equal(found, alone)
    assert not list((tmp_path / "shared" / "claims").iterdir())
    assert not list((tmp_path / "shared" / "workers").iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("verb", ["ensemble", pytest.param("chain", marks=pytest.mark.slow)])
def test_what_a_killed_process_had_begun_is_done_by_another(verb, tmp_path):
    """The claims of a process of this machine end with it; the other waits for nothing."""
    store = tmp_path / "shared"
    killed = begin(verb, store)
    assert killed.stdout.readline()  # it has done a task, and is at the next one
    killed.kill()
    killed.communicate(timeout=HANG)
    done = set(store.glob("[0-9]*.npz"))
    result = here(verb, store)
    xr.testing.assert_equal(result.load(), here(verb, tmp_path / "alone").load())
    assert done < set(store.glob("[0-9]*.npz"))
    assert not list((store / "claims").iterdir())


@pytest.mark.slow
def test_a_process_that_stands_still_is_waited_for(tmp_path):
    """A claim of a living worker is not taken, and its task is read when it is there."""
    store = tmp_path / "shared"
    whole = here("diagram", store)
    missing = store / "000003.npz"
    content = missing.read_bytes()
    missing.unlink()
    code = (
        "import sys, time\nfrom pathlib import Path\nfrom nonsmooth.runs.claims import Claims\n"
        "store = Path(sys.argv[1])\n"
        "with Claims(store) as claims:\n"
        "    assert claims.take('000003')\n"
        "    print('taken', flush=True)\n"
        "    sys.stdin.buffer.readline()\n"
        "    (store / 'draft').write_bytes(sys.stdin.buffer.read())\n"
        "    (store / 'draft').rename(store / '000003.npz')\n"
        "    claims.release('000003')\n"
    )
    other = subprocess.Popen(
        [sys.executable, "-c", code, store], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert other.stdout.readline() == b"taken\n"
    waiting = begin("diagram", store)
    with pytest.raises(subprocess.TimeoutExpired):
        waiting.wait(8.0)  # it would take a fraction of that
    other.stdin.write(b"go\n" + content)
    other.stdin.close()
    assert other.wait(HANG) == 0
    other.stdout.close()
    said, error = waiting.communicate(timeout=HANG)
    assert (waiting.returncode, said, error) == (0, "", "")
    with xr.open_dataset(waiting.target, decode_times=False) as found:
        xr.testing.assert_equal(found, whole)


@pytest.mark.slow
def test_other_options_are_refused_while_work_is_under_way(tmp_path):
    work = begin("ensemble", tmp_path / "shared")
    assert work.stdout.readline()
    try:
        with pytest.raises(ns.OptionError, match="holds results of ensemble, not of bifurcation"):
            here("diagram", tmp_path / "shared")
    finally:
        work.kill()
        work.communicate(timeout=HANG)


FEW = "transient=1, record=2, threads=1, store=STORE"
CALLS = {
    "ensemble": f"ns.ensemble(system, {{'x': [0.0]}}, {FEW})",
    "bifurcation_diagram": f"ns.bifurcation_diagram(system, 'omega', [0.8], {FEW})",
    "waterfall": f"ns.waterfall(system, 'omega', [0.8], 'x', {FEW})",
    "contact_statistics": f"ns.contact_statistics(system, 'omega', [0.8], {FEW})",
    "regime_map": (
        "ns.regime_map(system, {'omega': [0.8, 0.9], 'zeta': [0.1, 0.2]}, threads=1, store=STORE)"
    ),
    "basins_of_attraction": (
        "ns.basins_of_attraction(ns.StroboscopicMap(system), {'x': np.linspace(-1, 1, 3), 'v':"
        " np.linspace(-1, 1, 3)}, record=40, threads=1, store=STORE)"
    ),
    "bifurcation_picture": (
        "ns.bifurcation_picture(system, 'omega', (0.8, 0.9), {'x': (-1, 1), 'v': (-1, 1)},"
        " store=STORE)"
    ),
    "cluster.run_calls": (
        "ns.cluster.run_calls(ns.simulate, [{'periods': 1}], system=system, store=STORE)"
    ),
}


@pytest.mark.parametrize("name", CALLS)
def test_the_folder_of_another_call_is_no_store_of_other_options(name, tmp_path):
    with Store.open(tmp_path / "s", {"call": "posterior", "walkers": 8}, 4):
        pass
    with pytest.raises(ns.OptionError, match="another kind of call") as refused:
        eval(CALLS[name], {"ns": ns, "np": np, "system": ns.models.soft_impact(),
                           "STORE": tmp_path / "s"})  # fmt: skip
    assert str(refused.value).endswith(f"results of posterior, not of {name}; give another folder")
