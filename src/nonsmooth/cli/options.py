"""Options that several commands have: which map, and how attractors are looked for."""

from __future__ import annotations

from typing import Annotated

import typer

from nonsmooth.cli.console import MODEL_HELP, PARAMETERS_HELP

__all__ = [
    "Complete",
    "Direction",
    "Every",
    "Longest",
    "Match",
    "Model",
    "Parameters",
    "Period",
    "Phase",
    "Record",
    "Samples",
    "SearchCells",
    "SectionText",
    "Seed",
    "Side",
    "Start",
    "StartMode",
]

Model = Annotated[str, typer.Argument(metavar="MODEL", help=MODEL_HELP)]
Parameters = Annotated[
    list[str] | None, typer.Argument(metavar="NAME=VALUE...", help=PARAMETERS_HELP)
]
Start = Annotated[str | None, typer.Option(metavar="x=0.1,v=0", help="States at the start.")]
StartMode = Annotated[str | None, typer.Option(help="Mode to start in.")]

Phase = Annotated[
    float | None, typer.Option(help="Part of the period at which strobes are, 0 by default.")
]
Period = Annotated[
    str | None,
    typer.Option(metavar="EXPRESSION", help="Time between strobes, if not that of the system."),
]
SectionText = Annotated[
    str | None,
    typer.Option(
        "--section",
        metavar="EXPRESSION",
        help="Points where it vanishes, or at this event, not strobes.",
    ),
]
Direction = Annotated[
    int | None, typer.Option(help="Of the section: 1 where it grows, -1 falls, 0 both.")
]
Side = Annotated[
    str | None, typer.Option(help="Of a section: states just before (default) or just after.")
]
Every = Annotated[int, typer.Option(help="Take each so many-th point as one step of the map.")]

Complete = Annotated[
    list[str] | None,
    typer.Option(
        metavar="q=EXPRESSION",
        help="A state that is not in --over; at rest without it. May be given several times.",
    ),
]
Samples = Annotated[int, typer.Option(help="Random starts by which attractors are found.")]
Seed = Annotated[int, typer.Option(help="Of the random starts.")]
Longest = Annotated[int, typer.Option(help="Steps after which a start is left unsettled.")]
Record = Annotated[int, typer.Option(help="Steps of a motion that does not repeat.")]
Match = Annotated[float, typer.Option(help="Points repeat that agree to this part of the spread.")]
SearchCells = Annotated[
    int, typer.Option("--cells", help="Cells across the spread by which motions recur.")
]
