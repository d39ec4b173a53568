"""How well threads run side by side here and now: a loop that only counts, and its efficiency.

Two processors may be two halves of one core, and other programs may want them too. What two
threads of pure arithmetic lose to that, no program can gain back.
"""

import os
from concurrent.futures import ThreadPoolExecutor
from time import perf_counter, process_time

from hand_kernels.spin import spin

TURNS = 50_000_000  # a fifth of a second


def spread(work, count, threads):
    """Do work(0) ... work(count - 1) on some threads."""
    if threads == 1:
        for i in range(count):
            work(i)
        return
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(work, range(count)))


def timed(run):
    """(wall, processor) time of a call, and what it gives."""
    wall, processor = perf_counter(), process_time()
    result = run()
    return (perf_counter() - wall, process_time() - processor), result


class Clocks:
    """Best times over rounds, by name: wall time and processor time of all threads."""

    def __init__(self):
        self.wall, self.processor = {}, {}

    def time(self, name, run):
        (wall, processor), result = timed(run)
        self.wall[name] = min(wall, self.wall.get(name, wall))
        self.processor[name] = min(processor, self.processor.get(name, processor))
        return result

    def spin(self):
        for threads in (1, 2):
            self.time(("spin", threads), lambda n=threads: spread(lambda _: spin(TURNS, 0.1), 2, n))

    def efficiency(self, name):
        """Wall time with one thread over twice that with two."""
        return self.wall[name, 1] / (2.0 * self.wall[name, 2])

    def report(self, names):
        load = ", ".join(f"{each:.1f}" for each in os.getloadavg())
        lines = [f"load of the machine over 1, 5 and 15 minutes: {load} on {os.cpu_count()}"]
        alone = self.efficiency("spin")
        lines.append(f"two threads, counting loop: efficiency {alone:.2f}")
        for name in names:
            found = self.efficiency(name)
            lines.append(
                f"two threads, {name}: efficiency {found:.2f}, of the loop's {found / alone:.2f};"
                f" processor time {self.processor[name, 2] / self.processor[name, 1]:.2f} of that"
                " on one"
            )
        return "\n".join(lines)
