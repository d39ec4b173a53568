"""What verbs say of the options that they share: one text, which each docstring repeats.

The texts stand in the docstring of `nonsmooth.analysis.options.SharedOptions`. They are repeated
and not filled in when the package is loaded, so that the source, ``help()`` and an editor all show
them.
"""

import inspect
from collections.abc import Iterator

import pytest
from numpydoc.docscrape import NumpyDocString, Parameter

from house.public import callables
from nonsmooth.analysis.options import SharedOptions

ROOMS = ("nonsmooth.analysis.", "nonsmooth.runs.simulate")
OTHER_MEANING = {("local_regimes", "tolerance")}  # of a fit


def rows(thing) -> list[Parameter]:
    """Arguments that a docstring explains."""
    doc = NumpyDocString(inspect.getdoc(thing) or "")
    return [*doc["Parameters"], *doc["Other Parameters"]]


def words(row: Parameter) -> str:
    """The text of an argument in one line."""
    return " ".join(" ".join(row.desc).split())


SHARED = {row.name: row for row in rows(SharedOptions)}


def uses() -> Iterator[tuple[str, Parameter, str]]:
    """Every place where a verb explains a shared option, with the option's name."""
    for verb, thing in callables():
        for row in rows(thing) if thing.__module__.startswith(ROOMS) else ():
            for name in row.name.split(", "):
                if name in SHARED and (verb, name) not in OTHER_MEANING:
                    yield verb, row, name


def test_the_source_explains_every_option():
    """The record and its docstring have the same names."""
    assert list(SHARED) == list(inspect.signature(SharedOptions).parameters)


@pytest.mark.parametrize("option", SHARED)
def test_shared_options_are_explained_alike(option):
    """A reader who knows an option of one verb knows it of all; more may follow the shared text."""
    source = SHARED[option]
    kind, text = source.type.removesuffix(", optional"), words(source)
    places = [(verb, row) for verb, row, name in uses() if name == option]
    faults = [
        f"{verb}: {row.name} : {row.type}\n    {words(row)}"
        for verb, row in places
        if not (row.name == option and row.type.startswith(kind) and words(row).startswith(text))
    ]
    assert len(places) > 1
    assert not faults, (
        f"begin with the text in analysis/options.py, {option} : {source.type}\n    {text}\n"
        + "\n".join(faults)
    )
