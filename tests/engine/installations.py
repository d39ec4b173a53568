"""Installations of the package in folders of their own, each with a home for numba's cache."""

import contextlib
import ctypes
import os
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import nonsmooth

PACKAGE = Path(nonsmooth.__file__).parent

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


class Installation:
    """A package `nonsmooth` that processes of a test import, and nothing of this process."""

    def __init__(self, folder):
        self.folder = folder / "installation"
        self.package = self.folder / "nonsmooth"
        self.engine = self.package / "engine"
        self.home = folder / "home"
        self.home.mkdir(parents=True)

    @classmethod
    def whole(cls, folder):
        """The real package without its machine code."""
        self = cls(folder)
        shutil.copytree(PACKAGE, self.package, ignore=shutil.ignore_patterns("__pycache__"))
        return self

    @classmethod
    def tiny(cls, folder):
        """The real `jit` module and two kernels that compile in a fraction of a second."""
        self = cls(folder)
        self.engine.mkdir(parents=True)
        (self.package / "__init__.py").touch()
        (self.engine / "__init__.py").touch()
        shutil.copy(PACKAGE / "engine" / "jit.py", self.engine / "jit.py")
        (self.engine / "caller.py").write_text(CALLER)
        self.multiply_by(2)
        return self

    def multiply_by(self, factor):
        """Another version of the tiny package: `run(10)` gives 10 * factor + 1."""
        (self.engine / "helper.py").write_text(HELPER.format(factor=factor))

    def start(self, code, **environment):
        """A process that can write where permissions let it, whoever the user is."""
        inherited = {k: v for k, v in os.environ.items() if not k.startswith(("NUMBA_", "PYTHON"))}
        own = {
            "HOME": str(self.home),
            "XDG_CACHE_HOME": str(self.home / "cache"),
            "PYTHONPATH": str(self.folder),
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        return subprocess.Popen(
            [sys.executable, "-c", code],
            cwd=self.home,
            env=inherited | own | environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=_bound_by_permissions if os.name == "posix" else None,
        )

    def run(self, code, **environment):
        """What a process prints on stdout and on stderr; it must succeed."""
        return finish(self.start(code, **environment))

    def files(self):
        """Files of machine code, wherever they are, by name."""
        places = (self.folder.parent).rglob("*.nb[ic]*")
        return {path.name: path for path in sorted(places)}

    @contextlib.contextmanager
    def read_only(self, *folders):
        """Folders, and all that is in them, in which nothing can be written for a while."""
        everything = [path for folder in folders for path in (folder, *folder.rglob("*"))]
        try:
            for path in everything:
                path.chmod(path.stat().st_mode & ~(stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH))
            yield
        finally:
            for path in everything:
                path.chmod(path.stat().st_mode | stat.S_IWUSR)


def finish(process):
    """What a process printed on stdout and on stderr; it must have succeeded."""
    out, err = process.communicate()
    assert process.returncode == 0, err
    return out, err


def permissions_bind(folder):
    """Whether such a process is kept out of a read-only folder: not so on every system."""
    installation = Installation(folder)
    with installation.read_only(installation.home):
        name = str(installation.home / "file")
        process = installation.start(f"open({name!r}, 'w')")
        process.communicate()
    return process.returncode != 0


def _bound_by_permissions():
    """Give up the superuser's right to write anywhere (Linux; without effect elsewhere)."""
    drop_from_bounding_set, override, read_search = 24, 1, 2
    with contextlib.suppress(AttributeError, OSError):
        for capability in (override, read_search):
            ctypes.CDLL(None).prctl(drop_from_bounding_set, ctypes.c_ulong(capability), 0, 0, 0)
