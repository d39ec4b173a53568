"""Options of the commands that look for periodic orbits."""

from __future__ import annotations

from typing import Annotated

import typer

__all__ = ["OrbitPeriod", "OrbitTransient", "Word", "modes_of_word"]

OrbitPeriod = Annotated[int, typer.Option("--period", help="Periods of the forcing in one turn.")]
OrbitTransient = Annotated[
    int | None,
    typer.Option(
        "--transient", help="Periods to simulate first; 200 by default, with --start none."
    ),
]
Word = Annotated[
    str | None,
    typer.Option(
        metavar='"MODE MODE ..."',
        help="Modes in order from the section point on; those of a simulation by default.",
    ),
]


def modes_of_word(text: str | None) -> list[str] | None:
    """Names of modes, between which there are blanks or commas."""
    return None if text is None else text.replace(",", " ").split()
