"""Many processes at one map: killed at random, of a pool, of a Dask cluster."""

import os
import random
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

import nonsmooth as ns
from cluster.test_maps_in_tiles import assert_same
from nonsmooth.cluster.tile_store import TileStore

pytestmark = pytest.mark.slow
SHORT = {"transient": 40, "record": 20, "evidence": 20, "confirm": 0, "longest": 80}
SYSTEM = ns.models.soft_impact(zeta=0.03)


def over(count):
    return {"omega": np.linspace(0.7, 1.0, count), "a": np.linspace(0.4, 1.0, count)}


def begin(store, *more):
    """A worker as a shell starts it, on one thread."""
    command = [sys.executable, "-m", "nonsmooth", "work", str(store), "--threads", "1", *more]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def written(store):
    """When each tile was marked as done, by the name of its file."""
    marks = (store / "tiles" / "seconds" / "c").glob("[0-9]*/[0-9]*")
    return {str(mark): mark.stat().st_mtime_ns for mark in marks if mark.name.isdecimal()}


def test_workers_that_are_killed_lose_no_digit(tmp_path):
    """Two workers at once, one of which is killed every second at a random moment."""
    store, chance = tmp_path / "map.zarr", random.Random(1)
    ns.cluster.plan_map(store, SYSTEM, over(128), tile=16, **SHORT)
    crew, kills = [begin(store), begin(store)], 0
    marks, twice = written(store), 0
    while any(each.poll() is None for each in crew):
        time.sleep(chance.uniform(0.2, 1.5) if kills < 12 else 0.5)
        now = written(store)
        twice += sum(marks[name] != at for name, at in now.items() if name in marks)
        assert set(marks) <= set(now), "a tile that was done is not any more"
        marks = now
        if kills < 12 and len(now) > 2 * kills:
            k = chance.randrange(2)
            crew[k].kill()
            crew[k].communicate()
            crew[k] = begin(store)
            kills += 1
    assert [(each.returncode, each.communicate()[1]) for each in crew] == [(0, b"")] * 2
    assert kills >= 5 and len(marks) == 64
    assert twice == 0  # claims of killed processes of this machine end at once, others hold
    assert_same(store, ns.regime_map(SYSTEM, over(128), **SHORT))
    opened = TileStore.open(store)
    assert [opened.damaged(opened.at(number)) for number in range(64)] == [""] * 64
    assert not list((store / "tiles" / "claims").iterdir())


def test_parts_of_a_job_array(tmp_path):
    """Each part looks after its own tiles."""
    store = tmp_path / "map.zarr"
    ns.cluster.plan_map(store, SYSTEM, over(24), tile=8, **SHORT)
    crew = [begin(store, "--part", f"{k}/2") for k in (1, 2)]
    assert [each.wait() for each in crew] == [0, 0]
    for each in crew:
        each.communicate()
    assert_same(store, ns.regime_map(SYSTEM, over(24), **SHORT))


