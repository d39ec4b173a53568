"""The whole chapter by one command: complete, resumable, and as the README tells it."""

import json
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
import xarray as xr

from nonsmooth_chapter import claim_ids, figure_ids
from nonsmooth_chapter.judgement import DIFFERS, HOLDS, OPEN
from verdicts import changes, expected_verdicts, verdicts_of

ROOT = Path(__file__).parents[3]


def told_in_readme():
    """Counts of verdicts, and of claims, as the README has them."""
    text = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    found = re.search(
        r"of (\d+) statements, (\d+) hold, (\d+) differ from what we compute, and (\d+) cannot",
        text,
    )
    total, *counts = (int(number) for number in found.groups())
    return total, dict(zip((HOLDS, DIFFERS, OPEN), counts, strict=True))


def test_readme_counts_every_claim():
    total, counts = told_in_readme()
    assert total == len(claim_ids())
    assert counts == Counter(expected_verdicts().values())


def test_page_of_the_chapter_counts_every_claim():
    text = " ".join((ROOT / "docs/how-to/chapter.md").read_text(encoding="utf-8").split())
    counts = Counter(expected_verdicts().values())
    assert (
        f"{counts[HOLDS]} claims hold, {counts[DIFFERS]} differ and {counts[OPEN]} are not" in text
    )


def chapter(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "nonsmooth", "chapter", *arguments], capture_output=True, text=True
    )


@pytest.mark.slow
def test_whole_chapter(tmp_path):
    """Complete, and as the README tells it; a second run computes nothing."""
    first = chapter("run", "--all", "--out", str(tmp_path))
    check_files(tmp_path, first)
    # the same verdicts from the command that the README names, which finds them in the folder
    told = chapter("claims", "--json", "--store", str(tmp_path))
    assert told.returncode == 0, told.stderr
    rows = json.loads(told.stdout)
    assert [row["id"] for row in rows] == claim_ids()
    assert rows == json.loads((tmp_path / "claims.json").read_text(encoding="utf-8"))
    assert changes(expected_verdicts(), verdicts_of(rows)) == []

    before = {path: path.stat().st_mtime_ns for path in tmp_path.glob("fig*")}
    (tmp_path / "report.html").unlink()
    again = chapter("run", "--all", "--out", str(tmp_path))
    assert (again.returncode, again.stdout) == (0, first.stdout)
    assert {path: path.stat().st_mtime_ns for path in tmp_path.glob("fig*")} == before
    assert (tmp_path / "report.html").exists()


def check_files(folder, run):
    """Three files for each figure, all claims, and the report, without a fault."""
    assert run.returncode == 0, run.stderr
    assert run.stderr == ""
    files = [folder / f"{name}.{end}" for name in figure_ids() for end in ("png", "pdf", "nc")]
    assert run.stdout.splitlines() == [str(path) for path in (*files, folder / "report.html")]
    for path in files:
        assert path.stat().st_size > 5000, path
    for name in figure_ids():
        with xr.open_dataset(folder / f"{name}.nc") as data:
            assert data.attrs["command"] == f"nonsmooth chapter run {name}"
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert page.count("data:image/png;base64,") == len(figure_ids())
    assert all(f'<tr id="{name}">' in page for name in claim_ids())
