"""Where many motions run: what is chosen, and results that do not depend on it."""

import sys
import types

import numpy as np
import pytest

import nonsmooth as ns
from engine.device_on_processor import device
from nonsmooth.analysis.basins import by_recurrences
from nonsmooth.analysis.regimes import points
from nonsmooth.runs import devices, lane_runner, sweep_runner

PLANE = {"omega": np.linspace(0.75, 0.95, 5), "a": np.linspace(0.5, 0.9, 4)}
STATES = {"x": np.linspace(-2, 2, 12), "v": np.linspace(-2, 2, 12)}
SHORT = {"transient": 60, "record": 24, "longest": 240, "confirm": 0}


@pytest.fixture(autouse=True)
def restored(monkeypatch):
    """A test leaves the choice as it was."""
    monkeypatch.setattr(devices._Choice, "name", "cpu")


@pytest.fixture
def graphics(monkeypatch):
    """A device that is the processor, and takes few motions too."""
    made = device()
    made.memory.called.clear()
    monkeypatch.setattr(devices, "_graphics", lambda: made)
    for runner in (lane_runner, sweep_runner):
        monkeypatch.setattr(runner, "_LEAST_ON_DEVICE", 1)
    return made


def regimes(**options):
    return ns.regime_map(ns.models.soft_impact(), PLANE, **SHORT, **options)


def basins(**options):
    return ns.basins_of_attraction(ns.models.soft_impact(), STATES, **options)


def same(one, other):
    """Whether two datasets agree in all that they hold, but for how they were made."""
    assert list(one.variables) == list(other.variables)
    for name in one.variables:
        np.testing.assert_array_equal(other[name].values, one[name].values, err_msg=name)


def diagram(**options):
    values = np.linspace(0.7, 0.9, 7)
    return ns.bifurcation_diagram(
        ns.models.soft_impact(), "omega", values, transient=60, record=24, **options
    )


def runs(**options):
    """From many starts at two values of a parameter."""
    starts = {"x": np.linspace(-1.0, 1.0, 40), "v": np.linspace(1.0, -1.0, 40)}
    return ns.ensemble(
        ns.models.soft_impact(), starts, parameters={"omega": [0.75, 0.8]}, transient=5,
        record=6, **options,
    )  # fmt: skip


@pytest.mark.few(1)
@pytest.mark.parametrize("work", [regimes, basins, diagram, runs])
@pytest.mark.parametrize("threads", [1, 2])
def test_results_do_not_depend_on_where_motions_run(graphics, work, threads):
    ours = work(threads=threads)
    assert not graphics.memory.called
    with ns.use_device("gpu"):
        theirs = work(threads=threads)
    kernel = "lanes" if work in (basins, runs) else "sweep"
    assert f"nonsmooth_{kernel}_on_device" in graphics.memory.called
    same(ours, theirs)


def test_a_choice_holds_until_the_end_of_its_block(graphics):
    system = ns.models.soft_impact()
    ns.use_device("cpu")
    with ns.use_device("gpu"):
        assert devices.device_for(system) is graphics
        with ns.use_device("cpu"):
            assert devices.device_for(system) is None
        assert devices.device_for(system) is graphics
    assert devices.device_for(system) is None
    ns.use_device("gpu")
    assert devices.device_for(system) is graphics


@pytest.mark.parametrize(("said", "runs_there"), [("", False), ("cpu", False), ("gpu", True)])
def test_the_environment_chooses(monkeypatch, graphics, said, runs_there):
    monkeypatch.setattr(devices._Choice, "name", "")
    monkeypatch.setenv("NONSMOOTH_DEVICE", said) if said else monkeypatch.delenv(
        "NONSMOOTH_DEVICE", raising=False
    )
    assert (devices.device_for(ns.models.soft_impact()) is graphics) == runs_there


def test_an_unknown_device(monkeypatch):
    with pytest.raises(
        ns.OptionError, match="name = 'gpus': give one of cpu, gpu; did you mean 'gpu'"
    ):
        ns.use_device("gpus")
    monkeypatch.setattr(devices._Choice, "name", "")
    monkeypatch.setenv("NONSMOOTH_DEVICE", "tpu")
    with pytest.raises(ns.OptionError, match="NONSMOOTH_DEVICE = 'tpu': give one of cpu, gpu"):
        regimes()


def test_a_system_that_a_device_cannot_run(graphics):
    """The processor does the work, and says so."""
    system, over = ns.models.duffing(), {"omega": [1.0, 1.1], "gamma": [0.2, 0.3]}
    ours = ns.regime_map(system, over, **SHORT)
    with ns.use_device("gpu"), pytest.warns(ns.ResultWarning, match="a mode of the system is not"):
        theirs = ns.regime_map(system, over, **SHORT)
    same(ours, theirs)
    assert not graphics.memory.called


def fake_cupy(monkeypatch, found):
    """CuPy that finds some devices, or fails to."""

    class CUDARuntimeError(RuntimeError):
        pass

    def count():
        if found is None:
            raise CUDARuntimeError("no driver")
        return found

    runtime = types.SimpleNamespace(getDeviceCount=count, CUDARuntimeError=CUDARuntimeError)
    cupy = types.SimpleNamespace(cuda=types.SimpleNamespace(runtime=runtime))
    monkeypatch.setitem(sys.modules, "cupy", cupy)


@pytest.mark.parametrize("found", [None, 0])
def test_no_device(monkeypatch, found):
    fake_cupy(monkeypatch, found)
    with pytest.raises(ns.OptionError, match=r"no graphics device was found.*use_device\('cpu'\)"):
        ns.use_device("gpu")
    assert devices.device_for(ns.models.soft_impact()) is None


def test_no_cupy(monkeypatch):
    monkeypatch.setitem(sys.modules, "cupy", None)
    with pytest.raises(ns.OptionError, match=r"CuPy.*is not installed.*nonsmooth\[gpu\]"):
        ns.use_device("gpu")


@pytest.mark.few(1)
@pytest.mark.parametrize("work", [regimes, basins, runs])
def test_a_store_is_finished_where_it_was_begun(graphics, tmp_path, monkeypatch, work):
    """Tasks are larger on a device, so the parts of one are not those of the other."""
    with ns.use_device("gpu"):
        first = work(store=tmp_path)
        graphics.memory.called.clear()
        same(first, work(store=tmp_path))
    with pytest.raises(ns.OptionError, match="device: 'gpu' then, not given now"):
        work(store=tmp_path)


def test_tasks_are_larger_on_a_device():
    assert by_recurrences._ON_DEVICE > lane_runner._LEAST_ON_DEVICE > by_recurrences._TOGETHER
    assert points._ON_DEVICE > sweep_runner._LEAST_ON_DEVICE > sweep_runner._MOST
