"""The demonstration: the study of the mole, its pictures and a table of progression."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth_chapter.figures import run_figures

if TYPE_CHECKING:
    from rich.table import Table

__all__ = ["progression_table", "run_demo"]

_FORCES = (0.05, 0.095, 0.1, 0.15, 0.19, 0.27)
_FIGURES = ("fig6", "fig7", "phases")
_PERIODS, _FIRST, _LAST = 1000, 50, 400


def run_demo(out: Path | str) -> None:
    """Study of the mole: Figs. 6 and 7, phases of a period, and a table of progression.

    Prints the table and a line for each file written.

    Parameters
    ----------
    out : pathlib.Path or str
        Folder for the files; made if it is not there.

    Examples
    --------
    >>> from nonsmooth_chapter import run_demo
    >>> run_demo("demo-output")  # doctest: +SKIP
    """
    from rich.console import Console

    from nonsmooth_chapter.results import save_table

    console = Console()
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    rows = progression_table()
    console.print(_printable(rows))
    for path in (save_table(rows, folder / "progression.csv"), *run_figures(_FIGURES, folder)):
        console.print(f"wrote {path}", highlight=False, soft_wrap=True)


def progression_table() -> list[dict[str, Any]]:
    """Progression of the mole for the six static forces of Figs. 6 and 7, from rest.

    Returns
    -------
    list of dict
        For each b: progression per period and per unit time (means over the last 400 of
        1000 periods), over the first 50 periods, regime, phases of the last period, and
        status.

    Examples
    --------
    >>> [round(row["per_period"], 2) for row in progression_table()[2:4]]
    [14.04, 31.35]
    """
    from nonsmooth import simulate
    from nonsmooth.models import moling, progression
    from nonsmooth_chapter.mole.sweeps import bounded_states, primitive_period

    rows = []
    for b in _FORCES:
        run = simulate(moling(b=b), periods=_PERIODS, samples_per_period=1)
        steady = progression(run, periods=_LAST)
        period, _ = primitive_period(bounded_states(run)[-_LAST:])
        rows.append(
            {
                "b": b,
                "per_period": float(steady["per_period"]),
                "per_unit_time": float(steady["per_unit_time"]),
                "first_50_periods": float(steady["progression"][:_FIRST].sum()),
                "regime": f"period {period}" if period else "aperiodic",
                "phases_of_last_period": run.attrs["phase_word"],
                "status": run.attrs["status"],
            }
        )
    return rows


def _printable(rows: list[dict[str, Any]]) -> Table:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(
        title="Progression of the mole from rest (a = 0.3, omega = 0.1, xi = 0.05)",
        caption=f"Means over the last {_LAST} of {_PERIODS} periods. Phases of the last period:"
        " P progression, C contact, N no contact. Where the motion is aperiodic, rounding decides"
        f" the sum of the first {_FIRST}.",
        caption_justify="left",
        box=SIMPLE_HEAD,
        pad_edge=False,
    )
    for name in ("b", "per period", "per time", f"first {_FIRST}"):
        table.add_column(name, justify="right")
    for name in ("regime", "phases", "status"):
        table.add_column(name)
    for row in rows:
        table.add_row(
            f"{row['b']:g}",
            f"{row['per_period']:.3f}",
            f"{row['per_unit_time']:.4f}",
            f"{row['first_50_periods']:.2f}",
            row["regime"],
            "".join(name[0].upper() for name in row["phases_of_last_period"].split()),
            row["status"],
        )
    return table
