"""A dataset put together from variables that belong together."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr
from xarray.indexes import PandasIndex

__all__ = ["Columns", "assemble"]

# not public, so it is taken only where it is found
_direct = getattr(xr.Dataset, "_construct_direct", None)

Columns = dict[str, tuple[tuple[str, ...], Any, Mapping[str, Any]]]


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
