"""No piece of code stands twice: what is mended in one place must not stay broken in another."""

import ast
from collections import defaultdict
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

from house.tree import outline, python_files, relative

MOST = 6  # lines that two places may share, without imports, docstrings and signatures

# Pairs of files that share more, each with its reason.
KNOWN = {
    ("src/nonsmooth/engine/tables.py", "src/nonsmooth/engine/tables.py"):
        "two records have fields in common, in the order in which `interface.h` declares them",
    ("src/nonsmooth/models/massive_ring_rotor.py", "src/nonsmooth/models/rotor.py"):
        "each rotor names its parameters in a table of its own, as its docstring does",
    ("src/nonsmooth/models/rotor.py", "src/nonsmooth/models/snubber_rub.py"): "likewise",
}  # fmt: skip


def left_out(nodes: Iterable[ast.AST]) -> set[int]:
    """Lines of imports, docstrings and signatures: what these repeat is meant to be read again."""
    found: set[int] = set()
    for node in nodes:
        if isinstance(node, ast.Import | ast.ImportFrom) or (
            isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        ):
            found |= set(range(node.lineno, node.end_lineno + 1))
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            found |= set(range(node.lineno, node.body[0].lineno))
    return found


def code_lines(path: Path) -> list[tuple[int, str]]:
    """Number and text of the lines of code of a file, without what is left out."""
    text = path.read_text(encoding="utf-8")
    skipped = left_out(outline(path))
    lines = ((number, line.strip()) for number, line in enumerate(text.splitlines(), 1))
    return [
        (number, line)
        for number, line in lines
        if number not in skipped and any(map(str.isalnum, line)) and not line.startswith("#")
    ]


def clones(files: dict[str, Path]) -> dict[tuple[str, str], str]:
    """Pairs of files with more equal lines in a row than `MOST`, and where one such row is."""
    places = defaultdict(list)
    for name, path in files.items():
        lines = code_lines(path)
        for first in range(len(lines) - MOST):
            row = lines[first : first + MOST + 1]
            places[tuple(text for _, text in row)].append((name, row[0][0]))
    return {
        (one[0], other[0]): f"{one[0]}:{one[1]} and {other[0]}:{other[1]}"
        for found in places.values()
        for one, other in pairwise(sorted(found))
    }


def test_no_piece_of_code_stands_twice():
    found = clones({relative(path): path for path in python_files()})
    new = [place for pair, place in sorted(found.items()) if pair not in KNOWN]
    assert not new, (
        f"more than {MOST} equal lines: let one piece of code serve both, or give the reason in"
        " KNOWN\n" + "\n".join(new)
    )
    gone = sorted(set(KNOWN) - set(found))
    assert not gone, f"no longer alike: take these out of KNOWN\n{gone}"


def test_a_copy_is_found(tmp_path):
    """Seven lines in a row between others are a clone, six are none, and a docstring is no code."""
    body = "".join(f"value_{k} = compute({k})\n" for k in range(MOST + 1))
    texts = {
        "a": f"import os\nfirst = 1\n{body}",
        "b": f'"""Text."""\n\n# a comment\n{body}last = 2\n',
        "c": body.split("\n", 1)[1],
        "d": f'"""Text\n{body}"""\n',
    }
    files = {name: tmp_path / f"{name}.py" for name in texts}
    for name, path in files.items():
        path.write_text(texts[name])
    assert set(clones(files)) == {("a", "b")}
