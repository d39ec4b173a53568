"""States behind rebounds that have accumulated, at the time when they are over.

The engine passes the last of infinitely many impacts as one, a little before, and goes on in rest
from there: its log has the states of that instant, from which an orbit can be built. A dataset has
the time when the rebounds are over, and the states of that time.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.engine import records as at
from nonsmooth.engine.lanes import run
from nonsmooth.engine.layout import allocate_segment
from nonsmooth.engine.loop import SAME
from nonsmooth.engine.records import allocate_anchor, allocate_records
from nonsmooth.engine.tangent import allocate_tangent
from nonsmooth.engine.variation_tables import no_columns, no_rates
from nonsmooth.simulation.runner import Outcome

__all__ = ["states_after"]

_NO_TIMES = (np.zeros(0, np.int64), np.zeros(0))
_TOLERANCE = 1e-12


def states_after(outcome: Outcome) -> npt.NDArray[np.float64]:
    """States just behind each event of the log, (event, n)."""
    sizes = outcome.tables.sizes
    rows, values = outcome.event_integers, outcome.event_floats
    after = values[:, at.EVENT_FLOATS + int(sizes[0]) :]
    late = np.flatnonzero(values[:, at.WAIT] > 0.0)
    # where parameters change from period to period, the tables are those of the last one
    if late.size == 0 or outcome.history is not None:
        return after
    after = after.copy()
    segment, tangent = allocate_segment(sizes), allocate_tangent(sizes, -1, 0)
    for k in late:
        anchor, number, phase = allocate_anchor(sizes), rows[k, at.NUMBER], values[k, at.PHASE]
        anchor.place[0], anchor.phase[0], anchor.state[:] = number, phase, after[k]
        records = allocate_records(sizes, *_NO_TIMES, 0)
        run(
            outcome.tables, no_rates(), no_columns(), anchor, segment, tangent, records,
            SAME - rows[k, at.TO], number, phase + values[k, at.WAIT], _TOLERANCE,
        )  # fmt: skip
        after[k] = records.end_state
    return after
