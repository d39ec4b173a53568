"""Derivatives of images by their starts: states and time of one by those of the other."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.returns.family import Starts
from nonsmooth.analysis.returns.images import Images, Imaging
from nonsmooth.analysis.returns.lane_log import settle
from nonsmooth.engine.lanes import GOES_ON, Anchor, allocate_columns, allocate_records, run
from nonsmooth.engine.status import Status
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.outputs import StateRates
from nonsmooth.runs.runner import build_derivatives

__all__ = ["Tangents"]

Floats = npt.NDArray[np.float64]


class Tangents:
    """Derivatives of the images of starts.

    A start a little later is a point a little later, so that time is a coordinate of points of a
    section: a shift along the motion changes nothing. Points of a stroboscopic map are all at one
    time, and have zeros there.
    """

    def __init__(self, imaging: Imaging) -> None:
        self.imaging = imaging
        engine = imaging.engine
        self.derivatives = build_derivatives(engine.system, engine.tables, ())
        self.rates = StateRates(imaging.chosen.system, engine.tables, imaging.origin)
        self.knots = bool(imaging.chosen.system.signals)

    def of(self, starts: Starts, images: Images) -> Floats:
        """Derivatives at starts, nan where there is no image.

        shapes: returns (L, n + 1, n + 1), time last
        """
        count, n = starts.states.shape
        found = np.full((count, n + 1, n + 1), np.nan)
        there = np.flatnonzero(images.there)
        if not there.size:
            return found
        some = self.imaging.prepared(starts.some(there))
        engine, tolerance = self.imaging.engine, self.imaging.tolerance
        begun = settle(engine, some, tolerance, self.derivatives)
        entry = np.tile(np.eye(n), (there.size, 1, 1))
        through = np.flatnonzero(begun.passed)
        if through.size:  # begin again behind what was passed at the start
            entry[through] = begun.columns[through, :, :n].transpose(0, 2, 1)
            anchors = begun.anchors
            behind = Starts(
                anchors.state[through], anchors.place["number"][through],
                anchors.place["phase"][through], anchors.place["mode"][through, None],
            )  # fmt: skip
            again = settle(engine, behind, tolerance, self.derivatives)
            anchors.put(through, again.anchors)
            begun.columns[through] = again.columns
        anchors = begun.anchors
        first = self.rates.of_many(
            anchors.place["number"], anchors.place["phase"], anchors.place["mode"], anchors.state
        )
        with np.errstate(invalid="ignore"):  # slopes without bound where a motion just touches
            for k, i in enumerate(there):
                whole = self._to_image(begun.anchor(k), begun.columns[k], images, int(i))
                found[i, :, :n] = whole @ entry[k]
                # the motion from a later start is that from a start as much behind on the way
                found[i, :, n] = -whole @ first[k] if self.imaging.at_rows else 0.0
        return found

    def _to_image(self, anchor: Anchor, columns: Floats, images: Images, i: int) -> Floats:
        """States and time of an image by the states behind the start; (n + 1, n)."""
        engine, at_rows = self.imaging.engine, self.imaging.at_rows
        n, rows = anchor.state.size, int(images.n_rows[i])
        tangent = allocate_columns(engine.sizes, n, 1)
        tangent.columns[:] = columns
        end = Instant(int(images.number[i]), float(images.phase[i]))
        # a log that is full behind the image
        records = allocate_records(
            engine.sizes, np.array([end.number]), np.array([end.phase]), rows + 1 if at_rows else 0
        )
        far = Instant(end.number + 1, 0.0) if at_rows else end
        rates, scratch = self.derivatives.rates, self.derivatives.scratch
        lane = (engine.tables, rates, scratch, anchor, engine.segment, tangent)
        status = run(lane, records, GOES_ON, far, self.imaging.tolerance)
        if not at_rows:
            return np.vstack([tangent.samples[0].T, np.zeros(n)])
        if status != Status.BUFFER_FULL:
            return np.full((n + 1, n), np.nan)
        side = self.imaging.side
        row, state = records.events[rows - 1], records.event_states[rows - 1, side]
        now = (tangent.now, tangent.columns)[side][:, :n].T
        # the moment of a knot of a signal is known, so nothing shifts it
        at_knot = self.knots and row["guard_rate"] == 0.0
        shift = np.zeros(n) if at_knot else -tangent.shifts
        rate = self.rates.at(end, int(row[("from_mode", "to_mode")[side]]), state)
        return np.vstack([now + np.outer(rate, shift), shift])
