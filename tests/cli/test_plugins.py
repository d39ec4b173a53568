"""Commands of other packages, found by their entry points."""

import importlib.metadata
import sys
from importlib.metadata import EntryPoint
from types import ModuleType

import pytest
import typer
from typer.testing import CliRunner

from nonsmooth.cli.console import Commands
from nonsmooth.cli.plugins import GROUP, add_plugins


@pytest.fixture
def call(monkeypatch):
    """Run a command line where only some plug-ins are installed."""

    def run(places, *arguments):
        found = [EntryPoint(name, place, GROUP) for name, place in places.items()]
        monkeypatch.setattr(
            importlib.metadata, "entry_points", lambda *, group: found if group == GROUP else []
        )
        app = typer.Typer(cls=Commands)
        app.command("own")(lambda: typer.echo("the library's own command"))
        add_plugins(app)
        return CliRunner().invoke(app, arguments)

    return run


@pytest.fixture
def plugin(monkeypatch):
    """Place of an application of another package."""
    other = typer.Typer()
    other.command("greet")(lambda name: typer.echo(f"hello {name}"))
    other.command("leave")(lambda: None)
    module = ModuleType("other_package")
    module.app = other
    monkeypatch.setitem(sys.modules, "other_package", module)
    return "other_package:app"


def test_a_package_adds_a_command(call, plugin):
    result = call({"other": plugin}, "other", "greet", "you")
    assert (result.exit_code, result.stdout) == (0, "hello you\n")
    assert "other" in call({"other": plugin}, "--help").stdout


@pytest.mark.parametrize("words", [[], ["run", "--all", "--out", "x"], ["--help"]])
def test_a_study_that_is_not_installed_says_how_to_install_it(call, words):
    result = call({}, "chapter", *words)
    assert (result.exit_code, result.stdout) == (2, "")
    assert "pip install ./studies/chapter" in result.stderr
    assert result.stderr.count("\n") == 1


def test_a_study_that_is_installed_is_not_refused(call, plugin):
    assert call({"chapter": plugin}, "chapter", "greet", "you").exit_code == 0


@pytest.mark.parametrize("place", ["no_such_package:app", "other_package:nothing"])
def test_a_broken_package_breaks_no_other_command(call, plugin, place):
    assert call({"other": place}, "own").stdout == "the library's own command\n"
    result = call({"other": place}, "other", "greet", "you")
    assert (result.exit_code, result.stdout) == (1, "")
    assert "`nonsmooth other` could not be loaded: " in result.stderr