@pytest.mark.skipif(os.name != "posix", reason="job scripts are scripts of a POSIX shell")
def test_the_job_script_of_the_page_ends_in_order_when_its_shell_is_interrupted(tmp_path):
    """``#SBATCH --signal=B:INT`` is for the shell that runs the script, and nobody else."""
    page = Path(__file__).parents[2] / "docs" / "how-to" / "larger-than-one-machine.md"
    blocks = re.findall(r"```bash\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    (script,) = [each for each in blocks if "nonsmooth work" in each]
    (tmp_path / "job.sh").write_text(script, encoding="utf-8")
    store = tmp_path / "map.zarr"
    ns.cluster.plan_map(store, SYSTEM, over(96), tile=8, **SHORT)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    words = {"SCRATCH": str(tmp_path), "SLURM_CPUS_PER_TASK": "1", "PATH": path}
    job = subprocess.Popen(
        ["bash", tmp_path / "job.sh"], stdout=subprocess.DEVNULL, env=os.environ | words,
        start_new_session=True,
    )  # fmt: skip
    while not written(store) and job.poll() is None:
        time.sleep(0.05)
    job.send_signal(signal.SIGINT)
    assert job.wait() == 130
    assert 0 < len(written(store)) < 144


def test_a_pool_of_processes(tmp_path):
    store = tmp_path / "map.zarr"
    ns.cluster.plan_map(store, SYSTEM, over(24), tile=8, **SHORT)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        job = ns.cluster.work(store, executor=pool)
    assert job.attrs["status"] == "completed"
    assert_same(store, ns.regime_map(SYSTEM, over(24), **SHORT))


def suicide():
    """End the process of a pool as the killer of a machine without memory does."""
    os.kill(os.getpid(), 9)


def test_a_pool_that_is_broken_is_told(tmp_path):
    store = tmp_path / "map.zarr"
    ns.cluster.plan_map(store, SYSTEM, over(24), tile=4, **SHORT)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        pool.submit(os.kill, os.getpid(), 0).result()  # it has begun
        pool.submit(suicide)
        with pytest.raises(ns.RunError, match=r"ended before the work did.*give a new executor"):
            ns.cluster.work(store, executor=pool)
    ns.cluster.work(store, threads=2)
    assert_same(store, ns.regime_map(SYSTEM, over(24), **SHORT))


@pytest.mark.filterwarnings("ignore:Port:UserWarning")  # the dashboard takes another port
def test_a_dask_cluster_of_which_a_worker_is_killed(tmp_path):
    """Dask begins the tile anew elsewhere; the state of the job is not in its scheduler."""
    distributed = pytest.importorskip("distributed", reason="it belongs to the extra")
    store = tmp_path / "map.zarr"
    ns.cluster.plan_map(store, SYSTEM, over(32), tile=4, **SHORT)
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        process = client.run(os.getpid)
        ns.cluster.work(store, client=client, max_seconds=1.0)
        os.kill(next(iter(process.values())), 9)
        job = ns.cluster.work(store, client=client)
    assert job.attrs["status"] == "completed"
    assert_same(store, ns.regime_map(SYSTEM, over(32), **SHORT))


def test_memory_does_not_grow_with_the_map(tmp_path):
    """A worker holds one tile for each thread, whatever the size of the map."""
    psutil = pytest.importorskip("psutil", reason="it reads the memory of processes")
    sizes = []
    for count in (32, 96):
        store = tmp_path / f"{count}.zarr"
        ns.cluster.plan_map(store, SYSTEM, over(count), tile=32, **SHORT)
        worker, most = begin(store), 0
        process = psutil.Process(worker.pid)
        while worker.poll() is None:
            try:
                most = max(most, process.memory_info().rss)
            except psutil.Error:  # it has just ended
                break
            time.sleep(0.05)
        worker.communicate()
        assert worker.returncode == 0
        sizes.append(most)
    assert max(sizes) < 1e9
    # nine times as many points; verdicts of the additional ones would take 8 MB
    assert sizes[1] - sizes[0] < 5e6


@pytest.mark.parametrize(
    ("system", "grid", "more"),
    [
        (SYSTEM, over(96), {"evidence": 100, "confirm": 400}),
        (
            ns.models.duffing(),
            {"omega": np.linspace(0.8, 1.6, 40), "gamma": np.linspace(0.1, 0.5, 40)},
            {"transient": 60, "record": 20, "evidence": 40, "confirm": 100, "longest": 120},
        ),
        (
            ns.models.impact_oscillator(),
            {"omega": np.linspace(0.6, 3.0, 80), "r": np.linspace(0.3, 0.9, 60)},
            {"transient": 100, "record": 40, "evidence": 60, "confirm": 300},
        ),
    ],
    ids=["soft impact", "Duffing, by Taylor series", "impact oscillator"],
)
def test_a_forecast_is_right_within_thirty_percent(tmp_path, system, grid, more):
    """Of the time in the threads of `work`; what else runs on the machine may change, so once more.

    Both times are told by the same clock, one after the other.
    """
    ratios = []
    for attempt in range(3):
        store = tmp_path / f"map-{attempt}.zarr"
        ns.cluster.plan_map(store, system, grid, tile=16, **more)
        told = ns.cluster.forecast(store, sample=160, threads=1, seed=attempt)
        job = ns.cluster.work(store, threads=1)
        ratios.append(float(told["seconds"]) / float(job["tile_seconds"] * job["tiles"]))
        if 0.7 < ratios[-1] < 1.3:
            return
    raise AssertionError(f"forecast over truth: {ratios}")
