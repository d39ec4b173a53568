"""What all commands share: exit codes, tables, and errors as one line of text."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from typing import Any

import click

from nonsmooth.errors import NonsmoothError, RunError, unknown_name

__all__ = ["DOUBTFUL", "ENDED_EARLY", "INTERRUPTED", "MISUSE", "Commands", "print_table"]

ENDED_EARLY = 1  # the work was begun and could not be finished
MISUSE = 2  # the command line or the model cannot be right
DOUBTFUL = 3  # the work is done, from a record with flaws
INTERRUPTED = 130  # 128 + SIGINT, as shells report it

_PIPE_WIDTH = 120  # characters; what reads a pipe has no screen to fit


class Commands(click.Group):
    """Group of commands that turns what the library raises into a message and an exit code."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The command that is called; for an unknown name the nearest one is told."""
        name = args[0]
        is_option = name.startswith("-")
        if not is_option and not ctx.resilient_parsing and self.get_command(ctx, name) is None:
            ctx.fail(unknown_name("command", name, self.list_commands(ctx)))
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            click.echo("nonsmooth: interrupted", err=True)
            raise click.exceptions.Exit(INTERRUPTED) from None
        except NonsmoothError as error:
            from nonsmooth.system.columns import harmless  # texts of files stand in messages

            click.echo(f"nonsmooth: {harmless(str(error))}", err=True)
            code = ENDED_EARLY if isinstance(error, RunError) else MISUSE
            raise click.exceptions.Exit(code) from None
        except BrokenPipeError:  # the reader has seen enough; click ends this quietly
            raise
        except OSError as error:
            named = error.filename is not None and error.strerror is not None
            text = f"{str(error.filename)!r}: {error.strerror}" if named else str(error)
            click.echo(f"nonsmooth: {text}", err=True)
            raise click.exceptions.Exit(ENDED_EARLY) from None


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
