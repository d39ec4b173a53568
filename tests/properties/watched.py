"""Seeds judged in a process of their own, so that a hang or a crash has a seed."""

from __future__ import annotations

import multiprocessing
import sys
from collections.abc import Iterable, Iterator
from multiprocessing.connection import Connection

from properties.cases import Verdict, judge

PATIENCE = 180.0  # seconds of the clock for one seed, on a machine that does other things too
_START = 300.0  # until the first verdict: imports and kernels


def _work(seeds: list[int], found: Connection, path: list[str]) -> None:
    sys.path[:] = path
    for seed in seeds:
        found.send(judge(seed))
    found.close()


def verdicts(seeds: Iterable[int], patience: float = PATIENCE) -> Iterator[Verdict]:
    """Verdicts in order; a seed that hangs or ends its process gets one that says so."""
    left, context = list(seeds), multiprocessing.get_context("spawn")
    while left:
        ours, theirs = context.Pipe(duplex=False)
        worker = context.Process(target=_work, args=(left, theirs, sys.path), daemon=True)
        worker.start()
        theirs.close()
        wait = _START
        try:
            while left:
                if not ours.poll(wait):
                    yield Verdict(left.pop(0), "hang", complaints=[f"no end in {wait:g} s"])
                    break
                yield ours.recv()
                left.pop(0)
                wait = patience
        except EOFError:
            worker.join()
            yield Verdict(
                left.pop(0), "crash", complaints=[f"the process ended by itself: {worker.exitcode}"]
            )
        finally:
            worker.kill()
            worker.join()
            ours.close()
