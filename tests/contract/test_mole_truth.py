"""The mole against a 50-digit route that shares no code with the package.

Tolerances: states to 1e-11 times the growth of the tangent (the error of each operation,
some 1e-15, carried along by the motion), times to that over the rate of the guard.
"""

import json
from pathlib import Path

import numpy as np
import pytest

import nonsmooth as ns

RUNS = json.loads((Path(__file__).parents[1] / "reference" / "mole_runs.json").read_text())
STATES = ["p", "y", "q", "v"]


def run_like(truth):
    period = float(truth["period"])
    phase = truth["start_phase"] / truth["parameters"]["omega"]
    return (
        ns.simulate(
            ns.models.moling(**truth["parameters"]),
            truth["initial"],
            periods=truth["n_periods"],
            t_start=phase,
            samples_per_period=1,
        ),
        phase,
        period,
    )


@pytest.mark.parametrize("name", RUNS)
def test_states_at_strobes(name):
    truth = RUNS[name]
    run, _, _ = run_like(truth)
    assert run.attrs["status"] == "completed"
    expected = np.array([[float(s[k]) for k in STATES] for s in truth["strobes"]])
    found = np.stack([run[k].values for k in STATES], axis=1)[1:]
    scale = max(1.0, truth["tangent_growth"]["worst"])
    size = np.maximum(1.0, np.abs(expected))
    assert np.max(np.abs(found - expected) / size) < 1e-11 * scale


@pytest.mark.parametrize("name", RUNS)
def test_events(name):
    truth = RUNS[name]
    run, phase, _ = run_like(truth)
    names = run["event_to"].attrs["flag_meanings"].split()
    crossings = run.isel(event=run["event_kind"].values != "start")
    sequence = [
        (names[a], names[b])
        for a, b in zip(crossings["event_from"].values, crossings["event_to"].values, strict=True)
    ]
    assert sequence == [(e["from"], e["to"]) for e in truth["events"]]
    scale = max(1.0, truth["tangent_growth"]["worst"])
    for k, event in enumerate(truth["events"]):
        rate = abs(float(event["guard_rate"]))
        error = abs(float(crossings["event_time"][k]) - phase - float(event["t"]))
        assert error < 1e-11 * scale * max(1.0, 1.0 / rate), k
    assert bool(crossings["certified"].all())
