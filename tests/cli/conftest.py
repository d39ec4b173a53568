from __future__ import annotations

import pytest
from click.testing import CliRunner

from nonsmooth import Exit, Mode, System, models
from nonsmooth.cli.app import app


@pytest.fixture
def call(monkeypatch):
    """Run a command line; the result has exit_code, stdout and stderr.

    The explorer serves until Ctrl-C, which comes at once here.
    """

    def run(*arguments: str):
        if arguments[0] == "explore":
            server = pytest.importorskip("nonsmooth.explorer.server", reason="it needs the extra")
            monkeypatch.setattr(server.ExplorerServer, "serve", lambda own, ready: own.crew.close())
        return CliRunner().invoke(app, [str(argument) for argument in arguments])

    return run


def ball(r: float = 0.5) -> System:
    """Ball whose impacts accumulate, without a period."""
    return System(
        name="ball",
        states=["h", "u"],
        parameters={"r": r, "weight": 1.0},
        modes={"flight": Mode({"h": "u", "u": "-weight"}, exits=[Exit("h", reset={"u": "-r*u"})])},
        initial={"h": 1.0},
    )


@pytest.fixture
def accumulating(monkeypatch):
    """A model whose runs end early, beside those of the library."""
    monkeypatch.setattr(models, "ball", ball, raising=False)
    monkeypatch.setattr(models, "__all__", [*models.__all__, "ball"])
