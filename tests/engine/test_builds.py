"""The builds of the engine: of the sources beside them, and with the same digits as each other."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import nonsmooth
from engine.native_shim import build_engine
from nonsmooth.engine.library import engine, ffi

TESTS = Path(__file__).parents[1]
V3 = build_engine.library("v3", build_engine.PLATFORMS[""])


def run_with(build, *arguments):
    """A process of Python with the engine of a build."""
    paths = [str(Path(nonsmooth.__file__).parents[1]), str(TESTS)]
    environment = os.environ | {
        "NONSMOOTH_ENGINE": build,
        "PYTHONPATH": os.pathsep.join(paths),
    }
    return subprocess.run(
        [sys.executable, *arguments], env=environment, capture_output=True, text=True
    )


def test_the_engine_is_compiled_from_its_sources():
    compiled = ffi.string(engine.nonsmooth_sources()).decode()
    assert compiled == build_engine.sources_hash(), (
        "the engine is older than its sources, or newer: run `make engine`"
    )


@pytest.mark.skipif(
    not (V3.exists() and engine.nonsmooth_runs_v3()),
    reason="this processor runs the build `baseline` only",
)
def test_both_builds_give_the_same_digits():
    """A result must not depend on the processor: neither contraction nor another order of sums."""
    found = {}
    for build in ("baseline", "v3"):
        run = run_with(build, "-m", "engine.digits")
        assert run.returncode == 0, run.stderr
        found[build] = json.loads(run.stdout)
        assert f"_nonsmooth_{build}." in found[build]["library"]
    assert found["v3"]["digits"] == found["baseline"]["digits"]


def test_a_build_that_is_not_known():
    run = run_with("fastest", "-c", "import nonsmooth.engine.library")
    assert run.returncode == 1
    last = run.stderr.splitlines()[-1]
    assert last.startswith("ImportError: NONSMOOTH_ENGINE is 'fastest'; it may be 'baseline', 'v3'")
