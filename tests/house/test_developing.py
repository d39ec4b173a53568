"""Files that the page for developers names are there."""

import re

from house.tree import ROOT

FOLDERS = ("src", "tests", "docs", "studies", "benchmarks")
NAMED = re.compile(r"`([\w./-]+\.(?:py|hpp|h|md|rst|toml))`")


def test_every_file_that_developing_names_is_there():
    text = (ROOT / "DEVELOPING.md").read_text(encoding="utf-8")
    named = {name for name in NAMED.findall(text) if "NAME" not in name}
    assert len(named) > 20
    files = [*ROOT.glob("*.*"), *(file for name in FOLDERS for file in (ROOT / name).rglob("*.*"))]
    paths = [f"/{file.relative_to(ROOT).as_posix()}" for file in files]
    lost = [name for name in sorted(named) if not any(path.endswith(f"/{name}") for path in paths)]
    assert not lost, f"DEVELOPING.md names files that are not there: {lost}"
