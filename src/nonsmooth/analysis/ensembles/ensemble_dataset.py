"""An ensemble as a dataset: in memory, or in a file that is written chunk by chunk."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from nonsmooth.analysis.ensembles.chunk import Chunk, EnsembleProtocol, empty_chunk
from nonsmooth.engine.status import Status
from nonsmooth.errors import OptionError
from nonsmooth.files import replacing
from nonsmooth.runs.labels import Columns, labels_of
from nonsmooth.runs.store import reserve, trouble

__all__ = ["Frame", "dataset_in_file", "dataset_in_memory", "open_whole"]

_MARGIN, _OF_TEXT = 2**20, 64  # bytes that a file has more, in all and for each lane
_OWN = (
    "mode", "status", "n_uncertain", "n_estimated", "end_time", "initial_state", "end_state",
)  # fmt: skip
_WORDS = np.array([status.word for status in Status if status < Status.BUFFER_FULL], object)
_CODES = np.array([status for status in Status if status < Status.BUFFER_FULL], np.int64)


class Frame:
    """All of the dataset but its numbers: names, dimensions, coordinates, attributes."""

    def __init__(self, protocol: EnsembleProtocol, along: Columns, attrs: dict[str, Any]) -> None:
        self.protocol = protocol
        self.attrs = attrs
        system, count = protocol.system, protocol.members.count
        states = {"long_name": "state"}
        self.coords: Columns = {
            "lane": (("lane",), np.arange(count), {"long_name": "run"}),
            "state": (("state",), np.array(system.states), states),
            **along,
        }
        (self.along,) = along
        used = {*system.states, *system.outputs, *protocol.members.sets}
        own = used.intersection([*_OWN, *self.coords])
        if own:
            raise OptionError(
                f"ensemble: {min(own)!r} is a name of the result as well as of the system; rename"
                " it in the system"
            )

    def variables(self, chunk: Chunk, first: int) -> Columns:
        """Variables of the lanes of a chunk, the first of which has this number."""
        protocol, system = self.protocol, self.protocol.system
        labels, members = labels_of(system), protocol.members
        points, of_states, single = ("lane", self.along), ("lane", "state"), ("lane",)
        found: Columns = {
            name: (points, chunk["points"][..., k], labels.attributes(name))
            for k, name in enumerate([*system.states, *system.outputs])
        }
        found["mode"] = (points, chunk["modes"], labels.mode_flags("mode"))
        words = _WORDS[np.searchsorted(_CODES, chunk["status"])]
        for name, values, label in (
            ("status", words, "how the run ended"),
            ("n_uncertain", chunk["uncertain"], "events that rounding leaves open"),
            ("n_estimated", chunk["estimated"], "steps the errors of which are estimated"),
            ("end_time", chunk["end_time"], "time at the end"),
        ):
            found[name] = (single, values, {"long_name": label})
        found["initial_state"] = (of_states, chunk["initial"], {"long_name": "states at the start"})
        found["end_state"] = (of_states, chunk["end"], {"long_name": "states at the end"})
        sets = members.set_numbers(np.arange(first, first + words.size))
        for name, several in members.sets.items():
            label = system.describe.get(name, name)
            found[name] = (single, several[sets], {"long_name": label})
        return found

    def finish(self, statuses: set[int], complete: bool, n_done: int) -> dict[str, Any]:
        """Attributes with how it all ended; ``n_done`` runs were not left out."""
        ended = [Status(i).word for i in sorted(statuses) if i != Status.COMPLETED]
        message = "completed"
        if not complete:
            count = self.protocol.members.count
            message = f"interrupted by the user; {n_done} of {count} runs are done and kept"
        elif ended:
            message = "some runs ended early, see status: " + ", ".join(ended)
        status = "completed" if complete else "interrupted"
        return self.attrs | {"status": status, "message": message}


def dataset_in_memory(frame: Frame, whole: Chunk, complete: bool) -> xr.Dataset:
    """Dataset of all lanes as one chunk."""
    attrs = frame.finish(set(whole["status"].tolist()), complete, _done_in(whole))
    variables = dict(frame.variables(whole, 0))
    dims, words, label = variables["status"]
    variables["status"] = (dims, words.astype(str), label)
    coords = frame.coords | {name: variables.pop(name) for name in frame.protocol.members.sets}
    return xr.Dataset(variables, coords, attrs)


def dataset_in_file(
    frame: Frame, chunks: Iterator[tuple[int, Chunk]], size: int, complete: bool, path: Path
) -> xr.Dataset:
    """Dataset that is read from a file when it is needed; ``size`` bytes are written there.

    ``chunks`` are all lanes in order, each chunk with the number of its first lane.
    """
    try:
        with replacing(path) as draft:
            reserve(draft, size + _MARGIN + _OF_TEXT * len(frame.coords["lane"][1]))
            _write(frame, chunks, complete, draft)
    except OSError as fault:
        raise trouble(path.parent, path.name, fault) from fault
    return _open(path)


def open_whole(path: Path) -> xr.Dataset | None:
    """The dataset that another process has written, where it holds all lanes."""
    try:
        written = _open(path)
    except OSError:  # it was interrupted, or killed
        return None
    return written if written.attrs["status"] == "completed" else None


def _open(path: Path) -> xr.Dataset:
    return xr.open_dataset(path, engine="h5netcdf", decode_times=False)


def _write(frame: Frame, chunks: Iterator[tuple[int, Chunk]], complete: bool, path: Path) -> None:
    """Write a netCDF file that xarray reads as the dataset in memory."""
    import h5netcdf
    import h5py

    members = frame.protocol.members
    none = frame.variables(empty_chunk(frame.protocol, 1, Status.INTERRUPTED), 0)
    sizes = {dims[0]: len(values) for dims, values, _ in frame.coords.values()}
    statuses: set[int] = set()
    n_done = 0
    with h5netcdf.File(path, "w") as file:
        file.dimensions = sizes
        for name, (dims, values, attributes) in {**frame.coords, **none}.items():
            text = values.dtype.kind in "OU"
            dtype = h5py.string_dtype() if text else values.dtype
            variable = file.create_variable(name, dims, dtype)
            variable.attrs.update(attributes)
            if name in frame.coords:
                variable[...] = values.astype(object) if text else values
        for first, chunk in chunks:
            statuses |= set(chunk["status"].tolist())
            n_done += _done_in(chunk)
            for name, (_, values, _) in frame.variables(chunk, first).items():
                file.variables[name][first : first + len(values)] = values
        if members.sets:  # as the conventions tell coordinates from variables
            file.attrs["coordinates"] = " ".join(members.sets)
        file.attrs.update(frame.finish(statuses, complete, n_done))


def _done_in(chunk: Chunk) -> int:
    """Runs of a chunk that were not left out by an interruption."""
    return int(np.count_nonzero(chunk["status"] != Status.INTERRUPTED))
