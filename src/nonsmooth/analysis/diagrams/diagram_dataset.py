"""A bifurcation diagram as an xarray dataset."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.diagrams.columns import DiagramProtocol, Look
from nonsmooth.analysis.diagrams.strobe_periods import said_of_restless
from nonsmooth.analysis.options import result_attributes
from nonsmooth.engine.status import Status
from nonsmooth.runs.labels import labels_of

__all__ = ["diagram_dataset"]

_LANES = ("parameter", "lane")
_POINTS = ("parameter", "lane", "point")


def diagram_dataset(
    protocol: DiagramProtocol,
    grid: npt.NDArray[np.float64],
    looks: list[list[Look | None]],
    options: dict[str, Any],
    complete: bool,
) -> xr.Dataset:
    """Dataset of what every column and lane showed; None where it was not computed.

    Columns of which no lane was computed are left out, so an interrupted diagram is as large as
    what it shows.
    """
    n_wanted = grid.size
    done = [i for i, row in enumerate(looks) if any(one is not None for one in row)]
    shape = (len(done), len(looks[0]))
    grid, looks = grid[done], [looks[i] for i in done]
    system, labels = protocol.system, labels_of(protocol.system)
    most = max((len(one.points) for row in looks for one in row if one is not None), default=0)
    names = [*system.states, *(system.outputs if protocol.outputs else ())]
    points = np.full((*shape, most, len(names)), np.nan)
    modes = np.full((*shape, most), -1, labels.mode_type)
    for i, j, one in _each(looks):
        points[i, j, : len(one.points), : one.points.shape[1]] = one.points
        modes[i, j, : len(one.modes)] = one.modes
    variables: dict[str, Any] = {
        name: (_POINTS, points[..., k], labels.attributes(name)) for k, name in enumerate(names)
    }
    variables["mode"] = (_POINTS, modes, labels.mode_flags("mode"))
    variables |= _of_lanes(protocol, looks, shape)
    label = system.describe.get(protocol.parameter, protocol.parameter)
    coords = {
        "parameter": (("parameter",), grid, {"long_name": label}),
        "lane": (("lane",), np.arange(shape[1]), {"long_name": "initial state"}),
    }
    message = f"interrupted by the user; {len(done)} of {n_wanted} columns are done and kept"
    if complete:
        every = [one for _, _, one in _each(looks)]
        message = _message(protocol, every) + _said_of_events(protocol, every, options["at"])
    status = "completed" if complete else "interrupted"
    told = {"parameter": protocol.parameter, **options}
    return xr.Dataset(variables, coords, result_attributes(system, status, message, told))


def _each(looks: list[list[Look | None]]) -> Any:
    for i, row in enumerate(looks):
        for j, one in enumerate(row):
            if one is not None:
                yield i, j, one


def _of_lanes(
    protocol: DiagramProtocol, looks: list[list[Look | None]], shape: tuple[int, int]
) -> dict[str, Any]:
    """Variables with one value for each column and lane."""
    period = np.zeros(shape, np.int64)
    uncertain, estimated = np.zeros(shape, np.int64), np.zeros(shape, np.int64)
    transient = np.zeros(shape, np.int64)
    events, impacts, window = (np.full(shape, np.nan) for _ in range(3))
    drift = np.full((*shape, len(protocol.system.states)), np.nan)
    word = np.full(shape, "", object)
    status = np.full(shape, Status.INTERRUPTED.word, object)
    for i, j, one in _each(looks):
        period[i, j], transient[i, j] = one.period, one.transient
        uncertain[i, j], estimated[i, j] = one.uncertain, one.estimated
        events[i, j], impacts[i, j] = one.events, one.impacts
        window[i, j], drift[i, j] = one.window, one.drift
        word[i, j], status[i, j] = one.word, one.status.word
    unit = "periods of the forcing" if protocol.unit == "period" else "iterates of the map"
    variables: dict[str, Any] = {
        "period": (_LANES, period, {"long_name": f"period in {unit}, 0 for none"}),
        "word": (_LANES, word.astype(str), {"long_name": "modes of one period"}),
        "events": (_LANES, events, {"long_name": f"events per {protocol.unit}"}),
        "impacts": (_LANES, impacts, {"long_name": f"impacts per {protocol.unit}"}),
        "transient_used": (
            _LANES, transient, {"long_name": f"{protocol.unit}s before what was looked at"},
        ),
        "n_uncertain": (_LANES, uncertain, {"long_name": "events that rounding leaves open"}),
        "n_estimated": (
            _LANES, estimated, {"long_name": "steps the errors of which are estimated"},
        ),
        "status": (_LANES, status.astype(str), {"long_name": "how the motion ended"}),
    }  # fmt: skip
    for name in protocol.system.drift:
        k = protocol.system.states.index(name)
        label = labels_of(protocol.system).attributes(name)["long_name"]
        variables[f"{name}_per_{protocol.unit}"] = (
            _LANES, drift[..., k], {"long_name": f"{label}, per {protocol.unit}"},
        )  # fmt: skip
        variables[f"{name}_per_time"] = (
            _LANES, drift[..., k] / window, {"long_name": f"{label}, per unit time"},
        )  # fmt: skip
    return variables


def _message(protocol: DiagramProtocol, looks: list[Look]) -> str:
    """How the motions ended, and how many of them show no period."""
    ended = {one.status.word for one in looks} - {Status.COMPLETED.word}
    if ended:
        return "some motions ended early, see status: " + ", ".join(sorted(ended))
    restless = [one for one in looks if one.period == 0]
    if not restless:
        return "completed"
    length = min(one.transient for one in restless) + protocol.record
    said = said_of_restless(
        len(restless), len(looks), protocol.record, length, protocol.unit, "longest"
    )
    return f"completed; {said}"


def _said_of_events(protocol: DiagramProtocol, looks: list[Look], event: str) -> str:
    """How many motions leave an empty column, as they do not pass the event that was asked for."""
    if protocol.exits is None:
        return ""
    without = sum(one.status == Status.COMPLETED and not len(one.points) for one in looks)
    if not without:
        return ""
    return (
        f"; {without} of {len(looks)} motions pass no {event!r} in the periods that are recorded:"
        " their columns are empty"
    )
