"""`Channel`: a column of readings, and what a reading stands for."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, quote
from nonsmooth.runs.options import finite_number

__all__ = ["Channel", "channels_of", "split_units", "units_of"]

_TAKEN = ("time", "mark", "mark_time", "point", "parameter", "lane", "speed", "phase", "mode")


@dataclass(frozen=True)
class Channel:
    """A column of a file with its calibration.

    The displacement is (reading - offset) / sensitivity, as data sheets of probes have it.

    Parameters
    ----------
    column : str or int
        Header of the column, with or without its units in brackets; or its number, from 0.
    sensitivity : float, optional
        Reading per unit of displacement, such as 7.87 V/mm; negative where the reading falls as
        the displacement grows.
    offset : float, optional
        Reading at zero displacement.
    units : str, optional
        Units of the displacement; those in the header without a sensitivity. Other ones than those
        in the header need a sensitivity, which converts the readings.
    long_name : str, optional
        What it is, for the labels of axes.

    Raises
    ------
    OptionError
        When the column is neither a text nor a number, or a value cannot be that of a probe.

    See Also
    --------
    read_csv : takes channels.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> probe = ns.measured.Channel("CH1 [V]", sensitivity=7.87, offset=-9.6, units="mm")
    >>> float(probe.displacement([-9.6, -1.73])[1])
    1.0
    """

    column: str | int
    sensitivity: float | None = None
    offset: float = 0.0
    units: str = ""
    long_name: str = ""

    def __post_init__(self) -> None:
        if isinstance(self.column, bool) or not isinstance(self.column, (str, int)):
            raise OptionError(
                f"column = {quote(self.column)}: give the header of a column, or its number"
            )
        for name in ("units", "long_name"):
            if not isinstance(getattr(self, name), str):
                raise OptionError(f"{name} = {quote(getattr(self, name))} is not a text")
        object.__setattr__(self, "offset", finite_number("offset", self.offset))
        if self.sensitivity is None:
            return
        value = finite_number("sensitivity", self.sensitivity)
        if value == 0.0:
            raise OptionError("sensitivity = 0: the reading must change with the displacement")
        object.__setattr__(self, "sensitivity", value)
        if not self.units:
            raise OptionError(
                f"sensitivity = {value:g}: name the units= of the displacement too, such as 'mm'"
            )

    def displacement(self, readings: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Displacements that some readings stand for.

        Parameters
        ----------
        readings : array_like
            Numbers of the column.

        Returns
        -------
        ndarray
            In ``units``.
        """
        try:
            given = np.asarray(readings)
        except (TypeError, ValueError):
            given = np.array("")
        if given.dtype.kind not in "iuf":
            raise OptionError(f"readings = {quote(readings)}: give numbers")
        away = given.astype(float) - self.offset
        return away if self.sensitivity is None else away / self.sensitivity


def channels_of(columns: Any, *, reserved: bool = True) -> dict[str, Channel]:
    """Channels by the names that variables are to have; of a record some names are reserved."""
    if isinstance(columns, str) or not isinstance(columns, (Mapping, Iterable)):
        raise OptionError(
            f"columns = {quote(columns)}: give the names of columns, such as ['x', 'y'], or a"
            " mapping of variables to columns, such as {'x': 'probe 1'}"
        )
    pairs = columns.items() if isinstance(columns, Mapping) else [(name, name) for name in columns]
    found: dict[str, Channel] = {}
    for name, column in pairs:
        check_name(name, found, _TAKEN if reserved else ("row", "line"))
        found[name] = column if isinstance(column, Channel) else Channel(column)
    if not found:
        raise OptionError("columns= is empty; name one column at least")
    return found


def check_name(name: Any, others: Iterable[str], taken: Iterable[str] = _TAKEN) -> None:
    """Refuse what cannot be the name of a variable."""
    if not isinstance(name, str) or not name.isidentifier():
        raise OptionError(
            f"columns: {quote(name)} cannot be the name of a variable, which is made of letters,"
            " digits and _; give a mapping such as {'x': 'probe 1'}"
        )
    if name in taken:
        raise OptionError(f"columns: the name {name!r} is taken; call the variable otherwise")
    if name in others:
        raise OptionError(f"columns: {name!r} is named twice")


def units_of(name: str, channel: Channel, header: str) -> str:
    """Units of a variable whose column has some units in its header, or none."""
    told = channel.units
    if channel.sensitivity is None and told and header and _plain(told) != _plain(header):
        raise OptionError(
            f"{name}: the header of its column has the units {header!r}, and units = {told!r} were"
            f" asked for. To convert give a sensitivity too: how many {header} one {told} is, as"
            " 25.4 for mm and inch. Where the header is wrong give the sensitivity 1, and else"
            " leave the units out"
        )
    return told or header


def _plain(units: str) -> str:
    """Units in one spelling: of micro there are three signs."""
    return units.strip().replace("\N{MICRO SIGN}", "u").replace("\N{GREEK SMALL LETTER MU}", "u")


def split_units(header: str) -> tuple[str, str]:
    """Name and units of a header such as ``x [mm]`` or ``x (mm)``."""
    text = header.strip()
    for opening, closing in ("[]", "()"):
        if text.endswith(closing) and opening in text:
            name, units = text[:-1].rsplit(opening, 1)
            return name.strip(), units.strip()
    return text, ""
