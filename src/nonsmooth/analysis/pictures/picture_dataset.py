"""The dataset of a bifurcation picture: attractors of columns, and branches one behind another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor import Attractor
from nonsmooth.analysis.basins.attractor_dataset import share_error
from nonsmooth.analysis.pictures.columns import Column
from nonsmooth.analysis.statistics.escape import escape_rate_below
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["picture_dataset"]

Integers = npt.NDArray[np.int64]

# What is kept of each branch, beside its states and its parameter
_OF_POINTS = (
    "stable",
    "admissible",
    "arclength",
    "length",
    "leg_time",
    "word",
    "residual",
    "multipliers",
    "strobes",
    "strobe_times",
)
_OF_SPECIALS = ("kind", "value", "point", "test", "detail", "multiplier")


def picture_dataset(
    system: System,
    parameter: str,
    columns: Sequence[Column],
    numbers: Sequence[Integers],
    branches: Sequence[xr.Dataset],
    points: int,
    attrs: dict[str, Any],
) -> xr.Dataset:
    """All that was found, as one dataset."""
    import xarray as xr

    data = _of_columns(system, parameter, columns, numbers, points)
    parts = [_kept(branch, i, parameter) for i, branch in enumerate(branches)]
    if parts:
        legs = max(one.sizes["leg"] for one, _ in parts)
        over_points = xr.concat(
            [one.pad(leg=(0, legs - one.sizes["leg"])) for one, _ in parts],
            "point", coords="minimal",
        )  # fmt: skip
        over_specials = xr.concat([one for _, one in parts], "special", coords="minimal")
        data = data.merge(over_points).merge(over_specials)
        data["branch_period"] = (
            "branch", np.array([int(each.attrs["period"]) for each in branches]),
            {"long_name": "periods in one turn"},
        )  # fmt: skip
        for end in ("end_first", "end_last", "message"):
            data[f"branch_{end}"] = ("branch", np.array([b.attrs[end] for b in branches], str))
    data.attrs = attrs
    return data


def _of_columns(
    system: System,
    parameter: str,
    columns: Sequence[Column],
    numbers: Sequence[Integers],
    points: int,
) -> xr.Dataset:
    """Variables over the values of the parameter and the attractors."""
    import xarray as xr

    count = max((int(own.max(initial=0)) for own in numbers), default=0)
    shape = len(columns), count
    settled = np.full((*shape, points, len(system.states)), np.nan)
    share, exponent = np.full(shape, np.nan), np.full(shape, np.nan)
    error, period = np.full(shape, np.nan), np.zeros(shape, np.int64)
    chaotic_for = np.zeros(shape, np.int64)
    kind = np.full(shape, "", "<U14")
    rest = {name: np.zeros(len(columns)) for name in ("unsettled", "ended")}
    sizes = np.array([max(1, column.labels.size) for column in columns])
    for k, (column, own) in enumerate(zip(columns, numbers, strict=True)):
        for i, (one, number) in enumerate(zip(column.attractors, own.tolist(), strict=True)):
            at = k, number - 1
            last = _shown(one, points)
            settled[at][: len(last)] = last
            share[at] = np.mean(column.labels == i + 1)
            exponent[at], error[at] = one.exponent, one.exponent_error
            period[at], kind[at], chaotic_for[at] = one.period, one.kind, one.chaotic_for
        rest["unsettled"][k] = np.mean(column.labels == 0)
        rest["ended"][k] = np.mean(column.labels < 0)
    over = ("parameter", "attractor")
    label = system.describe.get(parameter, parameter)
    variables: dict[str, Any] = {
        "settled": (
            (*over, "strobe", "state"), settled, {"long_name": "points of the attractor"},
        ),
        "kind": (over, kind, {"long_name": "kind of motion, empty where it is none"}),
        "period": (over, period, {"long_name": "points of a cycle, 0 where none repeats"}),
        "fraction": (over, share, {"long_name": "share of the starts"}),
        "fraction_error": (
            over, share_error(share, 1) / np.sqrt(sizes)[:, None],
            {"long_name": "standard error of that share"},
        ),
        "exponent": (over, exponent, {"long_name": "largest exponent per period, of no cycle"}),
        "exponent_error": (over, error, {"long_name": "standard error of the exponent"}),
        "chaotic_for": (over, chaotic_for, {"long_name": "periods of chaos without an end"}),
        "escape_rate_below": (
            over, escape_rate_below(chaotic_for),
            {"long_name": "bound of the rate per period at which it may end"},
        ),
        "unsettled": ("parameter", rest["unsettled"], {"long_name": "share of unsettled starts"}),
        "ended": ("parameter", rest["ended"], {"long_name": "share of starts that ended early"}),
    }  # fmt: skip
    coords = {
        "parameter": (
            "parameter", np.array([column.value for column in columns], float),
            {"long_name": label},
        ),
        "attractor": ("attractor", np.arange(1, count + 1), {"long_name": "attractor"}),
        "state": ("state", list(system.states)),
    }  # fmt: skip
    return xr.Dataset(variables, coords)


def _shown(one: Attractor, points: int) -> Any:
    """Points of an attractor that are kept: those of a cycle, or the last ones of a set."""
    return one.points[:points] if one.is_cycle else one.points[-points:]


def _kept(branch: xr.Dataset, number: int, parameter: str) -> tuple[xr.Dataset, xr.Dataset]:
    """What is kept over the points and over the special points of a branch."""
    states = [str(name) for name in branch["state"].values]
    more = [
        str(name) for name in branch.data_vars if str(name).endswith(("_per_period", "_per_time"))
    ]
    names = dict.fromkeys([*states, parameter, *_OF_POINTS, *more])
    over_points = branch[[name for name in names if name in branch]].drop_vars(
        ["time", "state", "point", "drift_state"], errors="ignore"
    )
    over_points["branch_of_point"] = ("point", np.full(branch.sizes["point"], number))
    over_specials = branch[[f"special_{name}" for name in _OF_SPECIALS]].drop_vars(
        ["time", "state", "point", "drift_state"], errors="ignore"
    )
    over_specials["branch_of_special"] = ("special", np.full(branch.sizes["special"], number))
    for each in (over_points, over_specials):
        each.attrs = {}
    return over_points, over_specials
