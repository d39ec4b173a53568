"""States behind rebounds that have accumulated, at the time when they are over.

The engine passes the last of infinitely many impacts as one, a little before, and goes on in rest
from there: its log has the states of that instant, from which an orbit can be built. A dataset has
the time when the rebounds are over, and the states of that time.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.derivatives import no_rates, no_scratch
from nonsmooth.engine.lanes import (
    SAME,
    allocate_anchor,
    allocate_records,
    allocate_segment,
    allocate_tangent,
    run,
)
from nonsmooth.engine.tables import TAYLOR, Tables
from nonsmooth.runs.runner import Outcome

__all__ = ["states_after"]

_NO_TIMES = (np.zeros(0, np.int64), np.zeros(0))
_RATES, _SCRATCH = no_rates(), no_scratch()
_TOLERANCE = 1e-12


def states_after(outcome: Outcome) -> npt.NDArray[np.float64]:
    """States just behind each event of the log, (event, n)."""
    sizes = outcome.tables.sizes
    rows, after = outcome.events, outcome.event_states[:, 1]
    late = np.flatnonzero(rows["wait"] > 0.0)
    still = [m for m in np.unique(rows["to_mode"][late]) if _stands(outcome.tables, int(m))]
    late = late[~np.isin(rows["to_mode"][late], still)]
    # where parameters change from period to period, the tables are those of the last one
    if late.size == 0 or outcome.history is not None:
        return after
    after = after.copy()
    anchor, records = allocate_anchor(sizes), allocate_records(sizes, *_NO_TIMES, 0)
    segment, tangent = allocate_segment(sizes), allocate_tangent(sizes, -1, 0)
    lane = (outcome.tables, _RATES, _SCRATCH, anchor, segment, tangent)
    for k in late:  # a long run has thousands of them, so nothing is made anew for one
        number, phase = int(rows["number"][k]), float(rows["phase"][k])
        anchor.move_to((number, phase))
        anchor.state[:] = after[k]
        records.counters[()] = 0
        mode = SAME - int(rows["to_mode"][k])
        run(lane, records, mode, (number, phase + float(rows["wait"][k])), _TOLERANCE)
        after[k] = records.end_state
    return after


def _stands(tables: Tables, m: int) -> bool:
    """Whether no state changes in a mode, as of a mass at rest at a wall that is fixed."""
    n = tables.sizes.states
    if tables.kinds[m] == TAYLOR or np.any(tables.generator[m][:n]):
        return False
    relations = np.array([tables.relation_row(m, i) for i in range(n)])
    return not np.any(np.delete(relations, n, axis=1))  # coordinate n is the constant one
