"""Single items of the chapter, a figure or a claim, computed into a folder."""

from __future__ import annotations

import importlib
import time
import traceback
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from nonsmooth_chapter.entries import basis, read_entry, write_entry

__all__ = ["Item", "do_item"]


class Item(NamedTuple):
    """A figure or a claim, and the function that makes it.

    Parameters
    ----------
    kind : str
        ``"figure"`` or ``"claim"``.
    name : str
        Its name, such as ``"fig8"``.
    module, function : str
        Where it is made. Of a figure the function draws; of a claim it takes the name and returns
        its `Check` and a function that judges.
    title : str, optional
        What a figure shows.

    Examples
    --------
    >>> Item("claim", "M03", "nonsmooth_chapter.claims", "check_of").name
    'M03'
    """

    kind: str
    name: str
    module: str
    function: str
    title: str = ""


def do_item(item: Item, folder: Path) -> dict[str, Any]:
    """Compute an item, unless the folder has it from the same code and options.

    Parameters
    ----------
    item : Item
        What to compute.
    folder : pathlib.Path
        Folder of the results.

    Returns
    -------
    dict
        ``name``, ``kind``, ``state`` ("done", "kept" or "fault") and ``told``; of a fault
        ``message`` and ``trace`` in place of the last.

    Examples
    --------
    >>> import tempfile
    >>> item = Item("claim", "M03", "nonsmooth_chapter.claims", "check_of")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = [do_item(item, Path(folder))["state"] for _ in range(2)]
    >>> found
    ['done', 'kept']
    """
    named = {"name": item.name, "kind": item.kind}
    try:
        function = getattr(importlib.import_module(item.module), item.function)
        make = {"figure": _figure, "claim": _claim}[item.kind]
        state, told = make(item, function, folder)
    except Exception as fault:  # of one figure; the others go on
        said = f"{type(fault).__name__}: {fault}"
        return named | {"state": "fault", "message": said, "trace": traceback.format_exc()}
    return named | {"state": state, "told": told}


def _figure(item: Item, draw: Callable[..., Any], folder: Path) -> tuple[str, dict[str, Any]]:
    depends = basis(draw)
    kept = read_entry(folder, item.name, depends)
    if kept is not None:
        return "kept", kept
    from nonsmooth_chapter.figure_files import write_figure

    (figure, data), told = _watched(draw)
    files = write_figure(item.name, item.title, figure, data, folder)
    told |= {
        "files": [path.name for path in files],
        "options": depends["options"],
        "attributes": {str(name): value for name, value in data.attrs.items()},
    }
    write_entry(folder, item.name, depends, files, told)
    return "done", told


def _claim(item: Item, check_of: Callable[..., Any], folder: Path) -> tuple[str, dict[str, Any]]:
    check, judge = check_of(item.name)
    depends = basis(check.compute)
    kept = read_entry(folder, item.name, depends)
    if kept is not None:
        return "kept", kept
    row, told = _watched(judge)
    told |= {"row": row}
    write_entry(folder, item.name, depends, [], told)
    return "done", told


def _watched(function: Callable[[], Any]) -> tuple[Any, dict[str, Any]]:
    """Result of a function, how long it took and worked, and what it warned of."""
    began, worked = time.monotonic(), time.process_time()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        result = function()
    said = list(dict.fromkeys(str(each.message) for each in caught))
    told = {
        "seconds": round(time.monotonic() - began, 2),
        "processor_seconds": round(time.process_time() - worked, 2),  # of all threads
        "warnings": said,
    }
    return result, told
