"""Figures and claims that take no time, fail, crash or take for ever, for the tests of runs."""

from __future__ import annotations

import os
import threading
from pathlib import Path

import xarray as xr

from nonsmooth import RunError
from nonsmooth.plot import print_figure
from nonsmooth_chapter.judgement import Check, Finding
from nonsmooth_chapter.worker import Item

__all__ = ["claim", "item"]


def line(slope: float = 2.0):
    """A line through the origin."""
    figure, (ax,) = print_figure()
    data = xr.Dataset({"y": ("x", [0.0, slope])}, {"x": [0.0, 1.0]}, {"note": "a <stub>"})
    ax.plot(data["x"], data["y"])
    ax.set_xlabel("x")
    ax.set_ylabel("y")
    return figure, data


def parabola():
    return line(slope=4.0)


def faulty():
    raise RunError("the line could not be drawn")


def crashing():
    os._exit(7)


def endless():
    """Goes on until its process is ended; a file tells that it has begun."""
    Path(os.environ["ENDLESS_BEGAN"]).touch()
    threading.Event().wait()


def check_of(name):
    check = Check(name, "none", lambda n=2: {"n": n}, lambda e: Finding(e["n"] == 2, str(e["n"])))
    evidence = check.compute()
    row = {
        "id": name, "where": "Fig. 8", "printed": "n is 2", "computed": str(evidence["n"]),
        "protocol": check.protocol, "verdict": "holds", "evidence": evidence,
    }  # fmt: skip
    return check, lambda: row


def item(function: str) -> Item:
    """Stub as an item; its name is that of the function."""
    return Item("figure", function, "stub_figures", function, f"what {function} shows")


def claim(name: str) -> Item:
    return Item("claim", name, "stub_figures", "check_of")
