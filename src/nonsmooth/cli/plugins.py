"""Commands that other packages add to ``nonsmooth``.

A package adds a command by an entry point of the group ``nonsmooth.commands``: its name is that of
the command, and what it points to is an application of typer.
"""

from __future__ import annotations

import typer

from nonsmooth.errors import OptionError, RunError

__all__ = ["GROUP", "add_plugins"]

GROUP = "nonsmooth.commands"

# Commands of packages that live in the same repository, and how each of them is installed.
_KNOWN = {
    "chapter": "`nonsmooth chapter` is a package of its own, which is not installed; in a copy of"
    " the repository of nonsmooth, `pip install ./studies/chapter` installs it"
}
_ANYTHING = {"ignore_unknown_options": True, "allow_extra_args": True}


def add_plugins(app: typer.Typer) -> None:
    """Add the commands of installed packages; one that is not installed says how to get it."""
    from importlib.metadata import entry_points

    found = {each.name: each for each in entry_points(group=GROUP)}
    for name in sorted(found):
        try:
            app.add_typer(found[name].load(), name=name)
        except Exception as fault:  # of another package: the other commands must still work
            said = f"{type(fault).__name__}: {fault}"
            _refuse(app, name, RunError(f"`nonsmooth {name}` could not be loaded: {said}"))
    for name, how in _KNOWN.items():
        if name not in found:
            _refuse(app, name, OptionError(how))


def _refuse(app: typer.Typer, name: str, error: Exception) -> None:
    """Add a command that only raises an error, whatever words come after it."""

    @app.command(name, hidden=True, context_settings=_ANYTHING, add_help_option=False)
    def refuse() -> None:
        raise error
