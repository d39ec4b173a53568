"""Settings that every test shares: how hypothesis draws, and where pictures go."""

import os
import signal

import pytest
from hypothesis import settings

# Before anything imports matplotlib: a test machine has no screen.
os.environ["MPLBACKEND"] = "Agg"

# A failure must come back when the same tests run again, so the default run draws the same
# examples each time. No deadline: other work on the machine takes time as well.
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
