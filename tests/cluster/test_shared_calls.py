"""One call on many workers, and many calls: results of one process, whatever happens on the way."""

import os
import subprocess
import sys
import threading
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth import OptionError, ResultWarning, RunError

SYSTEM = ns.models.soft_impact()
OVER = np.linspace(0.6, 0.9, 40)
MANY = np.linspace(0.6, 0.9, 1500)  # a task has some hundred of such columns
SHORT = {"transient": 50, "record": 10}


def test_threads_of_a_pool_share_a_diagram(tmp_path):
    with ThreadPoolExecutor(2) as pool:
        found = ns.cluster.distribute(
            ns.bifurcation_diagram, SYSTEM, "omega", MANY,
            executor=pool, store=tmp_path / "s", **SHORT,
        )  # fmt: skip
    xr.testing.assert_identical(found, ns.bifurcation_diagram(SYSTEM, "omega", MANY, **SHORT))
    job = ns.cluster.progress(tmp_path / "s")
    assert int(job["tasks"]) > 1
    assert job.attrs["message"] == f"all {int(job['tasks'])} tasks are done"
    assert int(job["claimed"]) == 0 and float(job["time_left"]) == 0.0


def test_threads_need_not_import_dask_at_once():
    """xarray does so where it is installed, and one of two threads would find half a module."""
    code = "import sys, nonsmooth.runs.labels; print('dask.base' in sys.modules)"
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert told.stdout.split() == ["True"]


@pytest.mark.slow
def test_processes_of_a_pool_share_an_ensemble(tmp_path):
    starts = {"x": np.linspace(-1.0, 1.0, 500)}
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        found = ns.cluster.distribute(
            ns.ensemble, SYSTEM, starts, executor=pool, calls=2, store=tmp_path / "s", **SHORT
        )
    xr.testing.assert_identical(found.load(), ns.ensemble(SYSTEM, starts, **SHORT))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Port:UserWarning")  # the dashboard takes another port
def test_a_dask_cluster_whose_workers_are_killed(tmp_path):
    """One is killed each two seconds; the map with its refined borders is that of one process."""
    distributed = pytest.importorskip("distributed", reason="it belongs to the extra")
    over = {"omega": np.linspace(0.7, 1.0, 24), "a": np.linspace(0.4, 1.0, 16)}
    how = {"refine": 1, "evidence": 200, "confirm": 500}
    end, kills = threading.Event(), []

    def kill(client):
        while not end.wait(2.0):
            processes = list(client.run(os.getpid).values())
            if len(processes) == 2 and len(kills) < 6:
                os.kill(processes[len(kills) % 2], 9)
                kills.append(processes)

    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as machines,
        distributed.Client(machines) as client,
    ):
        killer = threading.Thread(target=kill, args=(client,), daemon=True)
        killer.start()
        found = ns.cluster.distribute(
            ns.regime_map, SYSTEM, over, client=client, store=tmp_path / "s", **how
        )
        end.set()
        killer.join()
    assert len(kills) >= 2
    xr.testing.assert_identical(found, ns.regime_map(SYSTEM, over, **how))


def test_what_distribute_refuses(tmp_path):
    call = (ns.bifurcation_diagram, SYSTEM, "omega", OVER)
    with pytest.raises(OptionError, match="store= is missing"):
        ns.cluster.distribute(*call, executor=ThreadPoolExecutor(1))
    with pytest.raises(OptionError, match="give executor= or client="):
        ns.cluster.distribute(*call, store=tmp_path / "s")
    with pytest.raises(OptionError, match="give an Executor of concurrent"):
        ns.cluster.distribute(*call, store=tmp_path / "s", executor=3)
    with ThreadPoolExecutor(1) as pool:
        with pytest.raises(OptionError, match="'omegas'"):  # as the call itself does
            ns.cluster.distribute(
                ns.bifurcation_diagram, SYSTEM, "omegas", OVER, store=tmp_path / "s", executor=pool
            )
        with pytest.raises(OptionError, match="calls = 0"):
            ns.cluster.distribute(*call, store=tmp_path / "s", executor=pool, calls=0)
    with pytest.raises(RunError, match="ended before the work did"):
        ns.cluster.distribute(*call, store=tmp_path / "s", executor=pool)
    with pytest.raises(OptionError, match=r"simulate has no store=; call it through run_calls"):
        ns.cluster.distribute(ns.simulate, SYSTEM, store=tmp_path / "s", executor=pool)


def die(store):
    """End the process as the killer of a machine without memory does."""
    os.kill(os.getpid(), 9)


@pytest.mark.slow
def test_a_pool_that_is_broken_is_told(tmp_path):
    with (
        ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool,
        pytest.raises(RunError, match=r"ended before the work did.*give a new executor"),
    ):
        ns.cluster.distribute(die, executor=pool, calls=1, store=tmp_path / "s")


# ---------------------------------------------------------------- many calls


