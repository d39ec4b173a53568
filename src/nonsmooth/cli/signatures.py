"""Signatures and docstrings of public functions, read from their source.

Importing a verb loads arrays, datasets and solvers, which takes a second. Help and completion need
only what stands in the source, so the source is parsed and nothing of it runs.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import nonsmooth

__all__ = ["Parameter", "parameters"]

_ROOT = Path(nonsmooth.__file__).parent
_HEADER = re.compile(r"^(\w+(?:, \w+)*) : (.*)$")
_REFERENCE = re.compile(r",? (?:as in|see) `(\w+)`|^As in `(\w+)`")


class Parameter(NamedTuple):
    """A parameter of a function as its signature and its docstring have it."""

    name: str
    annotation: str
    required: bool
    default: Any
    type: str  # of the docstring, such as ``{"before", "after"}, optional``
    text: str

    @property
    def choices(self) -> tuple[Any, ...]:
        """Values that the docstring allows, where it lists them."""
        found = re.match(r"\{.*?\}", self.type)
        return ast.literal_eval(f"({found[0][1:-1]},)") if found else ()


@cache
def parameters(name: str) -> dict[str, Parameter]:
    """Parameters of a public function or class, such as ``regime`` or ``measured.low_pass``."""
    node, module = _definition(name)
    texts = _texts(ast.get_docstring(node) or "")
    found = {}
    for argument, annotation, default in _arguments(node, module):
        kind, text = texts.get(argument, ("", ""))
        value = None if default is None else _value(default)
        found[argument] = Parameter(
            argument,
            ast.unparse(annotation) if annotation is not None else "Any",
            default is None,
            value,
            kind,
            _resolved(argument, text),
        )
    return found


def _definition(name: str) -> tuple[ast.FunctionDef | ast.ClassDef, str]:
    """Definition of a function or class, and its module; a name with a dot is one of a package."""
    package, _, own = name.rpartition(".")
    if package:
        homes = {
            each.name: node.module
            for node in _tree(f"nonsmooth.{package}").body
            if isinstance(node, ast.ImportFrom)
            for each in node.names
        }
        home = homes[own]
    else:
        home = nonsmooth._HOME[own]
    return _defined(own, str(home))


def _defined(name: str, module: str) -> tuple[ast.FunctionDef | ast.ClassDef, str]:
    """Definition of a name of a module, which may have imported it."""
    for node in _tree(module).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name == name:
            return node, module
        if isinstance(node, ast.ImportFrom) and any(each.name == name for each in node.names):
            return _defined(name, str(node.module))
    raise LookupError(f"{module} defines no {name}")


@cache
def _tree(module: str) -> ast.Module:
    place = _ROOT.joinpath(*module.split(".")[1:])
    file = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
    return ast.parse(file.read_text(encoding="utf-8"))


def _value(default: ast.expr) -> Any:
    """Value of a default; of one that only running code could tell, its text."""
    try:
        return ast.literal_eval(default)
    except ValueError:
        return ast.unparse(default)


def _arguments(
    node: ast.FunctionDef | ast.ClassDef, module: str
) -> Iterator[tuple[str, ast.expr | None, ast.expr | None]]:
    """Name, annotation and default of each argument of a function, or field of a dataclass."""
    if isinstance(node, ast.ClassDef):
        for base in node.bases:
            if isinstance(base, ast.Name) and base.id not in ("ABC", "Protocol"):
                inherited, home = _defined(base.id, module)
                if any("dataclass" in ast.unparse(each) for each in inherited.decorator_list):
                    yield from _arguments(inherited, home)
        for field in node.body:
            if not (isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name)):
                continue
            if not field.target.id.startswith("_"):  # the mark of keywords, and private fields
                yield field.target.id, field.annotation, field.value
        return
    own = node.args
    missing = len(own.args) - len(own.defaults)
    defaults = [*[None] * missing, *own.defaults, *own.kw_defaults]
    for each, default in zip([*own.args, *own.kwonlyargs], defaults, strict=True):
        yield each.arg, each.annotation, default


def _texts(docstring: str) -> dict[str, tuple[str, str]]:
    """Type and text of each parameter of a docstring in the style of numpydoc."""
    found: dict[str, tuple[str, list[str]]] = {}
    current: list[str] = []
    section = ""
    lines = docstring.splitlines()
    for line, below in zip(lines, [*lines[1:], ""], strict=True):
        if below and set(below) == {"-"}:
            section = line.strip()
        elif section.endswith("Parameters"):
            header = _HEADER.match(line)
            if header:
                current = []
                found |= {name: (header[2], current) for name in header[1].split(", ")}
            elif re.fullmatch(r"\w+(, \w+)*", line):  # several names without a type
                current = []
                found |= {name: ("", current) for name in line.split(", ")}
            elif set(line) != {"-"}:
                current.append(line.strip())
    return {name: (kind, " ".join(text).strip()) for name, (kind, text) in found.items()}


def _resolved(name: str, text: str) -> str:
    """Text of a parameter; where it points at another function, that of its parameter.

    What the pointing text adds in further sentences stays.
    """
    found = _REFERENCE.search(text)
    if not found:
        return text
    other = found[1] or found[2]
    there = parameters(other).get(name) if other in nonsmooth.__all__ else None
    if there is None or not there.text:
        return _REFERENCE.sub("", text)
    rest = re.split(r"[.;] ", text[found.end() :], maxsplit=1)
    added = rest[1] if len(rest) > 1 else ""
    return f"{there.text} {added[:1].upper()}{added[1:]}".strip()
