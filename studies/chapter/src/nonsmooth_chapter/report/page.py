"""The report: one page with every figure, how it came about, and the verdicts on the claims."""

from __future__ import annotations

import base64
import platform
from collections import Counter
from collections.abc import Sequence
from datetime import date
from html import escape
from importlib import resources
from pathlib import Path
from typing import Any

from nonsmooth_chapter.code_version import code_version, library_versions
from nonsmooth_chapter.files import replacing
from nonsmooth_chapter.registry import figure_summary
from nonsmooth_chapter.report.claim_table import VERDICTS, claim_table, link_of
from nonsmooth_chapter.report.summary import summary_page
from nonsmooth_chapter.report.texts import (
    command_of,
    figure_text,
    figures_of_claim,
    section_of,
    snippet_of,
)
from nonsmooth_chapter.run_items import Outcome

__all__ = ["write_report"]

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
    style = resources.files("nonsmooth_chapter.report").joinpath("style.css").read_text("utf-8")
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
