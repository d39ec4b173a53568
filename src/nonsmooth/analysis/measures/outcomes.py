"""Outcomes of starts as an array of labels, out of whatever holds one."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.errors import OptionError, quote
from nonsmooth.version import __version__

__all__ = ["LEFT_OUT", "Outcomes", "blocks_of", "outcome_name", "outcomes_of"]

UNSETTLED, ENDED_EARLY, INADMISSIBLE, NOT_COMPUTED = 0, -1, -2, -3
LEFT_OUT = (UNSETTLED, INADMISSIBLE, NOT_COMPUTED)  # no outcome is known of these
_NAMES = {
    UNSETTLED: "unsettled",
    ENDED_EARLY: "ended early",
    INADMISSIBLE: "inadmissible",
    NOT_COMPUTED: "not computed",
}
_BLOCKS = 8  # per side; they should be longer than what is correlated
_KEPT = ("system", "system_name")

Labels = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Outcomes:
    """Label of each start, which of them count, and where they come from."""

    labels: Labels
    counts: npt.NDArray[np.bool_]  # same shape; starts whose outcome is known
    left_out: tuple[int, ...]
    n_attractors: int  # of a dataset, whether starts lead to them or not
    attrs: dict[str, Any]

    @property
    def numbers(self) -> Labels:
        """Labels that occur among the starts that count, in order."""
        return np.unique(self.labels[self.counts])


def outcomes_of(basins: Any, leave_out: Iterable[int] = LEFT_OUT) -> Outcomes:
    """Labels in a dataset of basins, in a variable of it, or in any array of whole numbers.

    Truth values stand for two outcomes: 1 where they are false, 2 where they are true.
    """
    attrs: dict[str, Any] = {}
    known = 0
    array = basins
    if isinstance(basins, xr.Dataset):
        if "label" not in basins:
            raise OptionError(
                "the dataset has no variable 'label'; give a result of basins_of_attraction, or"
                " an array of whole numbers"
            )
        attrs = {key: basins.attrs[key] for key in _KEPT if key in basins.attrs}
        known = basins.sizes.get("attractor", 0)
        array = basins["label"]
    try:
        labels = np.asarray(array.values if isinstance(array, xr.DataArray) else array)
    except ValueError:  # rows of different lengths
        raise OptionError(
            f"basins = {quote(basins)}: give an array of whole numbers, one label per start"
        ) from None
    if labels.dtype.kind == "b":  # two outcomes; 0 would stand for none
        labels = labels.astype(np.int64) + 1
    if labels.ndim == 0 or labels.size == 0 or labels.dtype.kind not in "iu":
        raise OptionError(
            f"basins: an array of whole numbers is needed, one label per start, not"
            f" {labels.dtype} in {labels.ndim} dimensions with {labels.size} values"
        )
    out = _check_labels(leave_out)
    counts = ~np.isin(labels, out)
    if not counts.any():
        raise OptionError(
            f"all {labels.size} cells have one of the labels {', '.join(map(str, out))}, which are"
            " left out; label outcomes from 1 on, or change leave_out="
        )
    attrs |= {"nonsmooth_version": __version__, "leave_out": " ".join(map(str, out))}
    return Outcomes(labels.astype(np.int64), counts, out, known, attrs)


def outcome_name(label: int) -> str:
    """What a label says, in words."""
    return _NAMES.get(int(label), f"attractor {label}")


def blocks_of(shape: tuple[int, ...]) -> tuple[Labels, int]:
    """Number of the block of each cell, and of blocks: eight per side."""
    number = np.zeros(shape, np.int64)
    count = 1
    for axis, size in enumerate(shape):
        parts = min(_BLOCKS, size)
        along = np.arange(size) * parts // size
        number = number * parts + along.reshape([-1 if k == axis else 1 for k in range(len(shape))])
        count *= parts
    return number, count


def _check_labels(leave_out: Any) -> tuple[int, ...]:
    try:
        out = tuple(int(label) for label in leave_out)
        whole = all(a == b for a, b in zip(out, leave_out, strict=True))
    except (TypeError, ValueError, OverflowError):
        whole = False
    if not whole:
        raise OptionError(f"leave_out = {quote(leave_out)}: give labels, such as (0, -2)")
    return out
