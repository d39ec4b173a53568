"""A run of tests that fails says at its end what failed, for those who see the end alone."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

CONFTEST = Path(__file__).parents[1] / "conftest.py"
TESTS = """
import pytest

@pytest.fixture
def broken():
    raise ValueError

def test_right():
    pass

@pytest.mark.parametrize("x", [1, 2])
def test_wrong(x):
    assert x == 1, "for\\nthis reason"

def test_unready(broken):
    pass

@pytest.mark.skip(reason="told above")
def test_left_out():
    pass

@pytest.mark.xfail(reason="likewise")
def test_known():
    assert False
"""


@pytest.mark.slow
def test_names_of_failed_tests_are_the_last_lines(tmp_path):
    """Below totals, and below the reasons of tests that were left out."""
    shutil.copy(CONFTEST, tmp_path)
    (tmp_path / "test_some.py").write_text(TESTS)
    command = [sys.executable, "-m", "pytest", "-ra", "--numprocesses=1"]
    run = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert run.returncode == 1, run.stdout + run.stderr
    *_, totals, wrong, unready = run.stdout.splitlines()
    assert "1 failed, 2 passed, 1 skipped, 1 xfailed, 1 error" in totals
    assert wrong == "FAILED test_some.py::test_wrong[2]"
    assert unready == "FAILED test_some.py::test_unready"
