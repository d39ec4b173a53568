"""The equations of an orbit from what its legs come to: residual and Jacobian.

Unknowns are the states at the start of each of L legs, then the instants between them. Equations
are n for each leg, that it leads to the start of the next one, then a guard for each instant.
"""

from __future__ import annotations

from nonsmooth.engine.arrays import set_zero
from nonsmooth.engine.jit import entry, kernel

__all__ = ["close_legs"]


@entry
def close_legs(
    results, states, n_instants, driven, begins, ends, drifting, origin, residual,
    jacobian, moved,
):  # fmt: skip
    """Fill the residual, its Jacobian by the unknowns, and its derivatives by parameters.

    shapes: results of L legs (`LegResults`), states (L, n) at their starts; n_instants is L where
    the last instant is unknown, else L - 1; begins, ends (P,) are what the first and the last
    instant change by with the parameters, where the orbit is driven; drifting (n,) states stay
    open in the last leg and begin at origin (n,); residual (S,), jacobian (S, S),
    moved (S, P) with S = L n + n_instants, outputs
    """
    count, n = states.shape
    set_zero(jacobian)
    set_zero(moved)
    for k in range(count):
        following = (k + 1) % count
        for i in range(n):
            row = k * n + i
            residual[row] = results.nexts[k, i] - states[following, i]
            _fill_row(
                results.jump[k, :, i], results.flow[k], results.jump_rate[k, i],
                results.start_rates[k], k, n_instants, driven, begins, ends,
                jacobian[row], moved[row],
            )  # fmt: skip
            jacobian[row, following * n + i] -= 1.0
        if k < n_instants:
            row = count * n + k
            residual[row] = results.guard[k]
            _fill_row(
                results.guard_row[k], results.flow[k], results.guard_rate[k],
                results.start_rates[k], k, n_instants, driven, begins, ends,
                jacobian[row], moved[row],
            )  # fmt: skip
    for i in range(n):
        if drifting[i]:
            row = (count - 1) * n + i
            residual[row] = states[0, i] - origin[i]
            for j in range(jacobian.shape[1]):
                jacobian[row, j] = 0.0
            for p in range(moved.shape[1]):
                moved[row, p] = 0.0
            jacobian[row, i] = 1.0


@kernel
def _fill_row(of_end, flow, rate, start_rates, k, n_instants, driven, begins, ends, row, moved):
    """Derivatives of a function of the end of leg k, of_end (n + P,) being those by that end."""
    n, n_rates = flow.shape[1], moved.size
    count = (row.size - n_instants) // n
    by_begin = 0.0
    for c in range(n):
        total = 0.0
        for j in range(n):
            total += of_end[j] * flow[c, j]
        row[k * n + c] += total
        by_begin -= total * start_rates[c]
    for p in range(n_rates):
        total = of_end[n + p]
        for j in range(n):
            total += of_end[j] * flow[n + p, j]
        moved[p] += total
    first = count * n - 1  # the column of instant j is first + j
    if k > 0:
        row[first + k] += by_begin
    elif driven:
        for p in range(n_rates):
            moved[p] += by_begin * begins[p]
    if k + 1 <= n_instants:
        row[first + k + 1] += rate
    elif driven:
        for p in range(n_rates):
            moved[p] += rate * ends[p]
