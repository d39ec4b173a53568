"""The files of this repository, found without git so that an unpacked archive can be tested."""

import ast
import os
from fnmatch import fnmatch
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "src" / "nonsmooth"


def python_files() -> list[Path]:
    """Modules of library and studies, in order, less the one that build_engine.py writes."""
    found = [*SOURCE.rglob("*.py"), *(ROOT / "studies").glob("*/src/**/*.py")]
    return sorted(path for path in found if path.name != "_declarations.py")


def module_name(path: Path) -> str:
    """Full name of the module in a file."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    parts = parts[parts.index("src") + 1 :]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def outline(path: Path) -> tuple[ast.AST, ...]:
    """Imports, classes, functions and bare constants of a file, each of them wherever it stands.

    To parse all files takes seconds, so each is parsed once for all tests of a process. Of the body
    of a class or function only the first statement is kept, which may be the docstring: whole trees
    of all files would fill 200 MB.
    """
    bodies = (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    tree = ast.parse(path.read_text(encoding="utf-8"))
    found = [
        node
        for node in ast.walk(tree)
        if isinstance(node, (ast.Import, ast.ImportFrom, *bodies))
        or (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant))
    ]
    for node in found:
        if isinstance(node, bodies):
            del node.body[1:]
    return tuple(found)


def text_files() -> list[Path]:
    """Every file that git does not ignore and that is UTF-8 text."""
    skipped = [".git", *_ignored_folders()]
    found = []
    for folder, subfolders, names in os.walk(ROOT):
        subfolders[:] = sorted(
            s for s in subfolders if not any(fnmatch(s, pattern) for pattern in skipped)
        )
        kept = (name for name in sorted(names) if name != ".git")  # a file in a further worktree
        found += [path for name in kept if is_text(path := Path(folder, name))]
    return found


def is_text(path: Path) -> bool:
    """Whether a file reads as UTF-8 without zero bytes."""
    try:
        return "\0" not in path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        return False


def relative(path: Path) -> str:
    """The path as a message should show it."""
    return path.relative_to(ROOT).as_posix()


def _ignored_folders() -> list[str]:
    lines = (ROOT / ".gitignore").read_text(encoding="utf-8").splitlines()
    return [line.strip("/") for line in lines if line.endswith("/")]
