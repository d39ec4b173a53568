"""The page that the report opens with: what holds, what differs, and what cannot be told."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

from nonsmooth_chapter.claims import claim_data
from nonsmooth_chapter.report.texts import figures_of_claim

__all__ = ["first_words", "summary_page"]

Row = dict[str, Any]

_LONGEST = 240  # characters of our values that are shown here
_PARTS = (
    ("holds", "What holds", "Ours"),
    ("differs", "What differs, and by how much", "Ours"),
    ("not determinable", "What cannot be told, and what is missing", "Missing, and what we find"),
)
_RULES = (
    "Rules were fixed before anything was computed. A printed number holds within one unit of its"
    " last digit, after &ldquo;about&rdquo; within 2 % or the step of the sweep that it was read"
    " from. A sentence holds where its predicate is true in every case that it names. It cannot be"
    " told where the chapter lacks data that the judgement needs, or where admissible readings of"
    " it disagree. The last column says how each claim was put to the test; the whole of our values"
    ' stands in the <a href="#claims">table of claims</a>.'
)


def summary_page(rows: Sequence[Row], names: Sequence[str]) -> str:
    """HTML of the opening page.

    Parameters
    ----------
    rows : sequence of dict
        Verdicts as of `evaluate_claims`.
    names : sequence of str
        Figures of the report, for links to them.

    Returns
    -------
    str

    Examples
    --------
    >>> summary_page([], []).count("<h2")
    3
    """
    parts = []
    for verdict, title, ours in _PARTS:
        inside = [row for row in rows if row["verdict"] == verdict]
        place = verdict.split()[0]
        parts.append(
            f'<h2 id="{place}">{title} ({len(inside)})</h2>\n{_table(inside, ours, names)}'
        )
    return f'<p class="small">{_RULES}</p>\n' + "\n".join(parts)


def _table(rows: Sequence[Row], ours: str, names: Sequence[str]) -> str:
    heads = "".join(
        f'<th scope="col" class="{key}">{text}</th>'
        for key, text in (("said", "The chapter"), ("ours", ours), ("rule", "How it was tested"))
    )
    body = "\n".join(_row(row, names) for row in rows)
    return (
        f'<table class="summary"><thead><tr>{heads}</tr></thead>\n<tbody>\n{body}\n</tbody></table>'
    )


def _row(row: Row, names: Sequence[str]) -> str:
    data, where = claim_data(row["id"]), escape(row["where"])
    figures = figures_of_claim(row["where"], list(names))
    if figures:
        where = f'<a href="#{figures[0]}">{where}</a>'
    found = escape(first_words(str(row["computed"])))
    if row["verdict"] == "not determinable":
        lacking = data["missing"] if data["dagger"] else "one reading: the readings disagree"
        found = f"<b>{escape(lacking)}</b>; {found}"
    said = escape(str(row["printed"]))
    return (
        f'<tr><td><a href="#{row["id"]}">{row["id"]}</a> {said} ({where})</td><td>{found}</td>'
        f'<td class="small">{escape(_rule(row["protocol"]))}</td></tr>'
    )


def _rule(protocol: str) -> str:
    """Protocol without what the chapter lacks, which stands beside it."""
    return protocol.split("; the chapter does not give:")[0]


def first_words(text: str, longest: int = _LONGEST) -> str:
    """The beginning of a text, to the end of a clause or of a word.

    Parameters
    ----------
    text : str
        Any text.
    longest : int, optional
        Characters at most.

    Returns
    -------
    str

    Examples
    --------
    >>> first_words("14.363 Hz, printed 14.4 Hz; and more", longest=30)
    '14.363 Hz, printed 14.4 Hz'
    >>> first_words("a text without any clauses at all", longest=20)
    'a text without any ...'
    """
    if len(text) <= longest:
        return text
    for mark in ("; ", ". ", ", "):
        end = text.rfind(mark, 0, longest)
        if end > longest // 4:
            return text[:end]
    return text[: text.rfind(" ", 0, longest)] + " ..."
