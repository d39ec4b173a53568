"""The study uses what every user of the library can, and nothing else of it."""

import ast
import inspect
from pathlib import Path

import pytest

import nonsmooth as ns
import nonsmooth_chapter

FOLDER = Path(nonsmooth_chapter.__file__).parent
MODULES = sorted(FOLDER.rglob("*.py"))


def public(dotted: str) -> bool:
    """Whether a name such as ``models.moling`` is one that the library promises to keep."""
    first, _, second = dotted.partition(".")
    if first not in ns.__all__ or not second:
        return first in ns.__all__
    thing = getattr(ns, first)
    return second in thing.__all__ if inspect.ismodule(thing) else hasattr(thing, second)


def used(tree: ast.Module) -> set[str]:
    """Names of the library that a module uses, after ``nonsmooth.``."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for each in node.names:
                first, _, rest = each.name.partition(".")
                if first == "nonsmooth" and rest:
                    found.add(rest)
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            first, _, rest = node.module.partition(".")
            if first == "nonsmooth":
                found |= {f"{rest}.{each.name}".lstrip(".") for each in node.names}
        elif isinstance(node, ast.Attribute):
            parts = ast.unparse(node).split(".")
            if parts[0] == "ns" and not parts[1].startswith("__"):
                found.add(".".join(parts[1:3]))
    return found


@pytest.mark.parametrize(
    ("code", "names"),
    [
        ("from nonsmooth import System, simulate", {"System", "simulate"}),
        ("from nonsmooth.models import moling", {"models.moling"}),
        ("import nonsmooth.runs.crew", {"runs.crew"}),
        ("import nonsmooth as ns; ns.plot.phases(run)", {"plot", "plot.phases"}),
    ],
)
def test_names_are_found(code, names):
    assert used(ast.parse(code)) == names


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.relative_to(FOLDER).as_posix())
def test_public_names_only(path):
    """What is private may change with any release of the library."""
    hidden = {name for name in used(ast.parse(path.read_text("utf-8"))) if not public(name)}
    assert not hidden, f"not in nonsmooth.__all__, nor in that of its modules: {sorted(hidden)}"


def test_private_names_are_told_apart():
    assert public("models.moling") and public("System.with_parameters")
    assert not public("runs.crew") and not public("plot.style")
