"""The report: whole by itself, every figure with its texts, every claim in the table."""

import inspect
import re
from html.parser import HTMLParser

import pytest

from nonsmooth_chapter import claim_ids, figure_ids
from nonsmooth_chapter.claims import claim_data
from nonsmooth_chapter.figures import TEXTS, _maker, _table, figure_summary, figure_text
from nonsmooth_chapter.report import (
    figures_of_claim,
    first_words,
    section_of,
    snippet_of,
    write_report,
)
from nonsmooth_chapter.run_items import Outcome

PICTURE = b"\x89PNG stands in"
EMPTY = {"img", "meta", "br"}


class Page(HTMLParser):
    """Elements of a page; complains of those that are not closed in order."""

    def __init__(self, text):
        super().__init__()
        self.ids, self.links, self.images, self.open, self.text = [], [], [], [], []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        if "id" in values:
            self.ids.append(values["id"])
        if tag == "a":
            self.links.append(values["href"])
        if tag == "img":
            self.images.append(values)
        assert tag not in ("script", "link", "iframe"), "a page without other files"
        if tag not in EMPTY:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def row(name, verdict="holds"):
    data = claim_data(name)
    return {
        "id": name, "where": data["where"], "printed": data["claim"], "computed": "3 < 4 & more",
        "protocol": "from rest", "verdict": verdict, "evidence": {},
    }  # fmt: skip


@pytest.fixture
def page(tmp_path):
    """Report of all figures but one that failed, with three claims."""
    names = figure_ids()
    told = {}
    for name in names:
        (tmp_path / f"{name}.png").write_bytes(PICTURE)
        files = [f"{name}.{end}" for end in ("png", "pdf", "nc")]
        told[name] = {"state": "done", "told": {
            "seconds": 1.0, "warnings": ["<slow>"], "files": files, "options": {"n": 3},
            "attributes": {},
        }}  # fmt: skip
    told["fig12"] = {"state": "fault", "message": "RunError: no <basins>"}
    rows = [row("M03", "differs"), row("M13"), row("M47", "not determinable")]
    path = write_report(tmp_path, names, rows, Outcome(told))
    return Page(path.read_text(encoding="utf-8"))


def test_page_is_whole_by_itself(page):
    """Pictures are in it with a text for those who do not see them; links lead somewhere."""
    assert len(page.images) == len(figure_ids()) - 1
    for image in page.images:
        assert image["src"].startswith("data:image/png;base64,") and len(image["alt"]) > 20
    assert len(page.ids) == len(set(page.ids))
    assert set(figure_ids()) | {"M03", "M13", "M47", "claims"} <= set(page.ids)
    for link in page.links:
        inside = link[1:] in page.ids if link.startswith("#") else "/" not in link
        assert inside, link


def test_page_shows_how_each_figure_came_about(page):
    """Caption, parameters, protocol, command, lines of Python, our reading; and what failed."""
    text = "".join(page.text)
    for name in figure_ids():
        for field in TEXTS:
            if name != "fig12":
                assert figure_text(name)[field] in text, (name, field)
        assert figure_summary(name) in text
        assert (f"nonsmooth chapter run {name} --out" in text) == (name != "fig12")
    assert 'draw_figure("fig8", n=3)' in text
    assert text.count("RunError: no <basins>") == 2  # at the top, and in its place


def test_table_of_claims(page):
    """Verdict, the chapter's words, ours and the protocol, and the counts."""
    text = "".join(page.text)
    assert "Of 3 claims of the chapter 1 hold, 1 differ, 1 are not determinable" in text
    assert "Section 2: 1 holds, 1 differs, 1 not determinable" in text
    assert text.count("3 < 4 & more") == 2 * 3  # on the opening page, and in the table
    assert claim_data("M13")["claim"] in text and claim_data("M13")["parameters"] in text


def test_opening_page(page):
    """Three parts in front of the figures; each claim with figure, what is missing, and rule."""
    text = "".join(page.text)
    titles = ["What holds (1)", "What differs, and by how much (1)", "What cannot be told"]
    places = [text.index(title) for title in titles]
    opening = text[places[0] : text.index("Section 1: piecewise")]
    assert places == sorted(places)
    assert claim_data("M47")["missing"] in opening
    assert opening.count("from rest") == 3
    assert {"#fig5b", "#fig7", "#fig12"} <= set(page.links)


def test_first_words_end_with_a_clause():
    assert first_words("short") == "short"
    assert first_words("a clause of this length; and another one", 30) == "a clause of this length"
    assert len(first_words("word " * 100, 50)) <= 54


def test_every_figure_has_texts():
    """A row of the table is complete, and names nothing that nobody reads."""
    for name in figure_ids():
        text = figure_text(name)
        assert set(_table()[name]) - {"together"} == {"summary", "draw", *TEXTS}, name
        assert all(text[field] for field in TEXTS), name
        assert text["caption"].endswith(".") and text["reading"].endswith("."), name


def test_every_figure_that_is_asked_for_is_there():
    """Figures of the chapter that show results of its models."""
    wanted = ["1", "2", "3", "5", *range(6, 13), *range(16, 39), 40, 41, 42]
    found = {re.search(r"\d+", name)[0] for name in figure_ids() if name != "phases"}
    assert found == {str(number) for number in wanted}
    assert [section_of(name) for name in ("fig1", "fig12", "fig16", "fig31")] == [1, 2, 3, 4]


def test_snippets_are_calls_that_the_figures_take():
    """The options shown are arguments of the function, with values that Python reads."""
    for name in figure_ids():
        arguments = inspect.signature(_maker(name)).parameters.values()
        options = {each.name: each.default for each in arguments}
        names = {"draw_figure": lambda name, **given: (figure_that_saves(), given)}
        lines = snippet_of(name, options).partition("\n\n")[2]
        exec(compile(lines, name, "exec"), names)
        assert names["data"] == options, name


def figure_that_saves():
    class Figure:
        def savefig(self, path):
            assert path.endswith(".png")

    return Figure()


@pytest.mark.parametrize(
    ("where", "expected"),
    [
        ("Fig. 5a,b", ["fig5b", "fig5d"]),
        ("Fig. 8a-c", ["fig8"]),
        ("Figs. 36, 37", ["fig36", "fig37"]),
        ("(62)-(66), Fig. 35", ["fig35"]),
        ("Fig. 29, (48)", ["fig29"]),
        ("s2.4 (i), s5", []),
        ("Fig. 36 text", ["fig36"]),
    ],
)
def test_claims_name_their_figures(where, expected):
    assert figures_of_claim(where, figure_ids()) == expected


def test_figures_named_by_claims_exist_or_are_no_results():
    """Every place that names a figure leads to one."""
    for name in claim_ids():
        where = claim_data(name)["where"]
        if "Fig" in where:
            assert figures_of_claim(where, figure_ids()), (name, where)
