"""First runs of an installation: nothing is compiled, and a missing engine is told as such."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import nonsmooth as ns

# x falls from 2 at unit speed: event after 2, guard rate -1
CODE = """
from nonsmooth import Exit, Mode, System, simulate
fall = System(states=["x"], modes={"m": Mode({"x": "-1"}, exits=[Exit("x", to="stop")])})
run = simulate(fall, {"x": 2.0}, t_end=5.0)
print(float(run["event_phase"][-1]), float(run["guard_rate"][-1]))
"""


@pytest.fixture
def engine(tmp_path):
    """Engine of a copy of the package."""
    package = tmp_path / "nonsmooth"
    shutil.copytree(
        Path(ns.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__", "native")
    )
    return package / "engine"


def run(engine):
    """A process that knows of this copy only."""
    kept = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "NONSMOOTH"))}
    own = {"PYTHONPATH": str(engine.parents[1]), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-c", CODE]
    return subprocess.run(command, env=kept | own, cwd=engine, capture_output=True, text=True)


@pytest.mark.slow
def test_a_first_run_is_right_and_silent_and_writes_nothing(engine):
    files = set(engine.parents[1].rglob("*"))
    first = run(engine)
    assert (first.returncode, first.stdout, first.stderr) == (0, "2.0 -1.0\n", "")
    assert set(engine.parents[1].rglob("*")) == files


@pytest.mark.parametrize("part", ["_declarations.py", "_nonsmooth_baseline.*"])
def test_a_part_that_is_missing(engine, part):
    (path,) = engine.glob(part)
    path.unlink()
    assert "make engine" in fault(engine)


def test_a_library_of_another_machine(engine):
    for path in engine.glob("_nonsmooth_*"):
        path.write_text("no machine code")
    assert "cannot be loaded" in fault(engine)


def fault(engine):
    """Last line that a process writes which cannot load its engine."""
    failed = run(engine)
    assert failed.returncode == 1
    last = failed.stderr.splitlines()[-1]
    assert last.startswith("ImportError: the engine of nonsmooth")
    return last
