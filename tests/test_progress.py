"""What takes long shows on a terminal that it is under way: from Python as from the shell."""

import threading
import time

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import progress
from nonsmooth.progress import Progress
from nonsmooth.runs import crew

STRUCK = ns.models.soft_impact()
SLOPING = ns.System(
    states=["x", "v"],
    parameters={"mu": 0.6, "omega": 0.5},
    period="2*pi/omega",
    equations={"x": "v", "v": "cos(omega*t) - x - mu*sign(v)"},
)
REGION = {"x": (-1.0, 1.0), "v": (-1.0, 1.0)}
FEW = {"samples": 2, "record": 20}
LONG = {
    "simulate": lambda: ns.simulate(STRUCK, periods=20_000),
    "stroboscopic_map": lambda: ns.stroboscopic_map(STRUCK, record=20_000),
    "poincare_section": lambda: ns.poincare_section(STRUCK, section="v", record=50),
    "bifurcation_diagram": lambda: ns.bifurcation_diagram(STRUCK, "omega", [0.8, 0.9]),
    "ensemble": lambda: ns.ensemble(STRUCK, {"x": [0.0, 0.1]}, record=20),
    "lyapunov_spectrum": lambda: ns.lyapunov_spectrum(STRUCK, transient=5, record=10, confirm=0),
    "regime": lambda: ns.regime(STRUCK),
    "regime_map": lambda: ns.regime_map(STRUCK, {"omega": [0.8], "a": [0.6]}),
    "waterfall": lambda: ns.waterfall(STRUCK, "omega", [0.8], variable="x", record=4),
    "contact_statistics": lambda: ns.contact_statistics(STRUCK, record=5),
    "find_orbit": lambda: ns.find_orbit(STRUCK, transient=20_000),
    "continue_orbit": lambda: ns.continue_orbit(
        ns.models.duffing(gamma=0.2), "gamma", (0.1, 0.3), steps=2
    ),
    "attractors": lambda: ns.attractors(ns.StroboscopicMap(STRUCK), REGION, **FEW),
    "basins_of_attraction": lambda: ns.basins_of_attraction(
        ns.StroboscopicMap(STRUCK), {name: np.linspace(-1.0, 1.0, 3) for name in REGION}, **FEW
    ),
    "orbits": lambda: ns.orbits(STRUCK, guesses=2, **FEW),
    "return_map": lambda: ns.return_map(ns.PoincareMap(STRUCK, "v"), "x", (0.0, 1.0), samples=3),
    "life_by_cycle": lambda: ns.fatigue.life_by_cycle(
        lambda load, crack: load * np.sqrt(np.pi * crack * 1e-3),
        ns.fatigue.Paris(C=1e-8, m=4.0),
        ns.fatigue.LoadBlock.constant_amplitude(100.0, 100.0, frequency=20.0),
        initial=2.0,
        final=10.0,
    ),
    "smoothing_report": lambda: ns.smoothing_report(SLOPING, (0.1, 0.01), periods=400, samples=200),
}


@pytest.fixture
def told(monkeypatch):
    """What bars are told, from the first moment on."""
    found = []
    monkeypatch.setattr(crew, "_ATTENTION", 1e-4)
    monkeypatch.setattr(Progress, "update", lambda bar, done: found.append((bar.label, done)))
    return found


@pytest.mark.few(4)
@pytest.mark.filterwarnings("ignore::nonsmooth.ResultWarning")
@pytest.mark.parametrize("verb", LONG)
def test_a_verb_that_may_take_long_says_so(verb, told):
    LONG[verb]()
    assert told


def test_a_first_task_that_takes_long_is_seen(monkeypatch):
    shown = []

    def work(worker, stop):
        assert done.wait(10.0)

    done = threading.Event()
    monkeypatch.setattr(Progress, "update", lambda bar, count: (shown.append(count), done.set()))
    assert crew.run_tasks(
        [work], lambda: None, threads=1, label="work", keep=lambda i, result: None
    )
    assert shown[0] == 0


def test_the_bar_of_one_task_does_not_claim_a_share(monkeypatch):
    monkeypatch.setattr(progress, "_PATIENCE", 0.0)
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    for total, known in ((1, None), (7, 7)):
        with Progress("work", total) as bar:
            bar.update(0)
            time.sleep(0.01)
            assert bar._bar.tasks[0].total == known


def test_the_bar_of_a_growing_crack_comes_to_its_end(monkeypatch):
    told = []
    monkeypatch.setattr(Progress, "update", lambda bar, done: told.append(done / bar.total))
    LONG["life_by_cycle"]()
    assert np.all(np.diff(told) > 0.0) and 0.0 < told[0] < 0.2 and 0.5 < told[-1] < 1.0
