"""Runs side by side: the kernel that Python calls, for one run or for many.

A lane is a run of its own, with its own state, parameters being those of the tables. Lanes do
not know of each other, so their order and the number of threads change no digit.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.engine.jit import entry
from nonsmooth.engine.layout import Segment, Tables
from nonsmooth.engine.loop import run_lane
from nonsmooth.engine.records import Anchor, Records
from nonsmooth.engine.status import Status
from nonsmooth.engine.tangent import Tangent
from nonsmooth.engine.variation_tables import Columns, Rates

__all__ = ["Lane", "run", "run_lanes"]

# all that a run needs beside its records
Lane = tuple[Tables, Rates, Columns, Anchor, Segment, Tangent]

_PAUSED = int(Status.PAUSED)


@entry
def run_lanes(
    tables, rates, scratch, anchors, segment, tangents, records, modes, first, last,
    end_number, end_phase, statuses, tolerance,
):  # fmt: skip
    """Run the lanes first ... last - 1 to a time, each as `run_lane` does.

    shapes: Anchor, Tangent and Records with the number of lanes in front, but for the sample
    times of Records and the scratch of Tangent, which all lanes share; modes, statuses (L,).
    Stops early where a lane is paused, so that Python can look after interruptions.
    returns: the first lane that is not run, or the one that is paused
    """
    for lane in range(first, last):
        anchor = Anchor(
            anchors.place[lane], anchors.phase[lane], anchors.state[lane], anchors.order[lane]
        )
        tangent = Tangent(
            tangents.columns[lane], tangents.now, tangents.shifts, tangents.velocity,
            tangents.dual, tangents.ready, tangents.piece, tangents.series,
            tangents.samples[lane],
        )  # fmt: skip
        record = Records(
            records.sample_number, records.sample_phase, records.sample_state[lane],
            records.sample_mode[lane], records.event_integers[lane], records.event_floats[lane],
            records.cursor[lane], records.end_state[lane], records.since[lane],
        )  # fmt: skip
        statuses[lane] = run_lane(
            tables, rates, scratch, anchor, segment, tangent, record, modes[lane],
            end_number, end_phase, tolerance,
        )  # fmt: skip
        if statuses[lane] == _PAUSED:
            return lane
    return last


_OF_LANES = (
    "sample_state", "sample_mode", "event_integers", "event_floats", "cursor", "end_state",
    "since",
)  # fmt: skip


def run(
    tables: Tables,
    rates: Rates,
    scratch: Columns,
    anchor: Anchor,
    segment: Segment,
    tangent: Tangent,
    records: Records,
    mode: int,
    end_number: int,
    end_phase: float,
    tolerance: float,
) -> int:
    """Run one lane; arguments and status are those of `run_lane`."""
    modes, statuses = np.array([mode]), np.empty(1, np.int64)
    anchors = Anchor(anchor.place[None], anchor.phase[None], anchor.state[None], anchor.order[None])
    run_lanes(
        tables, rates, scratch, anchors, segment,
        tangent._replace(columns=tangent.columns[None], samples=tangent.samples[None]),
        records._replace(**{name: getattr(records, name)[None] for name in _OF_LANES}),
        modes, 0, 1, end_number, end_phase, statuses, tolerance,
    )  # fmt: skip
    return int(statuses[0])
