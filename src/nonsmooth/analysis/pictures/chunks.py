"""The work of a picture in chunks, one after another; those of a store are read, not done again.

What a chunk computes depends on those before it alone, and so does how many follow. So a picture
that was interrupted comes to the same chunks in the same order, and its result is the same.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor import Attractor
from nonsmooth.analysis.basins.recurrences import Known, Measure
from nonsmooth.runs.store import Store

__all__ = ["Chunks", "open_chunks", "pack_known", "unpack_known"]

T = TypeVar("T")
Arrays = dict[str, npt.NDArray[Any]]

_MOST = 1_000_000  # files of a store have numbers of six digits


@dataclass
class Chunks:
    """Does each chunk, or reads it from the store where it is there; without a store does all."""

    store: Store | None = None
    _number: int = field(default=0, init=False)

    def take(
        self,
        compute: Callable[[], T],
        pack: Callable[[T], Mapping[str, npt.NDArray[Any]]],
        unpack: Callable[[Arrays], T],
        whole: Callable[[T], bool] = lambda _: True,
    ) -> T:
        """Result of the next chunk; one that is not ``whole`` is not kept."""
        number, store = self._number, self.store
        self._number += 1
        if store is not None and number in store.done:
            return unpack(store.get(number))
        result = compute()
        if store is not None and whole(result):
            store.put(number, pack(result))
        return result


@contextmanager
def open_chunks(store: str | Path | None, protocol: Mapping[str, Any]) -> Iterator[Chunks]:
    """Chunks of a folder, or of none."""
    if store is None:
        yield Chunks()
        return
    with Store.open(store, protocol, _MOST) as folder:
        yield Chunks(folder)


def pack_known(known: Known, prefix: str = "") -> Arrays:
    """Arrays of the attractors that a search knows, with all that it needs to go on."""
    measure, (keys, owner) = known.measure, known.cells
    arrays: Arrays = {
        "columns": measure.columns, "scale": measure.scale, "cell": np.array(measure.cell),
        "keys": keys, "owner": owner, "attractors": np.array(len(known.attractors)),
    }  # fmt: skip
    for i, one in enumerate(known.attractors):
        for each in fields(Attractor):
            if (value := getattr(one, each.name)) is not None:
                arrays[f"{i}.{each.name}"] = np.asarray(value)
    return {prefix + name: array for name, array in arrays.items()}


def unpack_known(arrays: Mapping[str, npt.NDArray[Any]], prefix: str = "") -> Known:
    """The same again of arrays that `pack_known` made."""
    own = {name.removeprefix(prefix): a for name, a in arrays.items() if name.startswith(prefix)}
    found = [_attractor(own, f"{i}.") for i in range(int(own["attractors"]))]
    measure = Measure(own["columns"], own["scale"], float(own["cell"]))
    return Known.of(measure, found, own["keys"], own["owner"])


def _attractor(arrays: Mapping[str, npt.NDArray[Any]], prefix: str) -> Attractor:
    """An attractor from the arrays of its fields; what was None has none."""
    values: dict[str, Any] = {}
    for each in fields(Attractor):
        if (array := arrays.get(prefix + each.name)) is not None:
            values[each.name] = array if array.ndim else array.item()
    return Attractor(**values)
