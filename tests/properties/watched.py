"""Seeds judged in a process of their own, so that a hang or a crash has a seed."""

from __future__ import annotations

import multiprocessing
import signal
import sys
from collections.abc import Iterable, Iterator
from multiprocessing.connection import Connection

from properties.cases import Verdict, judge

PATIENCE = 180.0  # seconds of the processor for one seed
_WAITING = 10.0  # times that by the clock, on a machine that does other things too


def _work(seeds: list[int], found: Connection, path: list[str], patience: float) -> None:
    sys.path[:] = path
    judge(0)  # what is loaded first is no part of a seed
    for seed in seeds:
        signal.setitimer(signal.ITIMER_PROF, patience)  # ends the process, whatever it is in
        found.send(judge(seed))
    found.close()


def verdicts(seeds: Iterable[int], patience: float = PATIENCE) -> Iterator[Verdict]:
    """Verdicts in order; a seed that hangs or ends its process gets one that says so."""
    left, context = list(seeds), multiprocessing.get_context("spawn")
    while left:
        ours, theirs = context.Pipe(duplex=False)
        arguments = (left, theirs, sys.path, patience)
        worker = context.Process(target=_work, args=arguments, daemon=True)
        worker.start()
        theirs.close()
        try:
            while left:
                if not ours.poll(_WAITING * patience):
                    yield _hang(left.pop(0), patience)
                    break
                yield ours.recv()
                left.pop(0)
        except EOFError:
            worker.join()
            yield _ended(left.pop(0), worker.exitcode, patience)
        finally:
            worker.kill()
            worker.join()
            ours.close()


def _hang(seed: int, patience: float) -> Verdict:
    return Verdict(seed, "hang", complaints=[f"no end in {patience:g} s"])


def _ended(seed: int, code: int | None, patience: float) -> Verdict:
    if code == -signal.SIGPROF:
        return _hang(seed, patience)
    return Verdict(seed, "crash", complaints=[f"the process ended by itself: {code}"])
