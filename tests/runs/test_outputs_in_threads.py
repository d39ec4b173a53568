"""Outputs are worked out in the threads that run motions, which share what a system means."""

import sys
import threading

import numpy as np

import nonsmooth as ns
from nonsmooth.runs.outputs import SweptClock, output_values

CHAIN = 12  # definitions that need each other, so that reading the output takes a while


def system(number):
    """A system that nobody has read before, as its parameter has a name of its own."""
    definitions = {"d0": f"k{number}*x"}
    definitions |= {f"d{i}": f"d{i - 1} + {i}*x" for i in range(1, CHAIN)}
    return ns.System(
        states=["x"],
        parameters={f"k{number}": 2.0},
        equations={"x": "-x"},
        definitions=definitions,
        outputs={"force": f"d{CHAIN - 1}"},
        period=1.0,
    )


def test_threads_that_read_an_output_at_the_same_time_agree():
    """Force = (2 + 1 + 2 + ... + 11) x, whoever is the first to find out."""
    before, threads = sys.getswitchinterval(), 6
    faults, values = [], []

    def work(one, barrier):
        clock = SweptClock(np.zeros(3, np.int64), np.zeros(3), np.ones(3), {})
        barrier.wait()
        try:
            states = np.array([[1.0, 2.0, 3.0]])
            values.append(output_values(one, clock, states, np.zeros(3, np.int64))["force"])
        except Exception as fault:
            faults.append(fault)

    sys.setswitchinterval(1e-6)
    try:
        for number in range(30):
            barrier, one = threading.Barrier(threads), system(number)
            crew = [threading.Thread(target=work, args=(one, barrier)) for _ in range(threads)]
            for thread in crew:
                thread.start()
            for thread in crew:
                thread.join()
    finally:
        sys.setswitchinterval(before)
    assert faults == []
    np.testing.assert_array_equal(values, np.tile([68.0, 136.0, 204.0], (30 * threads, 1)))
