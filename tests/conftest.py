"""What every test shares.

How hypothesis draws, where pictures go, when garbage is collected, what is slow beside tests that
say so, what a failing run ends with.
"""

import gc
import os
import signal
from collections import defaultdict

import pytest
from hypothesis import HealthCheck, settings

# Before anything imports matplotlib: a test machine has no screen.
os.environ["MPLBACKEND"] = "Agg"

# A failure must come back when the same tests run again, so the default run draws the same
# examples each time. No deadline, for an example nor for drawing it: how long they take is no
# property of the program.
UNTIMED = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow]}
settings.register_profile("ci", **UNTIMED, derandomize=True, database=None)
# For looking further than the default run does: HYPOTHESIS_PROFILE=search
settings.register_profile("search", **UNTIMED, max_examples=2000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))


# To collect tests makes millions of objects that stay. Python would look at all of them again and
# again: that took a quarter of collecting, and a tenth of running tests that make many objects.
gc.set_threshold(50_000, 20, 100)


def pytest_collection_finish():
    """Leave what was made so far out of all later looks for garbage."""
    gc.collect()
    gc.freeze()


# Examples of functions that draw or judge figures of the chapter, and that search for a parameter;
# what they call has tests of its own.
LONG_EXAMPLES = {
    "by_cells", "exponent_on_grid", "exponents_of_pairs", "fig10", "fig12", "fig17", "fig21",
    "fig36", "fitted_law", "homoclinic_tangency", "rig_sweeps", "run_chapter",
}  # fmt: skip


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Mark long examples slow, and of tests with many cases all but the few that each run takes."""
    cases = defaultdict(list)
    for item in items:
        if isinstance(item, pytest.DoctestItem) and item.name.rpartition(".")[2] in LONG_EXAMPLES:
            item.add_marker(pytest.mark.slow)
        if item.get_closest_marker("few"):
            cases[item.nodeid.partition("[")[0]].append(item)
    for each in cases.values():
        few = min(each[0].get_closest_marker("few").args[0], len(each))
        taken = {i * len(each) // few for i in range(few)}  # spread over the cases
        for i, item in enumerate(each):
            if i not in taken:
                item.add_marker(pytest.mark.slow)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config):
    """The last lines of a failing run name the tests that failed, below all reasons and totals."""
    reporter = config.pluginmanager.get_plugin("terminalreporter")
    if reporter is None:  # in a process of xdist, which tells the first one
        return
    reports = [each for kind in ("failed", "error") for each in reporter.stats.get(kind, [])]
    for name in dict.fromkeys(each.nodeid for each in reports):
        reporter.write_line(f"FAILED {name}")


@pytest.fixture
def interrupts():
    """Ctrl-C as in a terminal: a shell has programs in its background ignore it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
