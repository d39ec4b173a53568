"""Files and functions stay short enough to be read in one go.

The limits are those that the most readable libraries of the field keep; docstrings are free.
"""

import ast
from pathlib import Path

from house.tree import outline, python_files, relative

P90_FILE, LONGEST_FILE = 450, 700
P95_FUNCTION, LONG_FUNCTION, SHARE_OF_LONG_FUNCTIONS = 45, 60, 0.03


def quantile(values: list[int], fraction: float) -> int:
    """The value that this fraction of all values does not exceed."""
    return sorted(values)[min(len(values) - 1, int(len(values) * fraction))]


def file_sizes() -> dict[str, int]:
    """Lines per file."""
    return {
        relative(path): len(path.read_text(encoding="utf-8").splitlines())
        for path in python_files()
    }


def function_sizes() -> dict[str, int]:
    """Lines per function without its docstring; an inner function counts by itself as well."""
    return {
        f"{relative(path)}:{node.lineno} {node.name}": length(node)
        for path in python_files()
        for node in functions(path)
    }


def functions(path: Path) -> list[ast.FunctionDef | ast.AsyncFunctionDef]:
    """Every function and method of a file."""
    return [n for n in outline(path) if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef)]


def length(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines from ``def`` to the end, less those of the docstring."""
    lines = node.end_lineno - node.lineno + 1
    if ast.get_docstring(node) is not None:
        doc = node.body[0]
        lines -= doc.end_lineno - doc.lineno + 1
    return lines


def longest(sizes: dict[str, int], count: int = 8) -> str:
    """The places to shorten first."""
    rows = sorted(sizes.items(), key=lambda row: -row[1])[:count]
    return "the longest are:\n" + "\n".join(f"{lines:5d}  {place}" for place, lines in rows)


def test_file_lengths():
    """A file that does one job is found by its name; a long one does several.

    That files are not too short either is tested in `test_rooms`.
    """
    sizes = file_sizes()
    lines = list(sizes.values())
    p90 = quantile(lines, 0.9)
    advice = f"split a file by what its parts do; {longest(sizes)}"
    assert p90 <= P90_FILE, f"one file in ten is over {P90_FILE} lines ({p90}): {advice}"
    assert max(lines) <= LONGEST_FILE, f"a file is over {LONGEST_FILE} lines: {advice}"


def test_function_lengths():
    """A function that fits on a screen can be checked by reading it."""
    sizes = function_sizes()
    lines = list(sizes.values())
    p95 = quantile(lines, 0.95)
    share = sum(n > LONG_FUNCTION for n in lines) / len(lines)
    advice = f"name a part of it and move that out; {longest(sizes)}"
    assert p95 <= P95_FUNCTION, f"one function in twenty is over {P95_FUNCTION} lines: {advice}"
    assert share <= SHARE_OF_LONG_FUNCTIONS, (
        f"{share:.1%} of the functions are over {LONG_FUNCTION} lines,"
        f" allowed is {SHARE_OF_LONG_FUNCTIONS:.0%}: {advice}"
    )
