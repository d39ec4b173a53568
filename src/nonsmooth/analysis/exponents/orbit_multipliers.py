"""Multipliers of a periodic motion, and whether its period wipes out every perturbation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.exponents.growth import Growth
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import Tables
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.runner import Derivatives, NoMode
from nonsmooth.runs.tangent_flow import TangentFlow

__all__ = ["OrbitTangent", "is_forgetful", "orbit_multipliers"]

_SUSPICION = 1e-6  # modulus of all multipliers from which the rank of the period is looked at

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class OrbitTangent:
    """A point of a motion that repeats, from where its derivatives are taken over a period."""

    tables: Tables
    derivatives: Derivatives
    tolerance: float
    state: Floats
    mode: int
    begin: Instant
    end: Instant
    lent: TangentFlow | None = None  # of the same system, with columns for all states

    def flow(self) -> TangentFlow | None:
        """Flow with the columns of all states; None where the mode does not take the point.

        A point that lies on a guard belongs to a mode only by what came before.
        """
        flow = self.lent
        if flow is None:
            n = self.tables.sizes.states
            flow = TangentFlow(self.tables, self.derivatives, n, self.tolerance)
        flow.set_up(self.tables, self.derivatives)
        try:
            status = flow.start(self.state, self.begin, self.mode)
        except NoMode:
            return None
        return flow if status == Status.COMPLETED else None


def orbit_multipliers(
    orbit: OrbitTangent, drifting: npt.NDArray[np.bool_], autonomous: bool
) -> npt.NDArray[np.complex128] | None:
    """Multipliers, the largest first, but for those of drifts, which are one.

    Nothing depends on a drifting state, so the others stand in the block without it. A motion
    without forcing has one along itself, which is one and is left out too; no motion has it where
    it does not move. None where they are not known: a graze, a point that no mode takes.
    """
    flow = orbit.flow()
    if flow is None:
        return None
    flow.set_columns(flow.first_columns)
    if flow.run_to(orbit.end) != Status.COMPLETED:
        return None
    map_of_columns = flow.columns_at_end[~drifting][:, ~drifting]
    if not np.all(np.isfinite(map_of_columns)):
        return None
    values = np.asarray(np.linalg.eigvals(map_of_columns), complex)
    if autonomous and values.size:
        values = np.delete(values, np.argmin(np.abs(values - 1.0)))
    return values[np.argsort(-np.abs(values), kind="stable")]


def is_forgetful(
    orbit: OrbitTangent,
    multipliers: npt.NDArray[np.complex128],
    drifting: npt.NDArray[np.bool_],
) -> bool:
    """Whether no perturbation outlives the period, but those along drifts.

    Found by the rank of what every event does, so that strong contraction does not count.
    """
    if np.abs(multipliers).max(initial=0.0) > _SUSPICION:
        return False
    flow = orbit.flow()
    if flow is None:
        return False
    growth = Growth(flow, flow.n, seed=0)
    status, _rows = growth.through([orbit.end])
    if status != Status.COMPLETED:
        return False
    return growth.n_left <= int(np.count_nonzero(drifting))