def exponents(system, omega, calls=None, fail=(), **_):
    """A call that notes that it was made, and fails where it is told to."""
    if calls is not None:
        calls.append(omega)
    if omega in fail:
        raise ValueError(f"no luck at {omega}")
    return xr.Dataset({"twice": 2.0 * omega}, attrs={"system": system.name})


def test_many_calls_are_made_once(tmp_path):
    store, made = tmp_path / "s", []
    calls = [{"omega": omega} for omega in (0.5, 0.25, 2.0)]

    def noted(system, omega):
        return exponents(system, omega, made)

    noted.__qualname__ = "noted"
    for _ in range(2):
        found = ns.cluster.run_calls(noted, calls, system=SYSTEM, store=store)
        assert [float(each["twice"]) for each in found] == [1.0, 0.5, 4.0]
        assert made == [0.5, 0.25, 2.0]
    others = [calls[0], {"omega": 0.75}, calls[2]]
    with pytest.raises(OptionError, match=r"calls\[1\].*0.25 then, 0.75 now"):
        ns.cluster.run_calls(noted, others, system=SYSTEM, store=store)
    other = SYSTEM.with_parameters(zeta=0.02)
    with pytest.raises(OptionError, match=r"zeta = 0.01 then, zeta = 0.02 now"):
        ns.cluster.run_calls(noted, calls, system=other, store=store)


def test_calls_that_fail_are_told_and_made_again_when_asked(tmp_path):
    calls, fail = [{"omega": omega} for omega in (1.0, 2.0, 3.0)], [2.0]

    def unlucky(omega):
        return exponents(SYSTEM, omega, fail=fail)

    for _ in range(2):
        with pytest.warns(
            ResultWarning, match=r"1 of 3 calls .* call 1 \(ValueError: no luck at 2"
        ):
            found = ns.cluster.run_calls(unlucky, calls, store=tmp_path / "s")
        assert [each is None for each in found] == [False, True, False]
        fail.clear()
    found = ns.cluster.run_calls(unlucky, calls, store=tmp_path / "s", retry=True)
    assert [float(each["twice"]) for each in found] == [2.0, 4.0, 6.0]


def test_an_interruption_keeps_what_is_done(tmp_path):
    made = []

    def stopped(omega):
        made.append(omega)
        if len(made) == 2:
            raise KeyboardInterrupt
        found = exponents(SYSTEM, omega)
        return found.assign_attrs(status="interrupted") if len(made) == 4 else found

    calls = [{"omega": omega} for omega in (1.0, 2.0, 3.0)]
    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            ns.cluster.run_calls(stopped, calls, store=tmp_path / "s")
    found = ns.cluster.run_calls(stopped, calls, store=tmp_path / "s")
    assert made == [1.0, 2.0, 2.0, 3.0, 3.0]
    assert [float(each["twice"]) for each in found] == [2.0, 4.0, 6.0]


def test_what_calls_are_refused(tmp_path):
    one = {"system": SYSTEM}
    for calls, options, message in (
        ([], {}, "give a list of mappings"),
        ("abc", {}, "give a list of mappings"),
        ([{"omega": 1.0}, 3], one, r"calls\[1\] = 3 is no mapping"),
        ([{"omega": 1.0}], {"omega": 2.0}, "'omega' is given for all calls too"),
        ([{"omega": threading.Lock()}], one, "cannot be told from other values"),
        ([{"omega": 1.0}, {}], one, r"calls\[1\]: missing .*'omega'"),
    ):
        with pytest.raises(OptionError, match=message):
            ns.cluster.run_calls(exponents, calls, store=tmp_path / "s", **options)
    with pytest.raises(OptionError, match="give a function"):
        ns.cluster.run_calls(3, [{}], store=tmp_path / "s")


@pytest.mark.slow
def test_fits_of_many_records_on_a_pool(tmp_path):
    """Stiffness and damping of an oscillator from three records, whose truth is known."""
    oscillator = ns.System(
        states=["x", "v"], parameters={"k": 1.0, "c": 0.1},
        equations={"x": "v", "v": "-k*x - c*v"},
    )  # fmt: skip
    times, noise = np.linspace(0.0, 20.0, 400), np.random.default_rng(0)
    truth = [0.8, 1.1, 1.4]
    records = []
    for k in truth:
        rate = np.sqrt(k - 0.05**2)
        x = np.exp(-0.05 * times) * (np.cos(rate * times) + 0.05 / rate * np.sin(rate * times))
        records.append(xr.Dataset({"x": ("time", x + 0.01 * noise.normal(size=400))},
                                  {"time": times}))  # fmt: skip
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        fits = ns.cluster.distribute(
            ns.cluster.run_calls, ns.fit, [{"record": each} for each in records],
            system=oscillator, free={"k": (0.5, 2.0), "c": (0.01, 0.3)}, observe={"x": "x"},
            starts=1, executor=pool, calls=2, store=tmp_path / "fits",
        )  # fmt: skip
    for fitted, k in zip(fits, truth, strict=True):
        found = fitted.sel(parameter="k")
        assert abs(float(found["estimate"]) - k) < 4.0 * float(found["standard_error"])
