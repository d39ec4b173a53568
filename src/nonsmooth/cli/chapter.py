"""``nonsmooth chapter``: the chapter's figures, statements and demonstration."""

from __future__ import annotations

import json
import math
from collections import Counter
from pathlib import Path
from typing import Annotated, Any

import typer

from nonsmooth.cli.console import print_table
from nonsmooth.errors import OptionError, unknown_name

__all__ = ["app"]

app = typer.Typer(
    no_args_is_help=True, help="Figures and statements of the chapter, computed anew."
)

_COLUMNS = ("id", "where", "verdict", "printed", "computed")
_Out = Annotated[Path, typer.Option(metavar="DIR", help="Folder for the files.")]


@app.command("list")
def list_figures() -> None:
    """List the figures that can be drawn."""
    from nonsmooth.chapter import registry

    figures = [(name, registry.figure_summary(name)) for name in registry.figure_ids()]
    print_table(("figure", "what it shows"), figures)


@app.command()
def run(
    figures: Annotated[
        list[str] | None, typer.Argument(metavar="FIG...", help="Figures, see: list.")
    ] = None,
    all_figures: Annotated[bool, typer.Option("--all", help="Draw every figure.")] = False,
    out: _Out = Path("chapter-figures"),
) -> None:
    """Compute and draw figures."""
    from nonsmooth.chapter import registry

    known = registry.figure_ids()
    wanted = figures or []
    if all_figures == bool(wanted):
        raise OptionError("name some figures, or give --all; nonsmooth chapter list names them")
    for name in wanted:
        if name not in known:
            raise OptionError(unknown_name("figure", name, known))
    out.mkdir(parents=True, exist_ok=True)
    for path in registry.run_figures(known if all_figures else wanted, out):
        typer.echo(str(path))


@app.command()
def claims(
    ids: Annotated[
        list[str] | None, typer.Argument(metavar="ID...", help="Claims, such as F45; all if none.")
    ] = None,
    section: Annotated[int | None, typer.Option(help="Those of this section.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON with all details.")] = False,
    verdict: Annotated[str | None, typer.Option(help="Those with this verdict.")] = None,
) -> None:
    """Compare what the chapter states with what is computed."""
    from nonsmooth.chapter.claims import evaluate_claims

    rows = evaluate_claims(section=section, ids=ids or None)
    if verdict is not None:
        verdicts = {str(row["verdict"]) for row in rows}
        if verdict not in verdicts:
            raise OptionError(f"--verdict: {unknown_name('verdict', verdict, verdicts)}")
        rows = [row for row in rows if row["verdict"] == verdict]
    if as_json:
        typer.echo(json.dumps(_plain(rows), indent=2, ensure_ascii=False))
        return
    print_table(_COLUMNS, [[_text(row[key]) for key in _COLUMNS] for row in rows], lines=True)
    counts = Counter(str(row["verdict"]) for row in rows)
    typer.echo(", ".join(f"{count} {name}" for name, count in counts.most_common()))


@app.command()
def demo(out: _Out = Path("demo-output")) -> None:
    """Draw the demonstration of the chapter's main results."""
    from nonsmooth.chapter.demo import run_demo

    out.mkdir(parents=True, exist_ok=True)
    run_demo(out)


def _text(value: Any) -> str:
    if value is None:
        return ""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _plain(value: Any) -> Any:
    """Value in the types of JSON, which has neither arrays of numpy nor infinities."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if value is None or isinstance(value, str | bool | int | float):
        return value
    return str(value)
