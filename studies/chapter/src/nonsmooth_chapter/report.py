"""The report: a page of figures and how they came about, and of verdicts on the claims."""

from __future__ import annotations

import base64
import platform
import re
from collections import Counter
from collections.abc import Sequence
from datetime import date
from html import escape
from importlib import resources
from pathlib import Path
from typing import Any

from nonsmooth_chapter.claims import claim_data
from nonsmooth_chapter.figures import figure_place, figure_summary, figure_text
from nonsmooth_chapter.results import code_version, library_versions, replacing
from nonsmooth_chapter.run_items import Outcome

__all__ = [
    "VERDICTS",
    "claim_table",
    "command_of",
    "figures_of_claim",
    "first_words",
    "link_of",
    "section_of",
    "snippet_of",
    "summary_page",
    "write_report",
]


# Texts beside the figures: caption, parameters, protocol, and how an open place was read.

_SECTIONS = {"method": 1, "mole": 2, "fatigue": 3, "rotor": 4}


def section_of(name: str) -> int:
    """Section of the chapter that a figure belongs to.

    Parameters
    ----------
    name : str
        Name of the figure.

    Returns
    -------
    int

    Examples
    --------
    >>> section_of("fig8")
    2
    """
    return _SECTIONS[figure_place(name)[0].split(".")[1]]


def command_of(name: str) -> str:
    """Command that writes a figure with its data.

    Parameters
    ----------
    name : str
        Name of the figure.

    Returns
    -------
    str

    Examples
    --------
    >>> command_of("fig8")
    'nonsmooth chapter run fig8 --out figures'
    """
    return f"nonsmooth chapter run {name} --out figures"


def snippet_of(name: str, options: dict[str, Any]) -> str:
    """Lines of Python that draw a figure.

    Parameters
    ----------
    name : str
        Name of the figure.
    options : dict
        Options of the function that draws it.

    Returns
    -------
    str

    Examples
    --------
    >>> print(snippet_of("fig27", {"points": 201}))
    from nonsmooth_chapter import draw_figure
    <BLANKLINE>
    figure, data = draw_figure("fig27", points=201)
    figure.savefig("fig27.png")
    """
    given = "".join(f", {key}={_literal(value)}" for key, value in options.items())
    return (
        "from nonsmooth_chapter import draw_figure\n\n"
        f'figure, data = draw_figure("{name}"{given})\n'
        f'figure.savefig("{name}.png")'
    )


def _literal(value: Any) -> str:
    """Value of an option as Python writes it; lists of records were tuples."""
    return repr(tuple(value) if isinstance(value, list) else value)


def figures_of_claim(where: str, names: list[str]) -> list[str]:
    """Figures that a claim is about, by the place it stands in the chapter.

    Parameters
    ----------
    where : str
        Such as ``"Fig. 8a-c"`` or ``"Figs. 36, 37"``.
    names : list of str
        Names of figures.

    Returns
    -------
    list of str

    Examples
    --------
    >>> figures_of_claim("Fig. 5a,b", ["fig5b", "fig5d", "fig50"])
    ['fig5b', 'fig5d']
    """
    text = re.search(r"Figs?\. ([\da-z, -]+)", where)
    numbers = set(re.findall(r"\d+", text[1])) if text else set()
    return [name for name in names if (n := re.search(r"\d+", name)) and n[0] in numbers]


# The table of claims in the report: the chapter's words, ours, and the verdict.

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


# The page that the report opens with: what holds, what differs, and what cannot be told.

Row = dict[str, Any]

