"""Every page of the documentation stands in a table of contents, and is read on a forge too."""

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
FOLDERS = ("tutorials", "how-to", "case-studies", "explanation")


def contents(page: Path) -> list[str]:
    """Names in the tables of contents of a page."""
    tables = re.findall(r"```\{toctree\}\n(.*?)```", page.read_text(encoding="utf-8"), re.S)
    lines = [line.strip() for table in tables for line in table.splitlines()]
    return [line for line in lines if line and not line.startswith(":")]


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_page_is_in_the_contents(folder):
    pages = {path.stem for path in (DOCS / folder).glob("*.md")} - {"index"}
    named = contents(DOCS / folder / "index.md")
    assert len(named) == len(set(named)), "a page stands twice"
    assert set(named) == pages


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_page_is_linked_where_tables_of_contents_are_not_read(folder):
    index = DOCS / folder / "index.md"
    linked = set(re.findall(r"\]\(([\w-]+)\.md\)", index.read_text(encoding="utf-8")))
    assert linked == set(contents(index))


def test_the_landing_page_leads_everywhere():
    named = contents(DOCS / "index.md")
    pages = {path.stem for path in DOCS.glob("*.md")} - {"index", "names"}  # names: reference
    parts = {f"{path.parent.name}/index" for path in DOCS.glob("*/index.*")}
    parts -= {"auto_gallery/index"}  # made when the site is built
    assert set(named) - {"auto_gallery/index"} == pages | parts
