"""Settings that every test shares: how hypothesis draws, and where pictures go."""

import os
import signal
import sys

import pytest
from hypothesis import settings

# Before anything imports matplotlib: a test machine has no screen.
os.environ["MPLBACKEND"] = "Agg"

# A failure must come back when the same tests run again, so the default run draws the same
# examples each time. No deadline: the first call of a kernel may compile it.
settings.register_profile("ci", derandomize=True, deadline=None, database=None)
# For looking further than the default run does: HYPOTHESIS_PROFILE=search
settings.register_profile("search", deadline=None, max_examples=2000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))


@pytest.fixture
def interrupts():
    """Ctrl-C as in a terminal: a shell has programs in its background ignore it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="session", autouse=True)
def _kernels_compiled_once():
    """One signature for each kernel that Python calls: another one takes minutes to compile."""
    yield
    for module in list(sys.modules.values()):
        if not getattr(module, "__name__", "").startswith("nonsmooth.engine."):
            continue
        for name, kernel in vars(module).items():
            count = len(getattr(kernel, "signatures", ()))
            # those that others call are compiled with them, for arrays of several layouts
            kept = type(getattr(kernel, "_cache", None)).__name__ == "_KernelCache"
            assert count <= 1 or not kept, f"{module.__name__}.{name}: {kernel.signatures}"
