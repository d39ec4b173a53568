"""What stands in a file of its own, and what names mean one thing.

Both lists below hold what is left from before these tests. They may only become shorter: whoever
merges a file or renames a class takes its line out.
"""

import ast
from collections import defaultdict
from pathlib import Path

from house.tree import module_name, outline, python_files, relative

SHORT = 60  # lines; a file with fewer is read with the only one that uses it

SHORT_FILES: set[str] = set()

CLASS_NAMES = {
    "Outcome",
    "Section",
    "Sweep",
}


def imports_of(path: Path, modules: set[str]) -> set[str]:
    """Modules of the package that a file imports, wherever the import stands in it."""
    found = set()
    for node in outline(path):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return found & modules


def short_files_of_one_user() -> dict[str, str]:
    """Files that are short and that only one other file imports, with that file."""
    files = {module_name(path): path for path in python_files()}
    users = defaultdict(list)
    for name, path in files.items():
        for used in imports_of(path, set(files)) - {name}:
            users[used].append(relative(path))
    return {
        relative(path): users[name][0]
        for name, path in files.items()
        if path.name != "__init__.py"
        and len(users[name]) == 1
        and len(path.read_text(encoding="utf-8").splitlines()) < SHORT
    }


def class_files() -> dict[str, list[str]]:
    """Files in which a class of each name is written."""
    found = defaultdict(list)
    for path in python_files():
        for node in outline(path):
            if isinstance(node, ast.ClassDef):
                found[node.name].append(relative(path))
    return found


def test_a_short_file_serves_several():
    """A helper of one file is read with it, so it stands in it."""
    found = short_files_of_one_user()
    new = [f"{path} (used by {found[path]})" for path in sorted(set(found) - SHORT_FILES)]
    assert not new, f"under {SHORT} lines, and one user: move these into the user\n" + (
        "\n".join(new)
    )
    gone = sorted(SHORT_FILES - set(found))
    assert not gone, "no longer short files of one user: take these out of SHORT_FILES\n" + (
        "\n".join(gone)
    )


def test_a_class_name_means_one_thing():
    """A reader who searches for a class finds the one that is meant."""
    found = {name: places for name, places in class_files().items() if len(places) > 1}
    new = [f"{name}: {', '.join(found[name])}" for name in sorted(set(found) - CLASS_NAMES)]
    assert not new, "say in the name what sets these apart:\n" + "\n".join(new)
    gone = sorted(CLASS_NAMES - set(found))
    assert not gone, f"no longer written twice: take these out of CLASS_NAMES\n{gone}"
