"""`diagram`: sections of several records over the speed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.errors import OptionError, quote
from nonsmooth.measured.quality.masks import masked, quality_of
from nonsmooth.measured.sections import section
from nonsmooth.version import __version__

__all__ = ["diagram"]

_PER_SPEED = {"rad/s": 1.0, "Hz": 0.5 / math.pi, "rpm": 30.0 / math.pi}
_POINTS = ("parameter", "lane", "point")


def diagram(
    records: Iterable[xr.Dataset],
    *,
    transient: int = 0,
    phase: float = 0.0,
    unit: str | None = None,
    values: npt.ArrayLike | None = None,
    label: str | None = None,
) -> xr.Dataset:
    """Bifurcation diagram of measured motions: a section per record, over its speed.

    Parameters
    ----------
    records : iterable of xarray.Dataset
        Results of `read_csv` or `from_arrays`, or of `section`, one per speed, in any order.

    Other Parameters
    ----------------
    transient : int, optional
        Marks left out at the beginning of each record.
    phase : float, optional
        Part of the revolution at which points are taken, as in `section`.
    unit : {"rad/s", "Hz", "rpm"}, optional
        Unit of the speed; rad/s without it, the ratio to the natural frequency for dimensionless
        records.
    values : array_like, optional
        What the records are set over in place of their speed, one value each.
    label : str, optional
        Label of that, such as ``"gap [mm]"``.

    Returns
    -------
    xarray.Dataset
        As of `bifurcation_diagram`: every variable over ``parameter``, ``lane`` (one) and
        ``point``, nan where a record has fewer points than others; over ``parameter`` and
        ``lane`` ``n_points``, ``speed`` (the mean) and ``speed_spread`` (the standard deviation
        over revolutions). Masks of records go on, as ``x_quality``.

    Raises
    ------
    OptionError
        When there are no records, or they differ in their variables or units.

    See Also
    --------
    nonsmooth.bifurcation_diagram : the same of a system.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> def record(w):
    ...     t = np.arange(4000) / 2000.0
    ...     marks = np.arange(1, int(2 * w / 2 / np.pi)) * 2 * np.pi / w
    ...     return ns.measured.from_arrays({"x": np.cos(w * t)}, times=t, marks=marks)
    >>> diagram = ns.measured.diagram([record(w) for w in (120.0, 100.0)], unit="rpm")
    >>> diagram["parameter"].values.round(1)
    array([ 954.9, 1145.9])
    """
    if isinstance(records, (xr.Dataset, str)) or not isinstance(records, Iterable):
        raise OptionError("records: give a list of results of measured.read_csv or from_arrays")
    sections = [_section(one, transient, phase) for one in records]
    if not sections:
        raise OptionError("records: the list is empty; give one record per speed")
    names, scaled = _common(sections)
    factor, words = _axis(unit, scaled)
    speeds = np.array([one.attrs["speed"] for one in sections]) * factor
    spreads = np.array([one.attrs["speed_spread"] for one in sections]) * factor
    across, across_words = _across(values, label, speeds, words)
    order = np.argsort(across, kind="stable")
    counts = np.array([one.sizes["point"] for one in sections])
    table = np.full((len(names), order.size, 1, int(counts.max())), np.nan)
    for row, k in enumerate(order):
        for i, name in enumerate(names):
            table[i, row, 0, : counts[k]] = sections[k][name].values
    variables: dict[str, Any] = {
        name: (_POINTS, table[i], _words(sections[0][name])) for i, name in enumerate(names)
    }
    spread_words = words | {"long_name": "standard deviation of the speed over revolutions"}
    for key, array, text in (
        ("n_points", counts, {"long_name": "points"}),
        ("speed", speeds, words),
        ("speed_spread", spreads, spread_words),
    ):
        variables[key] = (_POINTS[:2], array[order][:, None], text)
    attrs = {
        "system_name": "measured",
        "nonsmooth_version": __version__,
        "status": "completed",
        "message": "completed",
        "parameter": "speed" if values is None else (label or "value"),
        "phase": float(phase),
        "transient": int(transient),
        "sources": ", ".join(str(sections[k].attrs["system_name"]) for k in order),
    }
    coords = {
        "parameter": ("parameter", across[order], across_words),
        "lane": ("lane", np.arange(1), {"long_name": "initial state"}),
    }
    found = xr.Dataset(variables, coords, attrs)
    return masked(found, _flags([sections[k] for k in order], names), _POINTS)


def _flags(sections: Sequence[xr.Dataset], names: Sequence[str]) -> dict[str, Any]:
    """Flags of the points of each variable that has some in one of the sections."""
    most = max(one.sizes["point"] for one in sections)
    found = {}
    for name in names:
        known = [quality_of(one, name) for one in sections]
        if any(each is not None for each in known):
            table = np.zeros((len(sections), 1, most), np.uint8)
            for row, each in zip(table, known, strict=True):
                if each is not None:
                    row[0, : each.size] = each
            found[name] = table
    return found


def _section(one: Any, transient: int, phase: float) -> xr.Dataset:
    found: xr.Dataset
    if isinstance(one, xr.Dataset) and "point" in one.dims and "speed" in one.coords:
        if transient or phase:
            raise OptionError("transient= and phase= are those of the sections; leave them out")
        found = one
    else:
        found = section(one, transient=transient, phase=phase)
    if "speed" not in found.attrs:
        raise OptionError(
            f"{found.attrs.get('system_name', 'a record')}: one point is left, which has no speed;"
            " take a longer record or a shorter transient="
        )
    return found


def _common(sections: Sequence[xr.Dataset]) -> tuple[list[str], bool]:
    """Names of variables that all sections have, and whether they are dimensionless."""
    first = sections[0]
    names = [str(name) for name in first.data_vars]
    for one in sections[1:]:
        title = one.attrs.get("system_name", "a record")
        if [str(name) for name in one.data_vars] != names:
            raise OptionError(
                f"records differ: {title} has {', '.join(map(str, one.data_vars))}, the first one"
                f" {', '.join(names)}"
            )
        for name in names:
            units = one[name].attrs.get("units", ""), first[name].attrs.get("units", "")
            if units[0] != units[1]:
                raise OptionError(
                    f"records differ in the units of {name}: {title} has {units[0] or 'none'!r},"
                    f" the first one {units[1] or 'none'!r}"
                )
        for key in ("length", "natural_frequency"):
            if one.attrs.get(key) != first.attrs.get(key):
                raise OptionError(f"records differ in their scale: {key} of {title} is another one")
    return names, "natural_frequency" in first.attrs


def _axis(unit: str | None, scaled: bool) -> tuple[float, dict[str, str]]:
    """What speeds are multiplied by, and their label."""
    if scaled:
        if unit is not None:
            raise OptionError("unit: the records are dimensionless; leave it out")
        return 1.0, {"long_name": "speed over the natural frequency"}
    chosen = "rad/s" if unit is None else unit
    if not isinstance(chosen, str) or chosen not in _PER_SPEED:
        raise OptionError(f"unit = {quote(unit)}; known are {', '.join(_PER_SPEED)}")
    return _PER_SPEED[chosen], {"long_name": "speed", "units": chosen}


def _across(
    values: Any, label: Any, speeds: npt.NDArray[np.float64], words: dict[str, str]
) -> tuple[npt.NDArray[np.float64], dict[str, str]]:
    """Values of the records on the axis, and its label."""
    if values is None:
        if label is not None:
            raise OptionError("label= belongs to values=; the speed has its own")
        return speeds, words
    try:
        given = np.asarray(values, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise OptionError(f"values = {quote(values)}: give a number per record") from None
    if given.shape != speeds.shape or not np.all(np.isfinite(given)):
        raise OptionError(f"values: give a finite number for each of the {speeds.size} records")
    from nonsmooth.measured.channel import split_units

    name, units = split_units(label or "value")
    return given, {"long_name": name} | ({"units": units} if units else {})


def _words(values: xr.DataArray) -> dict[str, Any]:
    """Label of a variable; what holds for one record only is left out."""
    kept = ("long_name", "units", "derivative_of")
    return {key: values.attrs[key] for key in kept if key in values.attrs}
