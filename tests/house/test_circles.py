"""No module imports itself by way of others.

Modules in a circle can only be read, tested and changed together. Imports inside functions and
imports for type checkers alone count too: they hide a circle, and do not open it.
"""

import ast
from collections.abc import Iterable, Iterator

import pytest

from house.tree import module_name, outline, python_files

# Circles that are left; take out what you have opened, and put none in.
KNOWN: set[frozenset[str]] = set()
# Names that are imported when they are used: a package as a whole is no module of the graph.
LAZY = {"nonsmooth", "nonsmooth_chapter"}


def imports(nodes: Iterable[ast.AST], package: str, modules: set[str]) -> Iterator[str]:
    """Modules of this package that a module of ``package`` imports, wherever in its text."""
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in modules)
        elif isinstance(node, ast.ImportFrom):
            home = node.module or ""
            if node.level:
                above = package.rsplit(".", node.level - 1)[0] if node.level > 1 else package
                home = f"{above}.{home}".rstrip(".")
            for alias in node.names:
                inner = f"{home}.{alias.name}"
                if inner in modules or home in modules:
                    yield inner if inner in modules else home


def import_graph() -> dict[str, set[str]]:
    """The modules that each module imports."""
    files = {module_name(path): path for path in python_files()}
    modules, graph = set(files), {}
    for name, path in files.items():
        package = name if path.name == "__init__.py" else name.rpartition(".")[0]
        graph[name] = set(imports(outline(path), package, modules)) - {name}
    return {name: targets - LAZY for name, targets in graph.items() if name not in LAZY}


def circles(graph: dict[str, set[str]]) -> set[frozenset[str]]:
    """Sets of modules each of which leads to all others (strongly connected components)."""
    reached = {name: reachable(graph, name) for name in graph}
    found = set()
    for name in graph:
        if name in reached[name]:
            found.add(frozenset(other for other in reached[name] if name in reached[other]))
    return found


def reachable(graph: dict[str, set[str]], start: str) -> set[str]:
    """Modules that a module imports, and those that these import, and so on."""
    seen: set[str] = set()
    waiting = [start]
    while waiting:
        new = graph[waiting.pop()] - seen
        seen |= new
        waiting += new
    return seen


def shown(found: set[frozenset[str]]) -> str:
    """One circle a line."""
    return "\n".join(sorted(" <-> ".join(sorted(circle)) for circle in found))


def test_no_circles_of_imports():
    """What two modules need of each other belongs below both of them, or into one file."""
    new = circles(import_graph()) - KNOWN
    assert not new, "these modules import each other in a circle:\n" + shown(new)


def test_known_circles_are_still_there():
    """A circle that was opened may not close again unseen."""
    gone = KNOWN - circles(import_graph())
    assert not gone, "no longer circles, so take them out of KNOWN in this file:\n" + shown(gone)


@pytest.mark.parametrize(
    "text",
    [
        "import nonsmooth.b",
        "from nonsmooth.b import name",
        "from nonsmooth import b",
        "from .b import name",
        "from . import b",
        "def f():\n    from nonsmooth.b import name",
        "if TYPE_CHECKING:\n    from nonsmooth.b import name",
    ],
)
def test_every_way_to_import_counts(text):
    """A way that the test did not see would be a way around it."""
    assert set(imports(ast.walk(ast.parse(text)), "nonsmooth", {"nonsmooth.b"})) == {"nonsmooth.b"}


def test_a_circle_is_found():
    graph = {"a": {"b"}, "b": {"c"}, "c": {"b", "d"}, "d": set()}
    assert circles(graph) == {frozenset({"b", "c"})}
