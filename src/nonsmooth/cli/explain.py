"""``nonsmooth explain``: what a system does by itself, for given parameter values."""

from __future__ import annotations

from typing import Annotated

import typer

from nonsmooth.cli.arguments import build_system, settings
from nonsmooth.cli.console import MODEL_HELP, PARAMETERS_HELP

__all__ = ["explain"]


def explain(
    model: Annotated[str, typer.Argument(metavar="MODEL", help=MODEL_HELP)],
    parameters: Annotated[
        list[str] | None, typer.Argument(metavar="NAME=VALUE...", help=PARAMETERS_HELP)
    ] = None,
) -> None:
    """Print states, natural motions, forcing and exits of a system."""
    build_system(model, settings(parameters or [], "NAME=VALUE")).explain()
