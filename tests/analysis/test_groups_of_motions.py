"""The regime of a motion depends on no other motion that is looked at beside it."""

from __future__ import annotations

import dataclasses
import threading
from functools import partial
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.regimes.labels import Verdict
from nonsmooth.analysis.regimes.map_question import ask_map
from nonsmooth.analysis.regimes.regime_run import first_windows, settled_regimes
from nonsmooth.analysis.settle import ParameterSets, settle
from nonsmooth.runs import sweep_runner
from nonsmooth.runs.sweep_runner import SweepRunner

_PROTOCOL: dict[str, Any] = {
    "transient": 50, "record": 20, "evidence": 60, "confirm": 50, "longest": 100, "phase": 0.0,
    "match": 1e-6, "parameters": None, "tolerance": 1e-12, "mode": None,
}  # fmt: skip


def _pendulum() -> ns.System:
    """It turns over: q is an angle."""
    return ns.System(
        name="pendulum", states=["q", "w"], parameters={"T": 1.0, "m": 0.4}, drift={"q": "2*pi"},
        period="2*pi/1.5", equations={"q": "w", "w": "T*cos(1.5*t) + m - 0.2*w - sin(q)"},
    )  # fmt: skip


def _ending() -> ns.System:
    """Some amplitudes lead to the exit 'stop', in the transient or later."""
    exits = [ns.Exit("1.5 - x", to="stop"), ns.Exit("x + 1.2", reset={"v": "-0.8*v"})]
    rates = {"x": "v", "v": "-x - 0.02*v - 0.3*x**3 + a*cos(w*t)"}
    return ns.System(
        name="ending", states=["x", "v"], parameters={"a": 1.0, "w": 1.0}, period="2*pi/w",
        modes={"m": ns.Mode(rates, exits=exits)},
    )  # fmt: skip


# label by label: chaos and cycles, drift and impacts, tori of a Taylor mode, cycles without
# forcing that stick, chaos without forcing, an angle, early ends, and perturbations that are lost
_MAPS: list[tuple[ns.System, dict[str, tuple[float, float]], Any, Any, set[str]]] = [
    (ns.models.soft_impact(zeta=0.03), {"omega": (0.6, 1.1), "a": (0.4, 1.0)}, None, None,
     {"periodic", "chaotic"}),
    (ns.models.moling(), {"a": (0.1, 1.0), "omega": (0.05, 0.4)}, None, None,
     {"periodic", "chaotic"}),
    (ns.models.belt_oscillator(), {"v_b": (0.05, 0.8), "F_s": (0.45, 1.2)}, "2*pi", None,
     {"limit-cycle"}),
    (ns.models.chua(), {"alpha": (7.0, 10.0), "beta": (13.0, 16.0)}, 2.0, {"x": 0.1},
     {"limit-cycle", "chaotic"}),
    (_pendulum(), {"T": (0.5, 2.5), "m": (0.0, 0.6)}, None, {"q": 0.0, "w": 1.5},
     {"periodic", "chaotic"}),
    (_ending(), {"a": (0.1, 3.0), "w": (0.5, 3.0)}, None, None, {"absorbed"}),
    (ns.models.bouncing_ball(), {"Gamma": (0.9, 6.0), "r": (0.1, 0.9)}, None, None,
     {"locked", "periodic", "chaotic"}),
]  # fmt: skip


def _verdicts(
    system: ns.System, over: dict[str, tuple[float, float]], period: Any, initial: Any
) -> list[Verdict]:
    """Verdicts of five by five points."""
    given = {name: np.linspace(*ends, 5) for name, ends in over.items()}
    question = ask_map("test", system, given, period=period, initial=initial, **_PROTOCOL)
    first, second = np.meshgrid(*question.values)
    values = dict(zip(question.names, (first.ravel(), second.ravel()), strict=True))
    found, _ = settle(
        SweepRunner(system, question.tolerance),
        threading.Event(),
        sets=ParameterSets(question.strobes, values, initial, None),
        times=partial(first_windows, question.protocol),
        reduce=partial(settled_regimes, question.protocol),
    )
    return found


def _numbers(value: Any) -> Any:
    """What a verdict keeps in one field, to be compared to the last digit."""
    if isinstance(value, tuple):  # state and mode at the last strobe
        return [float(each) for part in value for each in np.atleast_1d(part)]
    return value


@pytest.mark.few(4)
@pytest.mark.parametrize("case", _MAPS, ids=[case[0].name for case in _MAPS])
def test_verdicts_of_a_group_are_those_of_each_motion(monkeypatch, case):
    system, over, period, initial, labels = case
    together = _verdicts(system, over, period, initial)
    assert labels <= {verdict.label for verdict in together}
    monkeypatch.setattr(sweep_runner, "_MOST", 1)
    alone = _verdicts(system, over, period, initial)
    for k, (one, other) in enumerate(zip(alone, together, strict=True)):
        for field in dataclasses.fields(Verdict):
            values = (_numbers(getattr(each, field.name)) for each in (one, other))
            np.testing.assert_equal(*values, err_msg=f"point {k}, {field.name}")
