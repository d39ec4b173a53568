"""States behind rebounds that have accumulated, at the time when they are over.

The engine passes the last of infinitely many impacts as one, a little before, and goes on in rest
from there: its log has the states of that instant, from which an orbit can be built. A dataset has
the time when the rebounds are over, and the states of that time.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.engine import records as at
from nonsmooth.engine.lanes import as_lanes, run_lanes
from nonsmooth.engine.layout import (
    TAYLOR,
    Tables,
    allocate_segment,
    relation_row,
    stack_of_one,
)
from nonsmooth.engine.loop import SAME
from nonsmooth.engine.records import allocate_anchor, allocate_records
from nonsmooth.engine.tangent import allocate_tangent
from nonsmooth.engine.variation_tables import no_columns, no_rates
from nonsmooth.simulation.runner import Outcome

__all__ = ["states_after"]

_NO_TIMES = (np.zeros(0, np.int64), np.zeros(0))
_RATES, _COLUMNS = no_rates(), no_columns()
_TOLERANCE = 1e-12


def states_after(outcome: Outcome) -> npt.NDArray[np.float64]:
    """States just behind each event of the log, (event, n)."""
    sizes = outcome.tables.sizes
    rows, values = outcome.event_integers, outcome.event_floats
    after = values[:, at.EVENT_FLOATS + int(sizes[0]) :]
    late = np.flatnonzero(values[:, at.WAIT] > 0.0)
    still = [m for m in np.unique(rows[late, at.TO]) if _stands(outcome.tables, int(m))]
    late = late[~np.isin(rows[late, at.TO], still)]
    # where parameters change from period to period, the tables are those of the last one
    if late.size == 0 or outcome.history is not None:
        return after
    after = after.copy()
    anchor, records = allocate_anchor(sizes), allocate_records(sizes, *_NO_TIMES, 0)
    anchors, tangents, lanes = as_lanes(anchor, allocate_tangent(sizes, -1, 0), records)
    stack, segment, modes = stack_of_one(outcome.tables), allocate_segment(sizes), np.zeros(1, int)
    passed, statuses = np.zeros(2, np.int64), np.empty(1, np.int64)
    for k in late:  # a long run has thousands of them, so nothing is made anew for one
        number, phase = rows[k, at.NUMBER], values[k, at.PHASE]
        anchor.place[0], anchor.phase[0], anchor.state[:] = number, phase, after[k]
        records.cursor[:], passed[:], modes[0] = 0, 0, SAME - rows[k, at.TO]
        run_lanes(
            stack, _RATES, _COLUMNS, anchors, segment, tangents, lanes, modes, 0, 1, number,
            phase + values[k, at.WAIT], passed, statuses, _TOLERANCE,
        )  # fmt: skip
        after[k] = records.end_state
    return after


def _stands(tables: Tables, m: int) -> bool:
    """Whether no state changes in a mode, as of a mass at rest at a wall that is fixed."""
    n, n_exits = int(tables.sizes[0]), tables.wiring.shape[1] - 1
    if tables.kinds[m] == TAYLOR or np.any(tables.generator[m][:n]):
        return False
    relations = tables.affine[m][[relation_row(n_exits, i) for i in range(n)]]
    return not np.any(np.delete(relations, n, axis=1))  # coordinate n is the constant one
