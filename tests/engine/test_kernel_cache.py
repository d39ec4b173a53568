"""Machine code on disk is used only for the very kernel sources that it was made of."""

import shutil
import subprocess
import sys
from pathlib import Path

import nonsmooth.engine
from nonsmooth.engine.jit import sources_hash

ENGINE = Path(nonsmooth.engine.__file__).parent

CALLER = """
from nonsmooth.engine.jit import entry
from nonsmooth.engine.helper import twice

@entry
def run(x):
    return twice(x) + 1
"""
HELPER = """
from nonsmooth.engine.jit import kernel

@kernel
def twice(x):
    return {factor} * x
"""


def build_package(folder, factor):
    """A package `nonsmooth` of the real jit module and two tiny kernel files."""
    engine = folder / "nonsmooth" / "engine"
    engine.mkdir(parents=True, exist_ok=True)
    (folder / "nonsmooth" / "__init__.py").touch()
    (engine / "__init__.py").touch()
    shutil.copy(ENGINE / "jit.py", engine / "jit.py")
    (engine / "caller.py").write_text(CALLER)
    (engine / "helper.py").write_text(HELPER.format(factor=factor))
    return engine


def run_package(folder):
    imports = "from nonsmooth.engine.caller import run; from nonsmooth.engine.jit import is_warm"
    code = f"{imports}; print(is_warm(run), run(10))"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=True
    )
    return done.stdout.split()


def test_a_changed_helper_in_another_file_is_seen(tmp_path):
    build_package(tmp_path, 2)
    assert run_package(tmp_path) == ["False", "21"]
    assert run_package(tmp_path) == ["True", "21"]
    # numba alone would go on using the code of the caller's unchanged file and print 21
    build_package(tmp_path, 3)
    assert run_package(tmp_path) == ["False", "31"]
    assert run_package(tmp_path) == ["True", "31"]


def test_hash_covers_every_kernel_file(tmp_path):
    copy = tmp_path / "engine"
    shutil.copytree(ENGINE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    before = sources_hash(copy)
    assert before == sources_hash(ENGINE)
    for path in sorted(copy.glob("*.py")):
        text = path.read_text()
        path.write_text(text + "\n# changed\n")
        assert sources_hash(copy) != before, path.name
        path.write_text(text)
