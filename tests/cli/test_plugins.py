"""Commands of other packages, found by their entry points."""

import importlib.metadata
import sys
from importlib.metadata import EntryPoint
from types import ModuleType

import click
import pytest

from nonsmooth.cli import plugins
from nonsmooth.cli.app import app
from nonsmooth.errors import OptionError


@pytest.fixture
def installed(monkeypatch):
    """Make some plug-ins be installed, and no others."""

    def install(**places):
        found = [EntryPoint(name, place, plugins.GROUP) for name, place in places.items()]
        monkeypatch.setattr(
            importlib.metadata,
            "entry_points",
            lambda *, group: found if group == plugins.GROUP else [],
        )

    return install


@pytest.fixture
def place(monkeypatch):
    """Place of a group of commands in another package."""

    @click.group()
    def other():
        """What the other package does."""

    @other.command()
    @click.argument("name")
    def greet(name):
        click.echo(f"hello {name}")

    @other.command()
    def fail():
        raise OptionError("give another number")

    module = ModuleType("other_package")
    module.other, module.nothing = other, 3
    monkeypatch.setitem(sys.modules, "other_package", module)
    return "other_package:other"


def test_a_package_adds_a_command(call, installed, place):
    installed(other=place)
    result = call("other", "greet", "you")
    assert (result.exit_code, result.stdout) == (0, "hello you\n")
    assert "What the other package does" in call("--help").stdout
    result = call("other", "fail")
    assert (result.exit_code, result.stderr) == (2, "nonsmooth: give another number\n")


@pytest.mark.parametrize("words", [[], ["run", "--all", "--out", "x"], ["--help"]])
def test_a_study_that_is_not_installed_says_how_to_install_it(call, installed, monkeypatch, words):
    installed()
    monkeypatch.delitem(app.commands, "chapter", raising=False)
    result = call("chapter", *words)
    assert (result.exit_code, result.stdout) == (2, "")
    assert "pip install ./studies/chapter" in result.stderr
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize(
    "broken", ["no_such_package:app", "other_package:missing", "other_package:nothing"]
)
def test_a_broken_package_breaks_no_other_command(call, installed, place, broken):
    installed(other=broken)
    assert call("models", "moling").exit_code == 0
    assert call("--help").exit_code == 0
    result = call("other", "greet", "you")
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr.startswith("nonsmooth: `nonsmooth other` ")
