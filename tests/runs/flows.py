"""Tests that run a linear system twice: by its closed form, and by Taylor series."""

import pytest

from contract.taylor_twin import taylor_twin

on_both_flows = pytest.mark.parametrize(
    "flow", [lambda system: system, taylor_twin], ids=["exact", "Taylor"]
)
EPS = 2.0**-52


def crossings(run):
    """The event log of a run without the start."""
    return run.isel(event=run["event_kind"].values != "start")


def summary(run):
    """Name and kind of all events, and whether each is certified."""
    log = crossings(run)
    columns = ("event_name", "event_kind", "certified")
    return list(zip(*(log[name].values.tolist() for name in columns), strict=True))
