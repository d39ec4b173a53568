"""Files of figures, tables and claims: netCDF, CSV, JSON; they appear whole or not at all."""

from __future__ import annotations

import csv
import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "plain",
    "processors",
    "replacing",
    "save_data",
    "save_json",
    "save_table",
    "unknown_name",
]


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """Give a temporary path beside a file, and move it to the file's place on success.

    A reader, or a crash half way, never meets half a file. The process number keeps two
    programs that write the same file apart.
    """
    draft = target.with_name(f".{target.stem}.{os.getpid()}{target.suffix}")
    try:
        yield draft
        os.replace(draft, target)
    finally:
        draft.unlink(missing_ok=True)


def processors() -> int:
    """Number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return max(1, len(os.sched_getaffinity(0)))
    return os.cpu_count() or 1


def unknown_name(kind: str, name: str, known: Iterable[str]) -> str:
    """Sentence for a name that does not exist: the nearest one, and where all are listed."""
    near = get_close_matches(name, list(known), n=1)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    return f"unknown {kind} {name!r:.80}{hint} (known: {', '.join(known)})"


def save_data(data: xr.Dataset, path: Path) -> Path:
    """Write a dataset as netCDF.

    Parameters
    ----------
    data : xarray.Dataset
        The data.
    path : pathlib.Path
        File to write; its folder exists.

    Returns
    -------
    pathlib.Path
        The file.

    Examples
    --------
    >>> import tempfile
    >>> import xarray as xr
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_data(xr.Dataset({"x": 1.0}), Path(folder) / "x.nc").name
    'x.nc'
    """
    with replacing(path) as draft:
        data.to_netcdf(draft, engine="h5netcdf")
    return path


def save_table(rows: Sequence[Mapping[str, Any]], path: Path) -> Path:
    """Write rows with the same keys as a CSV file with a header.

    Parameters
    ----------
    rows : sequence of mapping
        The rows, at least one.
    path : pathlib.Path
        File to write; its folder exists.

    Returns
    -------
    pathlib.Path
        The file.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_table([{"b": 0.15, "v": 31.3}], Path(folder) / "t.csv").read_text().split()
    ['b,v', '0.15,31.3']
    """
    with replacing(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
    return path


def save_json(value: Any, path: Path) -> Path:
    """Write a value as JSON.

    Parameters
    ----------
    value : object
        Mappings, lists, numbers and texts, see `plain`.
    path : pathlib.Path
        File to write; its folder exists.

    Returns
    -------
    pathlib.Path
        The file.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_json({"v": 1.5}, Path(folder) / "v.json").read_text().split()
    ['{', '"v":', '1.5', '}']
    """
    with replacing(path) as draft:
        draft.write_text(json.dumps(plain(value), indent=2, ensure_ascii=False), encoding="utf-8")
    return path


def plain(value: Any) -> Any:
    """Value in the types of JSON, which has neither arrays of numpy nor infinities.

    Parameters
    ----------
    value : object
        Mappings, lists, arrays, numbers and texts.

    Returns
    -------
    object
        The same; None for what is not finite, and text for what JSON has no type for.

    Examples
    --------
    >>> import numpy as np
    >>> plain({"v": np.array([1.0, np.inf])})
    {'v': [1.0, None]}
    """
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if value is None or isinstance(value, str | bool | int | float):
        return value
    return str(value)
