"""What all commands share: tables, and errors as one line with an exit code."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from typing import Any

import typer
from typer.core import TyperGroup

from nonsmooth.errors import NonsmoothError, RunError

__all__ = [
    "ENDED_EARLY",
    "INTERRUPTED",
    "MISUSE",
    "MODEL_HELP",
    "PARAMETERS_HELP",
    "STORE_HELP",
    "Commands",
    "print_table",
]

MODEL_HELP = "A name, see: nonsmooth models; or a file, see: nonsmooth models moling --toml."
PARAMETERS_HELP = "Parameters; a value may be an expression like pi/2."
STORE_HELP = "Keep what is done in a folder; the same command goes on there."

ENDED_EARLY = 1  # the work was begun and could not be finished
MISUSE = 2  # the command line or the model cannot be right
INTERRUPTED = 130  # 128 + SIGINT, as shells report it

_PIPE_WIDTH = 120  # characters; what reads a pipe has no screen to fit


class Commands(TyperGroup):
    """Group of commands that turns what the library raises into a message and a code."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            typer.echo("nonsmooth: interrupted", err=True)
            raise typer.Exit(INTERRUPTED) from None
        except NonsmoothError as error:
            from nonsmooth.system.columns import harmless  # texts of files stand in messages

            typer.echo(f"nonsmooth: {harmless(str(error))}", err=True)
            raise typer.Exit(ENDED_EARLY if isinstance(error, RunError) else MISUSE) from None
        except BrokenPipeError:  # the reader has seen enough; typer ends this quietly
            raise
        except OSError as error:
            typer.echo(f"nonsmooth: {error}", err=True)
            raise typer.Exit(ENDED_EARLY) from None


def print_table(
    heads: Sequence[str], rows: Iterable[Sequence[str]], *, lines: bool = False
) -> None:
    """Print a table; cells are plain text, and a pipe gets neither colours nor 80 columns."""
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console(width=None if sys.stdout.isatty() else _PIPE_WIDTH, highlight=False)
    table = Table(box=box.SIMPLE_HEAD, show_header=any(heads), show_lines=lines, pad_edge=False)
    for head in heads:
        table.add_column(head)
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    console.print(table)
