"""Runs side by side: the kernel that Python calls, for one run or for many.

A lane is a run of its own, with its own state, parameters being those of the tables. Lanes do
not know of each other, so their order and the number of threads change no digit.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nonsmooth.engine.jit import entry, kernel
from nonsmooth.engine.layout import Segment, Tables, stack_of_one, tables_at
from nonsmooth.engine.loop import SAME, run_lane
from nonsmooth.engine.records import SAMPLES, WINDOW_EVENTS, Anchor, Records
from nonsmooth.engine.status import Status
from nonsmooth.engine.tangent import Tangent
from nonsmooth.engine.variation_tables import Columns, Rates

__all__ = ["Lane", "as_lanes", "run", "run_lanes"]

# all that a run needs beside its records
Lane = tuple[Tables, Rates, Columns, Anchor, Segment, Tangent]

_COMPLETED = int(Status.COMPLETED)
_PAUSED = int(Status.PAUSED)


@entry
def run_lanes(
    stack, rates, scratch, anchors, segment, tangents, records, modes, first, last,
    end_number, end_phase, passed, statuses, tolerance,
):  # fmt: skip
    """Run the lanes first ... last - 1 to a time, each as `run_lane` does.

    shapes: Anchor, Tangent and Records with the number of lanes in front, but for the sample
    times of Records and the scratch of Tangent, which all lanes share; modes, statuses (L,).
    With a stack of several tables a lane passes through periods one after the other, each with
    its own tables, of which the last one ends at the time given; passed (1 + k,) has the number of
    periods behind the lane, from where it goes on, and the samples by the end of each.
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
        count = stack.clock.shape[0]
        for period in range(passed[0], count):
            left = count - 1 - period
            statuses[lane] = run_lane(
                tables_at(stack, period), rates, scratch, anchor, segment, tangent, record,
                modes[lane], end_number - left, 0.0 if left > 0 else end_phase, tolerance,
            )  # fmt: skip
            passed[1 + period] = record.cursor[SAMPLES]
            if statuses[lane] != _COMPLETED or left == 0:
                break
            modes[lane] = _begin_period(anchor, record, end_number - left)
            passed[0] += 1
        if statuses[lane] == _PAUSED:
            return lane
    return last


@kernel
def _begin_period(anchor, record, number):
    """Put the anchor where a period begins, and give the mode in which the run enters it."""
    anchor.place[0], anchor.phase[0] = number, 0.0
    for i in range(anchor.state.size):
        anchor.state[i] = record.end_state[i]
    for e in range(anchor.order.size):
        anchor.order[e] = 0
    record.cursor[WINDOW_EVENTS] = 0
    return SAME - anchor.place[1]


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
    modes, passed, statuses = np.array([mode]), np.zeros(2, np.int64), np.empty(1, np.int64)
    anchors, tangents, lanes = as_lanes(anchor, tangent, records)
    run_lanes(
        stack_of_one(tables), rates, scratch, anchors, segment, tangents, lanes, modes, 0, 1,
        end_number, end_phase, passed, statuses, tolerance,
    )  # fmt: skip
    return int(statuses[0])


def as_lanes(anchor: Anchor, tangent: Tangent, records: Records) -> tuple[Any, Any, Any]:
    """What belongs to one lane in the form of lanes, without a copy."""
    return (
        Anchor(anchor.place[None], anchor.phase[None], anchor.state[None], anchor.order[None]),
        tangent._replace(columns=tangent.columns[None], samples=tangent.samples[None]),
        records._replace(**{name: getattr(records, name)[None] for name in _OF_LANES}),
    )
