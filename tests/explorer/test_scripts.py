"""A copied script gives the digits of the page, and a copied command runs."""

import shlex
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from click.testing import CliRunner

import nonsmooth as ns
from nonsmooth.cli.app import app
from nonsmooth.explorer.gestures import after
from nonsmooth.explorer.openings import opening
from nonsmooth.explorer.scripts import command_text, python_text, toml_text
from nonsmooth.explorer.tasks import TASKS

SMALL = {"columns": 12, "cells": 6, "transient": 30, "record": 12}


def small(view, **fields):
    return replace(view, **SMALL, **fields)


VIEWS = {
    "mole": small(opening("moling"), initial=(("p", -0.5),)),
    "orbit": small(opening("moling"), turn=1, branch=True, between=(0.14, 0.16), picture="section"),
    "wall": small(opening("impact_oscillator"), start="follow down", leave_out=0.0),
    "belt": small(opening("belt_oscillator"), over="zeta", between=(0.0, 0.1)),
    "typed": small(
        after(
            opening("soft_impact"),
            {"do": "text", "text": ns.models.soft_impact(beta=9.0).to_toml() + "# a \\ 'quote'\n"},
        ),
        values=(("e", "5/4"),),
    ),
}


@pytest.fixture
def ran(tmp_path, monkeypatch):
    """Names of a script that has run in a folder of its own."""
    monkeypatch.chdir(tmp_path)

    def run(view):
        names = {}
        exec(compile(python_text(view), "copied.py", "exec"), names)
        return names

    yield run
    plt.close("all")


@pytest.mark.few(1)
@pytest.mark.filterwarnings("ignore:settled|the motion|of .* motions")
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.slow] * (n == "orbit")) for n in VIEWS]
)
def test_the_script_gives_the_digits_of_the_page(ran, tmp_path, name):
    view = VIEWS[name]
    names = ran(view)
    (motion,) = TASKS["motion"](view)
    assert np.array_equal(motion["time"], names["run"]["time"].values)
    for variable, values in motion["values"].items():
        assert np.array_equal(values, names["run"][variable].values), variable
    pieces = list(TASKS["diagram"](view))
    pieces = pieces if view.start == "restart" else pieces[-1:]
    shown = sorted(
        pair for piece in pieces for pair in zip(piece["parameter"], piece["value"], strict=True)
    )
    known = names["diagram"][view.shown].values.reshape(view.columns, -1)
    at = {float(p): set(known[k].tolist()) for k, p in enumerate(names["diagram"]["parameter"])}
    assert len(shown) >= view.columns
    assert all(value in at[p] for p, value in shown)
    if "basins" in names:
        *_, plane = TASKS["plane"](view)
        assert np.array_equal(plane["label"], names["basins"]["label"].transpose(*view.plane[::-1]))
    if "branch" in names:
        orbit, branch = TASKS["orbit"](view)
        assert np.array_equal(branch["value"], names["branch"][view.shown].values)
        assert orbit["multipliers"] == names["orbit"]["multipliers"].values.tolist()
    assert {file.suffix for file in tmp_path.iterdir()} == {".png"}


@pytest.mark.parametrize("name", VIEWS)
def test_every_command_runs(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    view = VIEWS[name]
    (tmp_path / "machine.toml").write_text(toml_text(view), encoding="utf-8")
    lines = [line for line in command_text(view).splitlines() if not line.startswith("#")]
    assert len(lines) >= 2
    for line in lines:
        program, *words = shlex.split(line)
        result = CliRunner().invoke(app, words)
        assert program == "nonsmooth" and result.exit_code in (0, 1), (line, result.output)


def test_the_copied_system_has_the_present_parameters():
    view = after(opening("moling"), {"do": "value", "name": "b", "value": "0.07"})
    assert ns.System.from_toml(toml_text(view)) == ns.models.moling().with_parameters(b=0.07)
