"""Ctrl-C at every instant at which a verb says how far it is: what was computed is kept."""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.exponents import exponent_run, horizon
from nonsmooth.engine.status import Status
from nonsmooth.progress import Progress
from nonsmooth.runs import strobe_runner
from nonsmooth.runs.clock import Instant

lyapunov_module = import_module("nonsmooth.analysis.lyapunov_spectrum")

CHAOTIC = ns.models.soft_impact(omega=0.905)
MAP = ns.StroboscopicMap(ns.models.soft_impact())
GRID = {name: np.linspace(-1.0, 1.0, 12) for name in ("x", "v")}
SET_UP = {"first look at starts", "simulating"}  # nothing is known of any motion yet
VERBS = {
    "lyapunov_spectrum": lambda: ns.lyapunov_spectrum(CHAOTIC, transient=64, record=256),
    "attractors": lambda: ns.attractors(MAP, {"x": (-1, 1), "v": (-1, 1)}, samples=20, record=100),
    "basins_of_attraction": lambda: ns.basins_of_attraction(MAP, GRID, samples=4, record=100),
    "poincare_section": lambda: ns.poincare_section(CHAOTIC, section="v", record=300),
    "bifurcation_diagram": lambda: ns.bifurcation_diagram(
        CHAOTIC, "omega", np.linspace(0.8, 0.9, 40)
    ),
    "continue_orbit": lambda: ns.continue_orbit(
        ns.models.duffing(gamma=0.2), "gamma", (0.1, 0.3), steps=4
    ),
    "orbits": lambda: ns.orbits(ns.models.soft_impact(), guesses=3, samples=2, record=20),
}


@pytest.fixture
def interrupts(monkeypatch):
    """Let Ctrl-C come with one of the updates of progress bars; tells how many there were."""
    seen = []

    def begin(at):
        seen.clear()

        def update(bar, done):
            seen.append(bar.label)
            if len(seen) == at:
                raise KeyboardInterrupt

        monkeypatch.setattr(Progress, "update", update)
        return seen

    return begin


@pytest.mark.few(2)
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("verb", VERBS)
def test_what_was_computed_is_kept_whenever_ctrl_c_comes(verb, interrupts):
    seen = interrupts(0)
    VERBS[verb]()
    count = len(seen)
    for at in sorted({1, 2, 3, count // 2, count - 1, count} & set(range(1, count + 1))):
        seen = interrupts(at)
        try:
            found = VERBS[verb]()
        except KeyboardInterrupt:
            first_point = (seen[at - 1], at) == ("following", 1)
            assert first_point or seen[at - 1] in SET_UP, f"lost at {seen[at - 1]!r}, {at}/{count}"
        else:
            if len(seen) < at:  # bars of tasks are updated by the clock too
                continue
            assert found.attrs["status"] == "interrupted", f"{seen[at - 1]!r}, {at} of {count}"
            assert "interrupted" in found.attrs["message"]


def test_exponents_of_a_record_outlast_ctrl_c_in_what_confirms_them(monkeypatch):
    """The record is done when the motion is run on, and so are its exponents."""
    whole = ns.lyapunov_spectrum(CHAOTIC, transient=64, record=256, confirm=0)

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(horizon, "_run_on", interrupted)
    with pytest.warns(ns.RunWarning, match="what was computed is kept"):
        found = ns.lyapunov_spectrum(CHAOTIC, transient=64, record=256)
    assert found.attrs["status"] == "interrupted"
    assert np.array_equal(found["lyapunov_exponent"], whole["lyapunov_exponent"])
    assert found.attrs["chaotic_for"] == whole.attrs["chaotic_for"]


def test_ctrl_c_in_the_later_record_is_told(monkeypatch):
    records = []

    def run(*given):
        records.append(exponent_run.run_exponents(*given))
        early = len(records) == 2
        return replace(records[-1], status=Status.INTERRUPTED) if early else records[-1]

    monkeypatch.setattr(lyapunov_module, "run_exponents", run)
    with pytest.warns(ns.RunWarning, match="what was computed is kept"):
        found = ns.lyapunov_spectrum(CHAOTIC, transient=64, record=256, confirm=100)
    assert len(records) == 2 and found.attrs["status"] == "interrupted"


def test_a_long_record_begins_at_once(monkeypatch):
    """Of five million intervals those are made that are run: Ctrl-C finds something to keep."""
    made = []

    class Counted(Instant):
        def __new__(cls, *given):
            made.append(given)
            return super().__new__(cls, *given)

    def update(bar, done):
        if done >= 256:
            raise KeyboardInterrupt

    monkeypatch.setattr(exponent_run, "Instant", Counted)
    monkeypatch.setattr(Progress, "update", update)
    with pytest.warns(ns.RunWarning, match="what was computed is kept"):
        found = ns.lyapunov_spectrum(CHAOTIC, transient=64, record=5e6)
    assert found.sizes["time"] == 192 and len(made) <= 1000
    assert np.isfinite(found["lyapunov_exponent"]).all()


def test_ctrl_c_while_a_cycle_is_refined_is_no_end_of_its_motion(monkeypatch):
    """The runs of Newton's method keep nothing, and pass it on to the search, which ends."""
    given = []
    real = strobe_runner.run_plan

    def run_plan(*given_to, **how):
        outcome = real(*given_to, **how)
        given.append(outcome)
        return replace(outcome, status=Status.INTERRUPTED) if len(given) == 1 else outcome

    monkeypatch.setattr(strobe_runner, "run_plan", run_plan)
    found = ns.attractors(MAP, {"x": (-1, 1), "v": (-1, 1)}, samples=20, record=100)
    assert len(given) == 1
    assert found.attrs["status"] == "interrupted"
