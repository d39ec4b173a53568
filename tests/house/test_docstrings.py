"""Docstrings agree with signatures; only a test notices when one of them changes alone."""

import inspect

from numpydoc.docscrape import NumpyDocString

from house.public import arguments, callables


def documented(thing) -> list[str]:
    """Names that the docstring explains; ``x, y : float`` counts as two."""
    doc = NumpyDocString(inspect.getdoc(thing) or "")
    sections = ["Parameters", "Other Parameters"]
    if inspect.isclass(thing) and not doc["Parameters"]:
        sections.append("Attributes")
    rows = [row.name for section in sections for row in doc[section]]
    return [name.strip(" *") for row in rows for name in row.split(",")]


def test_every_argument_is_documented():
    """A user cannot guess what an argument means, nor in which unit it is."""
    faults = [
        f"{name}: {argument}"
        for name, thing in callables()
        for argument in arguments(thing)
        if argument not in documented(thing)
    ]
    assert not faults, "explain under Parameters or Other Parameters:\n" + "\n".join(faults)


def test_every_documented_argument_exists():
    """A documented argument that is gone sends users into an error."""
    faults = [
        f"{name}: {argument}"
        for name, thing in callables()
        for argument in documented(thing)
        if argument not in arguments(thing)
    ]
    assert not faults, "documented, yet not in the signature:\n" + "\n".join(faults)
