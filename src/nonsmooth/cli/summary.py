"""A run in a few lines of text."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from itertools import groupby
from typing import TYPE_CHECKING

from nonsmooth.cli.output import certified, table

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["summary"]

_LAST = 5  # periods whose progression is printed
_MOST_ALIKE = 9  # modes in a row that are all written out


def summary(run: xr.Dataset) -> str:
    """Status, events, last period, end and progression of a run."""
    attrs = run.attrs
    rows = [("status", f"{attrs['message']}"), *_length(run)]
    rows.append(("certified", certified(attrs["n_uncertain"], attrs["n_estimated"])))
    word = "phase word, last period" if "period" in attrs else "phase word"
    rows.append((word, _short(attrs["phase_word"])))
    states = zip(run["state"].values, run["end_state"].values, strict=True)
    rows.append(("end state", ", ".join(f"{name} = {value:.7g}" for name, value in states)))
    rows += _progression(run)
    return table(attrs["system_name"], rows)


def _short(word: str) -> str:
    """A phase word in which a mode that follows on itself many times stands once."""
    runs = [(mode, len(list(same))) for mode, same in groupby(word.split())]
    return " ".join(
        f"{mode} ({count} times)" if count > _MOST_ALIKE else " ".join([mode] * count)
        for mode, count in runs
    )


def _length(run: xr.Dataset) -> Iterator[tuple[str, str]]:
    """How long the run was and how many events it had."""
    attrs = run.attrs
    end = attrs["end_number"] * attrs["window"] + attrs["end_phase"]
    start = float(run["time"][0]) if run.sizes["time"] else end
    yield "time", f"{start:.7g} to {end:.7g}"
    events = f"{attrs['n_events']}"
    if "period" in attrs:
        periods = (end - start) / attrs["period"]
        yield "periods", f"{periods:.7g} of {attrs['period']:.7g}"
        if periods > 0.0:
            events += f", {attrs['n_events'] / periods:.4g} per period"
    yield "events", events


def _progression(run: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Progression of each drift state over the last periods."""
    from nonsmooth.errors import OptionError
    from nonsmooth.models import progression

    for state in tomllib.loads(run.attrs["system"]).get("drift", ()):
        try:
            values = progression(run, state)["progression"].values[-_LAST:]
        except OptionError:  # less than a period, or no period at all
            continue
        numbers = ", ".join(f"{value:.6g}" for value in values)
        of = f" (last {values.size} periods)" if values.size > 1 else ""
        yield f"progression of {state}", f"{numbers} per period{of}"
