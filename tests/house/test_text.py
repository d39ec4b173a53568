"""What must not stand in any file: a machine's own paths, notes to self, other authors."""

import re
import tomllib

import pytest

import nonsmooth
from house.tree import ROOT, relative, text_files

AUTHOR = "The nonsmooth developers"

# Letters in brackets keep these patterns from finding themselves.
FORBIDDEN = {
    "a path of one machine: write it relative to the repository": re.compile(
        r"(?<![\w.~$})\]*-])/(?:work|root|home|Users)(?![\w-])"
    ),
    "a host of one machine or a package index: installers know theirs": re.compile(
        r"local[h]ost|py[p]i\.org|python[h]osted\.org|--(?:extra-)?index-ur[l]"
    ),
    "a note to self: do it, or write it into CHANGELOG.md": re.compile(
        r"\b(?:TO[D]O|FIX[M]E|XX[X])\b"
    ),
}


def project() -> dict:
    """The ``project`` table of pyproject.toml."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.mark.parametrize("fault", FORBIDDEN)
def test_no_forbidden_text(fault):
    """The repository must work on any machine and be finished where it says it is."""
    found = [
        f"{relative(path)}:{number}: {line.strip()[:120]}"
        for path in text_files()
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1)
        if FORBIDDEN[fault].search(line)
    ]
    assert not found, f"{fault}\n" + "\n".join(found)


def test_one_author():
    """Licence, citation and package name the same author, by name only."""
    assert project()["authors"] == [{"name": AUTHOR}], f"pyproject.toml: authors is {AUTHOR!r}"
    assert re.search(rf"^Copyright \(c\) \d{{4}} {AUTHOR}$", read("LICENSE"), re.MULTILINE), (
        f"LICENSE: the copyright line ends with {AUTHOR!r}"
    )
    assert re.search(rf'^authors:\n  - name: "{AUTHOR}"\n\S', read("CITATION.cff"), re.MULTILINE), (
        f"CITATION.cff: authors holds one name, {AUTHOR!r}"
    )


def test_one_version():
    """A result says which version made it, so all places must say the same one."""
    version = project()["version"]
    assert nonsmooth.__version__ == version, (
        f"nonsmooth.__version__ is {nonsmooth.__version__}, pyproject.toml has {version}"
    )
    assert f"\nversion: {version}\n" in read("CITATION.cff"), f"CITATION.cff: version is {version}"


def read(name: str) -> str:
    """A file at the top of the repository."""
    return (ROOT / name).read_text(encoding="utf-8")
