"""The commands of ``nonsmooth`` and the options that belong to none of them."""

from __future__ import annotations

import click

from nonsmooth.cli.command import VerbCommand
from nonsmooth.cli.console import Commands
from nonsmooth.cli.plugins import plugin, plugin_names
from nonsmooth.cli.table import TABLE
from nonsmooth.version import __version__

__all__ = ["app"]

_SHELLS = ("bash", "zsh", "fish")


class _Lazy(Commands):
    """Group whose commands are made when they are asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of all commands, those of other packages last."""
        return [*TABLE, *self.commands, *plugin_names()]

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        """A command by its name."""
        if name in TABLE:
            return VerbCommand(name, TABLE[name])
        return super().get_command(ctx, name) or plugin(name)


@click.group(
    cls=_Lazy,
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(__version__, message="nonsmooth %(version)s", help="Print the version.")
def app() -> None:
    """Exact simulation of piecewise-smooth dynamical systems.

    Begin with: nonsmooth models, then nonsmooth simulate soft_impact --plot run.png. For what a
    command takes, with an example, type nonsmooth COMMAND --help.

    Exit codes: 0 done, 1 ended early or found nothing (files are written), 2 wrong use, 3 done from
    a record with flaws (files are written), 130 interrupted.
    """


@app.command()
@click.argument("shell", type=click.Choice(_SHELLS))
def completion(shell: str) -> None:
    r"""Print a script for your shell, by which the Tab key completes commands and options.

    \b
    bash: add this line to ~/.bashrc:  eval "$(nonsmooth completion bash)"
    zsh:  add this line to ~/.zshrc:   eval "$(nonsmooth completion zsh)"
    fish: nonsmooth completion fish > ~/.config/fish/completions/nonsmooth.fish
    """
    from click.shell_completion import get_completion_class

    found = get_completion_class(shell)
    assert found is not None
    click.echo(found(app, {}, "nonsmooth", "_NONSMOOTH_COMPLETE").source())
