"""``nonsmooth chapter``: the chapter's figures, statements and demonstration."""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import click

from nonsmooth import OptionError
from nonsmooth_chapter.results import unknown_name

__all__ = ["app"]


@click.group(no_args_is_help=True)
def app() -> None:
    """Figures and statements of the chapter, computed anew."""


_COLUMNS = ("id", "where", "verdict", "printed", "computed")
_VERDICTS = ("holds", "differs", "not determinable")
_ENDED_EARLY = 1  # code of a command that could not do all of its work
_PIPE_WIDTH = 120  # characters; what reads a pipe has no screen to fit
_FOLDER = click.Path(path_type=Path)
_PROCESSES = click.option(
    "--processes", type=int, metavar="N", help="Processes; by default one for each processor."
)


def _out(default: str) -> Any:
    return click.option(
        "--out",
        type=_FOLDER,
        default=default,
        metavar="FOLDER",
        show_default=True,
        help="Folder for the files.",
    )


@app.command("list")
def list_figures() -> None:
    """List the figures that can be drawn."""
    from nonsmooth_chapter.figures import figure_ids, figure_summary

    figures = [(name, figure_summary(name)) for name in figure_ids()]
    _print_table(("figure", "what it shows"), figures, lines=False)


@app.command()
@click.argument("figures", nargs=-1, metavar="[FIGURE...]")
@click.option(
    "--figures",
    "more_figures",
    metavar="FIGURE,FIGURE",
    help="Figures with commas in between; nonsmooth chapter list names them.",
)
@click.option("--all", "all_figures", is_flag=True, help="Every figure, and a report of claims.")
@_out("chapter-figures")
@_PROCESSES
def run(
    figures: tuple[str, ...],
    more_figures: str | None,
    all_figures: bool,
    out: Path,
    processes: int | None,
) -> None:
    """Compute and draw figures; what the folder has from the same code is left as it is.

    Each is written as PNG and PDF with its data as netCDF. With --all the claims are judged too,
    and report.html shows everything.
    """
    from nonsmooth_chapter.figures import figure_ids
    from nonsmooth_chapter.whole_chapter import run_chapter, written_files

    known = figure_ids()
    wanted = [*figures, *(more_figures.split(",") if more_figures else [])]
    if all_figures == bool(wanted):
        raise OptionError("name some figures, or give --all; nonsmooth chapter list names them")
    for name in wanted:
        if name not in known:
            raise OptionError(unknown_name("figure", name, known))
    out.mkdir(parents=True, exist_ok=True)
    outcome = run_chapter(out, None if all_figures else wanted, processes=processes)
    for path in written_files(out, known if all_figures else wanted, outcome):
        click.echo(str(path))
    if all_figures and outcome.complete:
        click.echo(str(out / "report.html"))
    _end(outcome, f"what is done is kept; the same command with --out {out} goes on there")


@app.command()
@click.argument("ids", nargs=-1, metavar="[ID...]")
@click.option("--section", type=int, metavar="N", help="Claims of this section.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON with all details.")
@click.option(
    "--verdict", metavar="VERDICT", help=f"Claims with this verdict: {', '.join(_VERDICTS)}."
)
@click.option(
    "--store",
    type=_FOLDER,
    metavar="FOLDER",
    help="Keep what is done in a folder; the same command goes on there.",
)
@_PROCESSES
def claims(
    ids: tuple[str, ...],
    section: int | None,
    as_json: bool,
    verdict: str | None,
    store: Path | None,
    processes: int | None,
) -> None:
    """Compare what the chapter states with what is computed."""
    from nonsmooth_chapter.claims import select_claims
    from nonsmooth_chapter.whole_chapter import judge_claims

    if verdict is not None and verdict not in _VERDICTS:
        raise OptionError(f"--verdict: {unknown_name('verdict', verdict, _VERDICTS)}")
    names = select_claims(section, list(ids) or None)
    rows, outcome = judge_claims(names, store=store, processes=processes)
    if outcome.complete:
        _print_rows([row for row in rows if verdict in (None, row["verdict"])], as_json)
    kept = f"what is done is kept; the same command with --store {store} goes on there"
    _end(
        outcome,
        kept if store else "nothing is kept; give a folder to keep it, such as --store claims",
    )


def _print_rows(rows: list[dict[str, Any]], as_json: bool) -> None:
    if as_json:
        click.echo(json.dumps(rows, indent=2, ensure_ascii=False))
        return
    _print_table(_COLUMNS, [[_text(row[key]) for key in _COLUMNS] for row in rows], lines=True)
    counts = Counter(str(row["verdict"]) for row in rows)
    click.echo(", ".join(f"{counts[name]} {name}" for name in _VERDICTS))


def _end(outcome: Any, kept: str) -> None:
    """Say what failed, and end with the code of that."""
    for name, message in outcome.faults.items():
        click.echo(f"nonsmooth: {name}: {message}", err=True)
    if not outcome.complete:
        click.echo(f"nonsmooth: {kept}", err=True)
        raise KeyboardInterrupt
    if outcome.faults:
        raise click.exceptions.Exit(_ENDED_EARLY)


@app.command()
@_out("demo-output")
def demo(out: Path) -> None:
    """Draw the demonstration of the chapter's main results."""
    from nonsmooth_chapter.demo import run_demo

    out.mkdir(parents=True, exist_ok=True)
    run_demo(out)


def _print_table(heads: Sequence[str], rows: Iterable[Sequence[str]], *, lines: bool) -> None:
    """Print a table; cells are plain text, and a pipe gets neither colours nor 80 columns."""
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console(width=None if sys.stdout.isatty() else _PIPE_WIDTH, highlight=False)
    table = Table(box=box.SIMPLE_HEAD, show_lines=lines, pad_edge=False)
    for head in heads:
        table.add_column(head)
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    console.print(table)


def _text(value: Any) -> str:
    if value is None:
        return ""
    return f"{value:.6g}" if isinstance(value, float) else str(value)
