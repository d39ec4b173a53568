"""Integrity of basins over a parameter as a dataset."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.basins.attractor import in_order
from nonsmooth.analysis.basins.region import Grid
from nonsmooth.analysis.measures.integrity_measures import (
    Cells,
    Integrity,
    integrity_of_labels,
)
from nonsmooth.analysis.measures.outcomes import ENDED_EARLY, INADMISSIBLE, LEFT_OUT, UNSETTLED
from nonsmooth.analysis.options import result_attributes
from nonsmooth.analysis.pictures.columns import Column, follow_numbers
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.whole_turns import periods_of
from nonsmooth.system.system import System

__all__ = ["Profile", "erosion_dataset"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_OVER = ("parameter", "attractor")


@dataclass(frozen=True)
class Profile:
    """Basins at some values of a parameter."""

    system: System
    grid: Grid  # the same cells at all values
    scales: Floats
    together: bool  # whether the basins of all attractors are one
    columns: list[Column]  # the attractors at each value
    labels: list[Integers]  # of the cells, by the numbers of the column

    @property
    def names(self) -> list[str]:
        """States of the region."""
        return list(self.grid.completion.given)

    @property
    def missing(self) -> list[str]:
        """States that neither drift nor are in the region."""
        known = {*self.names, *self.system.drift_states}
        return [name for name in self.system.states if name not in known]

    def cells(self, counts: npt.NDArray[np.bool_]) -> Cells:
        """The cells, of which some count."""
        return Cells(self.grid.axes, self.scales, counts, periods_of(self.system, self.names))

    def numbered(self) -> tuple[list[Integers], npt.NDArray[np.int16]]:
        """Numbers along the profile of the attractors of each value, and the labels in them."""
        numbers = self._in_order(follow_numbers(self.columns))
        labels = np.zeros((len(self.columns), *self.grid.shape), np.int16)
        for k, (found, own) in enumerate(zip(self.labels, numbers, strict=True)):
            table = np.concatenate([[0], own])
            labels[k] = np.where(found > 0, table[np.maximum(found, 0)], found).reshape(
                self.grid.shape
            )
        return numbers, labels

    def _in_order(self, numbers: list[Integers]) -> list[Integers]:
        """Numbers in the order of the values at which attractors appear, then as `attractors`."""
        order: list[int] = []
        for column, own in zip(self.columns, numbers, strict=True):
            order += [n for n in own[in_order(column.attractors)].tolist() if n not in order]
        table = np.zeros(len(order) + 1, np.int64)
        table[order] = np.arange(1, len(order) + 1)
        return [table[own] for own in numbers]

    def points_of(self, column: Column) -> list[Floats]:
        """Points of attractors in the states of the region; none where that has not all states."""
        places = [self.system.states.index(name) for name in self.names]
        if self.missing:
            return [np.zeros((0, len(places))) for _ in column.attractors]
        return [each.points[:, places] for each in column.attractors]


def erosion_dataset(
    profile: Profile, parameter: str, options: dict[str, Any], *, complete: bool
) -> xr.Dataset:
    """Dataset over the parameter and the attractors."""
    system, names = profile.system, profile.names
    numbers, labels = profile.numbered()
    most = max((int(own.max(initial=0)) for own in numbers), default=0)
    shares = [
        [float(np.mean(each[each > INADMISSIBLE] == k)) for each in labels]
        for k in (ENDED_EARLY, UNSETTLED)
    ]
    variables = {
        **_of_attractors(profile, numbers, labels, most),
        "ended": ("parameter", shares[0], {"long_name": "share from which motions end early"}),
        "unsettled": ("parameter", shares[1], {"long_name": "share of unsettled starts"}),
        "label": (("parameter", *reversed(names)), labels, {
            "long_name": "attractor",
            "comment": "0: unsettled, -1: ended early, -2: inadmissible"}),
    }  # fmt: skip
    words = labels_of(system)
    coords: dict[str, Any] = {
        "parameter": (
            "parameter", np.array([column.value for column in profile.columns], float),
            {"long_name": system.describe.get(parameter, parameter)},
        ),
        "attractor": ("attractor", np.arange(1, most + 1), {"long_name": "attractor"}),
        "state_of_region": ("state_of_region", names),
        **{name: ((name,), axis, words.attributes(name)) for name, axis in zip(
            names, profile.grid.axes, strict=True)},
    }  # fmt: skip
    status, message = ("completed" if complete else "interrupted"), "completed"
    if not complete:
        message = "interrupted by the user; the values that are done are kept"
    elif profile.missing:
        message = (
            f"the region leaves out {', '.join(profile.missing)}, so attractors need not lie in it"
            " and have no local integrity"
        )
    whole = profile.cells(np.ones(profile.grid.shape, bool))
    attrs = {"parameter": parameter, "half_diagonal": whole.half_diagonal, **options}
    return xr.Dataset(variables, coords, result_attributes(system, status, message, attrs))


def _of_attractors(
    profile: Profile, numbers: list[Integers], labels: npt.NDArray[np.int16], most: int
) -> dict[str, Any]:
    """Measures, kinds and periods over the parameter and the attractors."""
    shape = (len(labels), most)
    kinds, periods = np.full(shape, "", dtype="<U14"), np.zeros(shape, np.int64)
    found: dict[str, Any] = {}
    for name, (dims, values, said) in Integrity(len(profile.names)).variables.items():
        is_text = name.endswith("_limit")
        whole = np.full(
            (*shape, *values.shape[1:]), "" if is_text else np.nan, "<U8" if is_text else float
        )
        found[name] = (("parameter", *dims), whole, said)
    for k, (column, own) in enumerate(zip(profile.columns, numbers, strict=True)):
        cells = profile.cells(~np.isin(labels[k], LEFT_OUT))
        together = set(own.tolist()) if profile.together else set()
        measured = integrity_of_labels(
            cells, labels[k].astype(np.int64), own.tolist(), profile.points_of(column), together
        )
        for name, (_, values, _) in measured.variables.items():
            found[name][1][k, own - 1] = values
        kinds[k, own - 1] = [each.kind for each in column.attractors]
        periods[k, own - 1] = [each.period for each in column.attractors]
    found["kind"] = (_OVER, kinds, {"long_name": "kind of motion, empty where there is none"})
    found["period"] = (_OVER, periods, {"long_name": "points of a cycle, 0 where none repeats"})
    return found
