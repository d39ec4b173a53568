"""Maps of several initial states beside each other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import OptionError

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["maps_of_starts"]


def maps_of_starts(
    make: Callable[..., xr.Dataset], given: Sequence[Any], store: str | Path | None
) -> xr.Dataset:
    """Maps of initial states over a dimension ``lane``, one after the other.

    ``make`` computes one of them, given ``initial`` and ``store``. After an interruption those that
    were begun are there.
    """
    import xarray as xr

    if not given:
        raise OptionError("initial: the list is empty; give a state, or leave it out for rest")
    if store is not None:
        Path(store).mkdir(exist_ok=True)
    maps: list[xr.Dataset] = []
    for lane, initial in enumerate(given):
        folder = None if store is None else Path(store) / f"lane-{lane:03d}"
        maps.append(make(initial=initial, store=folder))
        if maps[-1].attrs["status"] != "completed":
            break
    lanes = xr.DataArray(np.arange(len(maps)), dims="lane", attrs={"long_name": "initial state"})
    whole = xr.concat(maps, lanes.rename("lane"), combine_attrs="override", join="exact")
    told = [f"lane {lane}: {each.attrs['message']}" for lane, each in enumerate(maps)]
    return whole.assign_attrs(
        status=maps[-1].attrs["status"],
        message="; ".join(told),
        initial=str([each.attrs["initial"] for each in maps]),
    )
