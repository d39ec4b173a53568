"""The table of claims in the report: the chapter's words, ours, and the verdict."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from html import escape
from typing import Any

from nonsmooth_chapter.claims import claim_data
from nonsmooth_chapter.report.texts import figures_of_claim

__all__ = ["VERDICTS", "claim_table", "link_of"]

VERDICTS = ("holds", "differs", "not determinable")
_LOOKS = {"holds": "holds", "differs": "differs", "not determinable": "open"}
_HEADS = (("id", "Claim"), ("where", "Where"), ("verdict", "Verdict"),
          ("printed", "The chapter"), ("computed", "Ours, and by which protocol"))  # fmt: skip
_RULES = (
    "A printed number holds within one unit of its last digit, after &ldquo;about&rdquo; within 2 %"
    " or the step of the sweep; a qualitative claim where its predicate is true in every case it"
    " names. Not determinable: the chapter lacks data that the judgement needs, or admissible"
    " readings of it disagree."
)


def claim_table(rows: Sequence[dict[str, Any]], names: list[str]) -> str:
    """HTML of the table.

    Parameters
    ----------
    rows : sequence of dict
        Verdicts as of `evaluate_claims`.
    names : list of str
        Figures of the page, for links to them.

    Returns
    -------
    str

    Examples
    --------
    >>> claim_table([], []).count("<tr>")
    1
    """
    heads = "".join(f'<th scope="col" class="{key}">{text}</th>' for key, text in _HEADS)
    body = "\n".join(_row(row, names) for row in rows)
    return (
        '<h2 id="claims"><a class="back" href="#top">contents</a>Claims</h2>'
        f'\n<p>{_counts(rows)}</p>\n<p class="small">{_RULES}</p>\n'
        f'<table class="claims"><thead><tr>{heads}</tr></thead>\n<tbody>\n{body}\n</tbody></table>'
    )


def _counts(rows: Sequence[dict[str, Any]]) -> str:
    """Verdicts by section of the chapter."""
    told = []
    for section in sorted({int(claim_data(row["id"])["section"]) for row in rows}):
        inside = [row for row in rows if claim_data(row["id"])["section"] == section]
        counts = Counter(row["verdict"] for row in inside)
        parts = ", ".join(
            f'{counts[verdict]} <span class="{_LOOKS[verdict]}">{verdict}</span>'
            for verdict in VERDICTS
        )
        told.append(f"Section {section}: {parts}")
    return "<br>".join(told)


def _row(row: dict[str, Any], names: list[str]) -> str:
    where = escape(row["where"])
    figures = figures_of_claim(row["where"], names)
    if figures:
        where = f'<a href="#{figures[0]}">{where}</a>'
    data = claim_data(row["id"])
    given = f'<p class="small">{escape(data["parameters"])}</p>' if data["parameters"] else ""
    return (
        f'<tr id="{row["id"]}"><th scope="row">{row["id"]}</th><td>{where}</td>'
        f'<td class="{_LOOKS[row["verdict"]]}">{row["verdict"]}</td>'
        f"<td>{escape(str(row['printed']))}{given}</td>"
        f"<td>{escape(str(row['computed']))}"
        f'<p class="small">{escape(row["protocol"])}</p></td></tr>'
    )


def link_of(row: dict[str, Any]) -> str:
    """Link to the row of a claim, with its verdict.

    Parameters
    ----------
    row : dict
        Verdict as of `evaluate_claims`.

    Returns
    -------
    str

    Examples
    --------
    >>> link_of({"id": "M03", "verdict": "differs"})
    '<a href="#M03">M03</a> <span class="differs">differs</span>'
    """
    look = _LOOKS[row["verdict"]]
    return f'<a href="#{row["id"]}">{row["id"]}</a> <span class="{look}">{row["verdict"]}</span>'
