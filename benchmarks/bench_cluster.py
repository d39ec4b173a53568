"""A large map of regimes in tiles, by two workers of which one is killed every few seconds.

python benchmarks/bench_cluster.py [--points N] [--tile N] [--every SECONDS] [--folder FOLDER]

N times N points of the soft impact oscillator, few periods each. It tells how many tiles were
written twice, the largest memory of a worker, the time, and what the forecast said before. The
command fails when more than 2 % of the tiles were written twice, a worker took 1 GB, a tile is
damaged, or points differ from those of `regime_map` in one process. Without --folder the map is
removed at the end.
"""

import argparse
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil

import nonsmooth as ns
from nonsmooth.cluster.tile_store import TileStore

SYSTEM = ns.models.soft_impact(zeta=0.03)
FEW = {"transient": 30, "record": 10, "evidence": 20, "confirm": 0, "longest": 30}
MOST_TWICE, MOST_MEMORY = 0.02, 1e9
LOOK = 0.1  # seconds between two looks at the workers


def begin(store):
    """A worker of one thread, as a shell starts it."""
    command = [sys.executable, "-m", "nonsmooth", "work", str(store), "--threads", "1"]
    return psutil.Popen(command, stdout=subprocess.DEVNULL)


def written(store):
    """When each tile was marked as done."""
    marks = (store / "tiles" / "seconds" / "c").glob("[0-9]*/[0-9]*")
    return {str(mark): mark.stat().st_mtime_ns for mark in marks if mark.name.isdecimal()}


def until_done(store, every):
    """Work until the map is done; kills, tiles that were written twice, largest memory."""
    chance, crew = random.Random(0), [begin(store), begin(store)]
    marks, twice, kills, memory = {}, 0, 0, 0
    looked = killed = time.monotonic()
    while any(each.poll() is None for each in crew):
        time.sleep(LOOK)
        for each in crew:
            try:
                memory = max(memory, each.memory_info().rss)
            except psutil.Error:  # it has just ended
                continue
        now = time.monotonic()
        if now - looked > 1.0:
            seen = written(store)
            twice += sum(marks[name] != at for name, at in seen.items() if name in marks)
            marks, looked = seen, now
        if now - killed > chance.uniform(0.5, 1.5) * every:
            k = chance.randrange(2)
            if crew[k].poll() is None:
                crew[k].kill()
                crew[k].wait()
                crew[k] = begin(store)
                kills += 1
            killed = now
    assert [each.returncode for each in crew] == [0, 0]
    return kills, twice, memory


def check(store, over):
    """Compare a part of the points, and look at every tile."""
    names = list(over)
    chosen = {name: over[name][:: max(1, over[name].size // 12)] for name in names}
    few = ns.regime_map(SYSTEM, chosen, **FEW)
    grid = ns.cluster.open_map(store).sel(chosen).load()
    for name in few.data_vars:
        values = grid[name].values.astype(object if name == "word" else few[name].dtype)
        assert values.astype(few[name].dtype).tobytes() == few[name].values.tobytes(), name
    opened = TileStore.open(store)
    assert not any(opened.damaged(opened.at(number)) for number in range(opened.count))
    return few["regime"].size


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--points", type=int, default=2048)
    parser.add_argument("--tile", type=int, default=64)
    parser.add_argument("--every", type=float, default=5.0)
    parser.add_argument("--folder", type=Path)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        store = (given.folder or Path(scratch)) / "map.zarr"
        over = {
            "omega": np.linspace(0.7, 1.0, given.points),
            "a": np.linspace(0.4, 1.0, given.points),
        }
        ns.cluster.plan_map(store, SYSTEM, over, tile=given.tile, **FEW)
        told = ns.cluster.forecast(store, threads=2)
        print(told.attrs["message"], flush=True)
        began = time.perf_counter()
        kills, twice, memory = until_done(store, given.every)
        took = time.perf_counter() - began
        compared = check(store, over)
        job = ns.cluster.progress(store)
        size = sum(each.stat().st_size for each in store.rglob("*") if each.is_file())
        tiles = int(job["tiles"])
        print(f"{given.points} x {given.points} points, {tiles} tiles, {kills} workers killed")
        print(f"time                 {took:.0f} s, a tile {float(job['tile_seconds']):.3g} s")
        print(f"forecast             {float(told['seconds']):.0f} s for two threads and no kills")
        print(f"tiles written twice  {twice}, {100.0 * twice / tiles:.2g} %")
        print(f"memory of a worker   {memory / 1e6:.0f} MB at most")
        print(f"store                {size / 1e6:.1f} MB")
        print(f"points compared      {compared}, bit for bit")
        assert twice <= MOST_TWICE * tiles and memory < MOST_MEMORY


if __name__ == "__main__":
    main()
