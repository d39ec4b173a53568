"""The commands of ``nonsmooth`` and the options that belong to none of them."""

from __future__ import annotations

from typing import Annotated

import typer

from nonsmooth.cli.attractors import attractors
from nonsmooth.cli.basins import basins
from nonsmooth.cli.console import Commands
from nonsmooth.cli.contacts import contacts
from nonsmooth.cli.continue_ import continue_
from nonsmooth.cli.diagram import diagram
from nonsmooth.cli.ensemble import ensemble
from nonsmooth.cli.explain import explain
from nonsmooth.cli.lyapunov import lyapunov
from nonsmooth.cli.measured import measured
from nonsmooth.cli.measures import measures
from nonsmooth.cli.models import models
from nonsmooth.cli.orbit import orbit
from nonsmooth.cli.plugins import add_plugins
from nonsmooth.cli.regime import regime
from nonsmooth.cli.regimes import regimes
from nonsmooth.cli.section import section
from nonsmooth.cli.simulate import simulate
from nonsmooth.cli.smoothing import smoothing
from nonsmooth.cli.spectrum import spectrum
from nonsmooth.cli.strobe import strobe
from nonsmooth.cli.waterfall import waterfall
from nonsmooth.cli.zero_one import zero_one
from nonsmooth.version import __version__

__all__ = ["app"]

app = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"nonsmooth {__version__}")
        raise typer.Exit()


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version."
        ),
    ] = False,
) -> None:
    """Exact simulation of piecewise-smooth dynamical systems.

    Exit codes: 0 done, 1 ended early (files are written), 2 wrong use, 130 interrupted.
    """


app.command()(simulate)
app.command()(lyapunov)
app.command()(spectrum)
app.command()(waterfall)
app.command()(contacts)
app.command()(zero_one)
app.command()(section)
app.command()(strobe)
app.command()(diagram)
app.command()(regime)
app.command()(regimes)
app.command()(orbit)
app.command("continue")(continue_)
app.command()(smoothing)
app.command()(ensemble)
app.command()(attractors)
app.command()(basins)
app.command()(measures)
app.command()(measured)
app.command()(models)
app.command()(explain)

add_plugins(app)
