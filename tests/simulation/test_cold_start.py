"""First runs of an installation: the kernels are compiled, once, and a run says so."""

import shutil
import time
from pathlib import Path

import pytest

import nonsmooth as ns
from engine.installations import Installation, finish, permissions_bind
from nonsmooth.engine.lanes import run_lanes as engine_run

# x falls from 2 at unit speed: event after 2, guard rate -1
CODE = """
from nonsmooth import Exit, Mode, System, simulate
fall = System(states=["x"], modes={"m": Mode({"x": "-1"}, exits=[Exit("x", to="stop")])})
for _ in range(2):
    run = simulate(fall, {"x": 2.0}, t_end=5.0)
print(float(run["event_phase"][-1]), float(run["guard_rate"][-1]))
"""
RIGHT = "2.0 -1.0\n"
SILENT = ""
ANNOUNCED = "nonsmooth: compiling its kernels, once for this installation (some minutes)\n"
EACH_TIME = (
    "nonsmooth: compiling its kernels, for this process alone (some minutes): none of the"
    " folders where numba keeps machine code can be written; set NUMBA_CACHE_DIR to one that can\n"
)


@pytest.fixture
def whole(tmp_path):
    return Installation.whole(tmp_path)


@pytest.fixture
def locked(whole, tmp_path):
    if not permissions_bind(tmp_path / "probe"):
        pytest.skip("this user can write everywhere")
    return whole


def test_machine_code_goes_with_a_copy_of_the_installation(locked):
    # as in an image of a container: built and warmed up by one user, run by another, who can
    # write neither there nor at home
    ns.simulate(ns.models.moling(), periods=1)
    made = Path(engine_run.stats.cache_path)
    shutil.copytree(made, locked.engine / "__pycache__", ignore=shutil.ignore_patterns("*.pyc"))
    with locked.read_only(locked.folder, locked.home):
        assert locked.run(CODE) == (RIGHT, SILENT)


def test_what_is_said_where_nothing_can_be_written(locked):
    announce = """
from nonsmooth.simulation.kernels import announce_compilation
announce_compilation()
announce_compilation()
"""
    assert locked.run(announce) == ("", ANNOUNCED)
    with locked.read_only(locked.folder, locked.home):
        assert locked.run(announce) == ("", EACH_TIME)


@pytest.mark.slow
def test_two_processes_on_an_empty_cache_and_an_upgrade(whole):
    processes = [whole.start(CODE) for _ in range(2)]
    assert [finish(process) for process in processes] == 2 * [(RIGHT, ANNOUNCED)]
    files = set(whole.files())
    assert whole.run(CODE) == (RIGHT, SILENT)
    # A change in a helper: columns of the event log trade places. Python reads them by their
    # names, so old machine code would give the guard rate for the phase.
    records = whole.engine / "records.py"
    text = records.read_text()
    assert "PHASE, GUARD_RATE, WAIT = 0, 1, 2\n" in text
    records.write_text(
        text.replace("PHASE, GUARD_RATE, WAIT = 0, 1, 2\n", "PHASE, GUARD_RATE, WAIT = 1, 0, 2\n")
    )
    assert whole.run(CODE) == (RIGHT, ANNOUNCED)
    assert whole.run(CODE) == (RIGHT, SILENT)
    assert len(whole.files()) == len(files) and not files & set(whole.files())


@pytest.mark.slow
def test_a_process_killed_while_it_compiles_and_a_read_only_installation(locked):
    with locked.read_only(locked.folder):
        process = locked.start(CODE)
        assert process.stderr.readline() == ANNOUNCED
        time.sleep(6.0)
        process.kill()
        process.communicate()
        assert locked.run(CODE) == (RIGHT, ANNOUNCED)
        assert locked.run(CODE) == (RIGHT, SILENT)
    assert all(path.is_relative_to(locked.home) for path in locked.files().values())


@pytest.mark.slow
def test_where_nothing_can_be_written_the_run_is_right(locked):
    with locked.read_only(locked.folder, locked.home):
        assert locked.run(CODE) == (RIGHT, EACH_TIME)
    assert locked.files() == {}
