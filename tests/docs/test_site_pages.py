"""Every page of the documentation stands in a table of contents, and is read on a forge too."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
FOLDERS = ("tutorials", "how-to", "case-studies", "machines", "explanation")
MADE = "auto_gallery/index"  # when the site is built


def contents(folder: str) -> list[str]:
    """Names in the tables of contents of a folder; those of other folders begin with ``../``."""
    text = (DOCS / folder / "index.md").read_text(encoding="utf-8")
    tables = re.findall(r"```\{toctree\}\n(.*?)```", text, re.S)
    lines = [line.strip() for table in tables for line in table.splitlines()]
    return [line for line in lines if line and not line.startswith(":")]


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_page_is_in_the_contents(folder):
    pages = {path.stem for path in (DOCS / folder).glob("*.md")} - {"index"}
    named = contents(folder)
    assert len(named) == len(set(named)), "a page stands twice"
    assert {name for name in named if not name.startswith("../")} == pages


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_page_is_linked_where_tables_of_contents_are_not_read(folder):
    text = (DOCS / folder / "index.md").read_text(encoding="utf-8")
    assert re.findall(r"^\| \[.*?\]\((.+?)\.md\)", text, re.MULTILINE) == contents(folder)


def test_the_landing_page_leads_everywhere():
    parts = {f"{path.parent.name}/index" for path in DOCS.glob("*/index.*")} - {MADE}
    elsewhere = {name.removeprefix("../") for folder in FOLDERS for name in contents(folder)}
    elsewhere.add("names")  # of the reference
    pages = {path.stem for path in DOCS.glob("*.md")} - {"index"} - elsewhere
    assert set(contents("")) - {MADE} == pages | parts


def test_broken_links_of_a_site_are_told(tmp_path):
    (tmp_path / "a.html").write_text(
        '<a id="x" href="b.html#y">1</a><a href="#x">2</a><a href="https://example.org/">3</a>'
    )
    (tmp_path / "b.html").write_text('<p id="y"><a href="a.html#z">4</a><img src="c.png"></p>')
    command = [sys.executable, str(DOCS / "links.py"), str(tmp_path)]
    first = subprocess.run(command, capture_output=True, text=True)
    assert (first.returncode, first.stdout) == (1, "b.html: a.html#z\nb.html: c.png\n")
    (tmp_path / "b.html").write_text('<p id="y"></p>')
    again = subprocess.run(command, capture_output=True, text=True)
    assert (again.returncode, "1 lead elsewhere" in again.stdout) == (0, True)


@pytest.mark.parametrize("page", ["explanation/architecture.md", "../DEVELOPING.md"])
def test_links_into_the_source_lead_to_files(page):
    """The site takes links that leave ``docs`` for texts, so its own check does not see them."""
    path = (DOCS / page).resolve()
    links = re.findall(r"\]\(([^)#:]+)[^)]*\)", path.read_text(encoding="utf-8"))
    missing = [link for link in links if not (path.parent / link).exists()]
    assert links and not missing
