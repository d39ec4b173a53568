"""Who may import whom: the contracts stand in pyproject.toml under ``tool.importlinter``."""

import ast
import subprocess
import sys
from pathlib import Path

from house.tree import ROOT, SOURCE, outline, python_files, relative

ENGINE_MAY_IMPORT = {"numpy"}
ENGINE_MAY_IMPORT_OF_US = ("nonsmooth.engine", "nonsmooth.errors")


def imported(path: Path) -> set[str]:
    """Full names of the modules that a file imports; relative ones are of its own package."""
    names = set()
    for node in outline(path):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            if node.level > 1:
                names.add("nonsmooth")
            elif node.level == 0 and node.module == "nonsmooth":
                names |= {f"nonsmooth.{alias.name}" for alias in node.names}
            elif node.level == 0:
                names.add(node.module)
    return names


def allowed_in_engine(name: str) -> bool:
    """Whether the engine may import this module."""
    top = name.split(".")[0]
    if top == "nonsmooth":
        return any(name == ours or name.startswith(f"{ours}.") for ours in ENGINE_MAY_IMPORT_OF_US)
    return top in ENGINE_MAY_IMPORT or top in sys.stdlib_module_names


def test_import_contracts():
    """A lower layer that imports a higher one can no longer be read, tested or used alone."""
    run = subprocess.run(
        [Path(sys.executable).with_name("lint-imports"), "--no-cache"],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, (
        "an import breaks a contract of pyproject.toml: move the code down, or hand the value in"
        f" as an argument\n{run.stdout}{run.stderr}"
    )


def test_engine_imports():
    """The engine is arrays of numpy and the compiled library, which its declarations load by cffi.

    A contract can only list what is forbidden; this lists what is allowed.
    """
    faults = [
        f"{relative(path)}: {name}"
        for path in python_files()
        if path.is_relative_to(SOURCE / "engine")
        for name in sorted(imported(path))
        if not allowed_in_engine(name)
    ]
    assert not faults, "the engine imports numpy and the standard library only:\n" + (
        "\n".join(faults)
    )
