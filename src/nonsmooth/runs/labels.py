"""What every result has: labels, units, names of modes and exits, doubts, parts put together."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from contextlib import suppress
from functools import lru_cache
from typing import Any

import numpy as np
import xarray as xr
from xarray.indexes import PandasIndex

from nonsmooth.engine.tables import PATH_LENGTH, exits_of_path
from nonsmooth.system.system import System

__all__ = ["Columns", "Labels", "assemble", "labels_of", "with_doubts"]

Columns = dict[str, tuple[tuple[str, ...], Any, Mapping[str, Any]]]

# Where dask is installed, xarray imports it for the first index that it makes. Of two threads that
# do so at once one finds half a module; here one imports it for all.
with suppress(ImportError):
    importlib.import_module("dask.base")

# not public, so it is taken only where it is found
_direct = getattr(xr.Dataset, "_construct_direct", None)


class Labels:
    """Words of one system, looked up once."""

    def __init__(self, system: System) -> None:
        self.system = system.to_toml()
        self.modes = system.mode_names
        self.states = np.array(system.states)
        self.state_index = PandasIndex(self.states, "state", coord_dtype=self.states.dtype)
        self._texts = {
            name: _label(system.describe.get(name, name))
            for name in ("time", *system.states, *system.outputs, *system.slow)
        }
        exits = system.compiled.exit_names
        self.width = 1 + max(len(of_mode) for of_mode in exits)
        # exits of each mode in turn; the last place of a mode stands for the start
        rows = [[*names, *[""] * (self.width - 1 - len(names))] for names in exits]
        self.names = [name for row in rows for name in [*row, "start"]]
        self.paths = [name for row in rows for name in [*row, ""]]
        self._targets = system.compiled.program.exits["target"]

    def attributes(self, name: str) -> dict[str, str]:
        """``long_name`` and ``units`` of a variable from the system's descriptions."""
        return self._texts[name]

    @property
    def mode_type(self) -> type[np.signedinteger[Any]]:
        """Integer in which results keep numbers of modes, -1 among them."""
        return np.int8 if len(self.modes) <= np.iinfo(np.int8).max else np.int16

    def mode_flags(self, long_name: str) -> dict[str, Any]:
        """CF flags that say which mode an integer stands for."""
        values = np.arange(len(self.modes), dtype=self.mode_type)
        return {
            "long_name": long_name,
            # netCDF does not tell one value from a list of one
            "flag_values": values if len(values) > 1 else values[0],
            "flag_meanings": " ".join(self.modes),
        }

    def leads_back(self, mode: int, way: int) -> bool:
        """Whether an exit of a mode leads back to that mode."""
        return int(self._targets[mode, way]) == mode

    def path(self, mode: int, path: int, passes: int) -> str:
        """Names of the exits passed at one instant, joined by '>'."""
        names = []
        for way in exits_of_path(path, passes):
            names.append(self.paths[mode * self.width + way])
            mode = int(self._targets[mode, way])
        return ">".join(names) + (">..." if passes > PATH_LENGTH else "")


@lru_cache(maxsize=32)
def labels_of(system: System) -> Labels:
    """Labels of a system; the last few systems are remembered."""
    return Labels(system)


def _label(text: str) -> dict[str, str]:
    if text.endswith("]") and "[" in text:
        label, units = text[:-1].rsplit("[", 1)
        return {"long_name": label.strip(), "units": units.strip()}
    return {"long_name": text}


def _doubts(uncertain: int, estimated: int) -> str:
    """What stands against the certificate of a run, "" where nothing does."""
    if uncertain:
        events = "event depends" if uncertain == 1 else "events depend"
        return (
            f"{uncertain} {events} on rounding: tangencies, or guards that are zero at the same"
            " instant"
        )
    return f"the error of {estimated} steps is estimated" if estimated else ""


def with_doubts(message: str, uncertain: int, estimated: int) -> str:
    """A message with what stands against the certificate of its run."""
    against = _doubts(uncertain, estimated)
    return f"{message}; {against}" if against else message


def assemble(
    variables: Columns,
    coords: Columns,
    indexes: Mapping[str, PandasIndex],
    attrs: Mapping[str, Any],
) -> xr.Dataset:
    """Dataset of variables given as (dimensions, array, attributes).

    The same as ``xr.Dataset(variables, coords, attrs)``, which aligns and merges what may come
    from anywhere and so takes longer than a short run. The variables of a run have common
    dimensions by construction, and xarray has a short way for such variables.
    """
    if _direct is None:
        return xr.Dataset(variables, coords, attrs)
    whole: dict[Any, xr.Variable] = {
        name: xr.Variable(dims, values, words, fastpath=True)
        for name, (dims, values, words) in {**variables, **coords}.items()
    }
    for index in indexes.values():
        whole |= index.create_variables(whole)
    dataset: xr.Dataset = _direct(whole, set(coords), None, dict(attrs), dict(indexes))
    return dataset
