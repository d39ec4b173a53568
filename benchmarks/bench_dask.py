"""A large map of regimes on a Dask cluster of which everything fails once, and workers often.

python benchmarks/bench_dask.py FOLDER [--points N] [--tile N] [--every SECONDS]

N times N points of the soft impact oscillator, few periods each, on two workers of Dask. One of
them is killed every few seconds, the scheduler once, and once the disk is filled: FOLDER lies on a
file system of its own with at most 4 GB, such as a tmpfs. The same map is computed without faults.
The command fails when the two differ in a bit, more than 2 % of the tiles were written twice, or a
process took 1 GB.
"""

import argparse
import os
import random
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import psutil
from bench_cluster import FEW, LOOK, MOST_MEMORY, MOST_TWICE, SYSTEM, written

import nonsmooth as ns

LARGEST = 4e9  # bytes of a file system that is filled
FULL_FOR = 10.0  # seconds
DRIVE = """
import sys
from distributed import Client
import nonsmooth as ns
with Client(sys.argv[1], timeout=30) as client:
    ns.cluster.work(sys.argv[2], client=client)
"""


class Cluster:
    """A scheduler, two workers, and the process that asks them; each may be killed."""

    def __init__(self, store):
        self.store = store
        self.restarts = 0
        self.begin()

    def begin(self):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        port = self.address.rpartition(":")[2]
        self.scheduler = self.start(
            "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", port,
            "--no-dashboard",
        )  # fmt: skip
        self.workers = [self.worker(), self.worker()]
        self.driver = self.start("-c", DRIVE, self.address, str(self.store))

    def worker(self):
        return self.start(
            "-m", "distributed.cli.dask_worker", self.address, "--nthreads", "1", "--no-nanny",
            "--no-dashboard", "--local-directory", os.environ.get("TMPDIR", "/tmp"),
        )  # fmt: skip

    def start(self, *words):
        return psutil.Popen(
            [sys.executable, *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )

    def all(self):
        return [self.scheduler, *self.workers, self.driver]

    def end(self):
        for each in self.all():
            if each.poll() is None:
                each.kill()
            each.wait()

    def restart(self):
        self.end()
        self.restarts += 1
        self.begin()


def fill(folder):
    """Take all the room that is left."""
    path = folder / "filler"
    with path.open("wb") as file:
        size = shutil.disk_usage(folder).free
        while size > 4096:
            try:
                os.posix_fallocate(file.fileno(), file.seek(0, 2), size)
                file.seek(0, 2)
            except OSError:
                size //= 2
    return path


def until_done(store, every):
    """Work until the map is done; what was killed, tiles written twice, largest memory."""
    chance, cluster = random.Random(0), Cluster(store)
    marks, twice, kills, memory = {}, 0, 0, 0
    tiles = int(ns.cluster.progress(store)["tiles"])
    ahead = {"scheduler": tiles // 3, "disk": 2 * tiles // 3}  # what fails, and after how many
    filler, filled = None, 0.0
    looked = killed = time.monotonic()
    while cluster.driver.poll() != 0:
        time.sleep(LOOK)
        for each in cluster.all():
            try:
                memory = max(memory, each.memory_info().rss)
            except psutil.Error:  # it has just ended
                continue
        now = time.monotonic()
        if now - looked > 1.0:
            seen = written(store)
            twice += sum(marks[name] != at for name, at in seen.items() if name in marks)
            marks, looked = seen, now
            if len(marks) > ahead.get("scheduler", tiles):
                del ahead["scheduler"]
                cluster.scheduler.kill()
                print(f"scheduler killed after {len(marks)} tiles", flush=True)
                time.sleep(2.0)
                cluster.restart()
            if len(marks) > ahead.get("disk", tiles):
                del ahead["disk"]
                filler, filled = fill(store.parent), now
                print(f"disk filled after {len(marks)} tiles", flush=True)
        if filler is not None and now - filled > FULL_FOR:
            filler.unlink()
            filler = None
        if filler is None and cluster.driver.poll() not in (None, 0):
            cluster.restart()
        if now - killed > chance.uniform(0.5, 1.5) * every:
            k = chance.randrange(2)
            cluster.workers[k].kill()
            cluster.workers[k].wait()
            cluster.workers[k] = cluster.worker()
            kills, killed = kills + 1, now
    cluster.end()
    assert not ahead, f"did not fail: {ahead}"
    return kills, cluster.restarts, twice, memory


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--points", type=int, default=2048)
    parser.add_argument("--tile", type=int, default=64)
    parser.add_argument("--every", type=float, default=5.0)
    given = parser.parse_args()
    if shutil.disk_usage(given.folder).total > LARGEST:
        parser.error(f"{given.folder}: its file system is too large to be filled")
    store, quiet = given.folder / "map.zarr", given.folder / "without-faults.zarr"
    over = {
        "omega": np.linspace(0.7, 1.0, given.points),
        "a": np.linspace(0.4, 1.0, given.points),
    }
    for each in (store, quiet):
        ns.cluster.plan_map(each, SYSTEM, over, tile=given.tile, **FEW)
    began = time.perf_counter()
    ns.cluster.work(quiet, threads=2)
    alone = time.perf_counter() - began
    began = time.perf_counter()
    kills, restarts, twice, memory = until_done(store, given.every)
    took = time.perf_counter() - began
    job = ns.cluster.progress(store)
    one, other = ns.cluster.open_map(store), ns.cluster.open_map(quiet)
    for name in one.data_vars:
        values, expected = one[name].values, other[name].values
        same = np.array_equal(values, expected, equal_nan=values.dtype.kind == "f")
        assert same, f"{name} differs"
    tiles = int(job["tiles"])
    print(f"{given.points} x {given.points} points, {tiles} tiles, {kills} workers killed")
    print(f"time                 {took:.0f} s; in two threads without faults {alone:.0f} s")
    print(f"clusters begun anew  {restarts}")
    print(f"tiles written twice  {twice}, {100.0 * twice / tiles:.2g} %")
    print(f"memory of a process  {memory / 1e6:.0f} MB at most")
    print("both maps are equal, bit for bit")
    assert twice <= MOST_TWICE * tiles and memory < MOST_MEMORY


if __name__ == "__main__":
    main()
