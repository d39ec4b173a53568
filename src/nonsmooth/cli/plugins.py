"""Commands that other packages add to ``nonsmooth``.

A package adds a command by an entry point of the group ``nonsmooth.commands``: its name is that of
the command, and what it points to is a command or a group of click. It is loaded when it is used,
or when the help lists it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from nonsmooth.errors import NonsmoothError, OptionError, RunError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

__all__ = ["GROUP", "plugin", "plugin_names"]

GROUP = "nonsmooth.commands"

# Commands of packages that live in the same repository, and how each of them is installed.
_KNOWN = {
    "chapter": "`nonsmooth chapter` is a package of its own, which is not installed; in a copy of"
    " the repository of nonsmooth, `pip install ./studies/chapter` installs it"
}


def _found() -> dict[str, EntryPoint]:
    from importlib.metadata import entry_points

    return {each.name: each for each in entry_points(group=GROUP)}


def plugin_names() -> list[str]:
    """Names of the commands of installed packages."""
    return sorted(_found())


def plugin(name: str) -> click.Command | None:
    """Command of another package; one that cannot be loaded says why when it is called."""
    found = _found()
    if name not in found:
        return _refusal(name, OptionError(_KNOWN[name])) if name in _KNOWN else None
    try:
        loaded = found[name].load()
    except Exception as fault:  # of another package: the other commands must still work
        said = f"{type(fault).__name__}: {fault}"
        return _refusal(name, RunError(f"`nonsmooth {name}` could not be loaded: {said}"))
    if isinstance(loaded, click.Command):
        return loaded
    return _refusal(name, RunError(f"`nonsmooth {name}` is no command or group of click"))


def _refusal(name: str, error: NonsmoothError) -> click.Command:
    """A command that only raises an error, whatever words come after it."""

    def refuse() -> None:
        raise error

    return click.Command(
        name,
        callback=refuse,
        hidden=True,
        add_help_option=False,
        context_settings={"ignore_unknown_options": True, "allow_extra_args": True},
    )