_LONGEST = 240  # characters of our values that are shown here
_PARTS = (
    ("holds", "What holds", "Ours"),
    ("differs", "What differs, and by how much", "Ours"),
    ("not determinable", "What cannot be told, and what is missing", "Missing, and what we find"),
)
_RULES_SUMMARY = (
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
    return f'<p class="small">{_RULES_SUMMARY}</p>\n' + "\n".join(parts)


def _table(rows: Sequence[Row], ours: str, names: Sequence[str]) -> str:
    heads = "".join(
        f'<th scope="col" class="{key}">{text}</th>'
        for key, text in (("said", "The chapter"), ("ours", ours), ("rule", "How it was tested"))
    )
    body = "\n".join(_row_summary(row, names) for row in rows)
    return (
        f'<table class="summary"><thead><tr>{heads}</tr></thead>\n<tbody>\n{body}\n</tbody></table>'
    )


def _row_summary(row: Row, names: Sequence[str]) -> str:
    data, where = claim_data(row["id"]), escape(row["where"])
    figures = figures_of_claim(row["where"], list(names))
    if figures:
        where = f'<a href="#{figures[0]}">{where}</a>'
    found = escape(first_words(str(row["computed"])))
    if row["verdict"] == "not determinable":
        lacking = data["missing"] or "one reading: the readings disagree"
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


# The report: one page with every figure, how it came about, and the verdicts on the claims.

_TITLES = {
    1: "Section 1: piecewise-smooth systems",
    2: "Section 2: the ground mole",
    3: "Section 3: the fatigue-testing rig",
    4: "Section 4: the rotor in its snubber ring",
}
_BACK = '<a class="back" href="#top">contents</a>'
_SOURCE = (
    "M. Wiercigroch and E. Pavlovskaia,"
    " <cite>Engineering Applications of Non-smooth Dynamics</cite> (2012)"
)


def write_report(
    folder: Path, names: Sequence[str], rows: Sequence[dict[str, Any]], outcome: Outcome
) -> Path:
    """Write ``report.html`` with the pictures of a folder in it.

    Parameters
    ----------
    folder : pathlib.Path
        Folder of the figures.
    names : sequence of str
        Figures, in the order of the page.
    rows : sequence of dict
        Verdicts as of `evaluate_claims`.
    outcome : Outcome
        Of the run; says what could not be made.

    Returns
    -------
    pathlib.Path
        The page, which needs no other file.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_report(Path(folder), [], [], Outcome()).name
    'report.html'
    """
    style = resources.files("nonsmooth_chapter").joinpath("report.css").read_text("utf-8")
    sections = [
        f'<h2 id="section{number}">{title}</h2>\n'
        + "\n".join(_figure(folder, name, rows, outcome) for name in inside)
        for number, title in _TITLES.items()
        if (inside := [name for name in names if section_of(name) == number])
    ]
    body = [
        _head(rows, outcome), summary_page(rows, names), _contents(names), *sections,
        claim_table(rows, list(names)), _foot(),
    ]  # fmt: skip
    page = (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>The chapter, computed anew</title>\n<style>\n{style}</style>\n</head>\n<body>\n"
        + "\n".join(body)
        + "\n</body>\n</html>\n"
    )
    path = folder / "report.html"
    with replacing(path) as draft:
        draft.write_text(page, encoding="utf-8")
    return path


def _head(rows: Sequence[dict[str, Any]], outcome: Outcome) -> str:
    counts = Counter(str(row["verdict"]) for row in rows)
    holds, differs, left = (counts[verdict] for verdict in VERDICTS)
    told = (
        f'<a href="#holds">{holds} hold</a>, <a href="#differs">{differs} differ</a>,'
        f' <a href="#not">{left} are not determinable</a>'
    )
    failed = "".join(
        f"<li>{escape(name)}: {escape(message)}</li>" for name, message in outcome.faults.items()
    )
    return (
        f'<h1 id="top">The chapter, computed anew</h1>\n<p>Figures and claims of {_SOURCE},'
        f" computed by nonsmooth {escape(code_version())} with one command:</p>"
        "<pre>nonsmooth chapter run --all --out DIR</pre>"
        f"<p>Of {len(rows)} claims of the chapter {told}. Each stands below with its verdict, a"
        ' link to its figure, and the rule that decides; the <a href="#figures">figures</a> follow.'
        " Beside this page lie every figure as PNG and PDF, its data as netCDF, and the claims with"
        " their evidence as JSON.</p>"
        + f'<div class="fault"><p>Could not be made:</p><ul>{failed}</ul></div>'
        * bool(failed)
    )


def _contents(names: Sequence[str]) -> str:
    """Links to the figures, by section."""
    sections = " &middot; ".join(
        f'<a href="#section{number}">{title}</a>'
        for number, title in _TITLES.items()
        if any(section_of(name) == number for name in names)
    )
    links = "".join(
        f'<li><a href="#{name}">{escape(figure_text(name)["where"])}</a>'
        f" {escape(figure_summary(name))}</li>"
        for name in names
    )
    return (
        f'<h2 id="figures">Figures</h2>\n<nav aria-label="Figures"><p>{sections}</p>'
        f"<ul>{links}</ul></nav>"
    )


def _figure(folder: Path, name: str, rows: Sequence[dict[str, Any]], outcome: Outcome) -> str:
    text, told = figure_text(name), outcome.of(name)
    summary = figure_summary(name)
    heading = f"<h3>{_BACK}{escape(text['where'])}: {escape(summary)}</h3>"
    if told is None:
        message = outcome.faults.get(name, "not computed")
        return f'<figure id="{name}" class="fault">{heading}<p>{escape(message)}</p></figure>'
    picture = base64.b64encode((folder / f"{name}.png").read_bytes()).decode()
    claims = [row for row in rows if name in figures_of_claim(row["where"], [name])]
    facts = {
        "Parameters": escape(text["parameters"]),
        "Protocol": escape(text["protocol"]),
        "Our reading": escape(text["reading"]),
        "Warnings": "<br>".join(escape(warning) for warning in told["warnings"]),
        "Claims": ", ".join(link_of(row) for row in claims),
        "Files": ", ".join(f'<a href="{file}">{file}</a>' for file in told["files"]),
        "Computed in": f"{told['seconds']:.1f} s",
    }
    listed = "".join(f"<dt>{key}</dt><dd>{value}</dd>" for key, value in facts.items() if value)
    code = snippet_of(name, told["options"])
    return (
        f'<figure id="{name}">{heading}'
        f'<img src="data:image/png;base64,{picture}" alt="{escape(text["caption"] or summary)}">'
        f"<figcaption>{escape(text['caption'])}</figcaption><dl>{listed}</dl>"
        f"<pre>{escape(command_of(name))}</pre><pre>{escape(code)}</pre></figure>"
    )


def _foot() -> str:
    versions = ", ".join(f"{name} {number}" for name, number in library_versions().items())
    return (
        f'<p class="small">Made on {date.today().isoformat()} by nonsmooth {escape(code_version())}'
        f" with {escape(versions)} on {escape(platform.machine())}.</p>"
    )
