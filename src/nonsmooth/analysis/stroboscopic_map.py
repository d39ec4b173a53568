"""Points of one motion, one per period."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.engine.status import Status
from nonsmooth.errors import ModelError, OptionError, RunWarning
from nonsmooth.simulation.assemble import Columns, assemble
from nonsmooth.simulation.clock import Instant, Plan
from nonsmooth.simulation.dataset import run_dataset
from nonsmooth.simulation.options import (
    check_count,
    check_run_options,
    check_signals,
    finite_number,
    whole_number,
)
from nonsmooth.simulation.runner import Outcome, build_tables, run_plan
from nonsmooth.simulation.simulate import in_first_mode
from nonsmooth.simulation.start import resolve_start
from nonsmooth.simulation.stroboscopic import check_phase, require_period, strobes
from nonsmooth.system.evaluate import constant_value
from nonsmooth.system.grammar import parse
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["stroboscopic_map"]


def stroboscopic_map(
    system: System,
    initial: Any = None,
    *,
    transient: int = 0,
    record: int = 1000,
    phase: float = 0.0,
    period: float | str | None = None,
    parameters: Mapping[str, float] | None = None,
    tolerance: float = 1e-12,
    mode: str | None = None,
    t_start: float | None = None,
) -> xr.Dataset:
    """Look at a motion once per period.

    Parameters
    ----------
    system : System
        The system; it needs a period, or ``period``.
    initial : mapping, dataset or run, optional
        Initial state as in `simulate`; the rest state without it.
    transient : int, optional
        Strobes left out at the beginning.
    record : int, optional
        Strobes kept.
    phase : float, optional
        Part of the period at which strobes are taken, from 0 to less than 1 (dimensionless).
    period : float or str, optional
        Another time between strobes than the period of the system: a length of time, or an
        expression of parameters such as ``"2*pi/omega_2"``, for a system with several
        frequencies or none.
    parameters : mapping of str to float, optional
        Changed values of parameters.
    tolerance : float, optional
        As in `simulate`.
    mode : str, optional
        Mode of the start, as in `simulate`.
    t_start : float, optional
        Time of the start, 0 without it.

    Returns
    -------
    xarray.Dataset
        Over ``point``: every state and output, ``time`` and ``mode``; attributes with the protocol
        and the ``status``. A run that ends early leaves the points until then.

    Raises
    ------
    OptionError
        For a system without a period, or an option out of its range.

    Warns
    -----
    RunWarning
        When the run ended early.

    See Also
    --------
    simulate : the whole motion.

    Notes
    -----
    The strobes of the period of a system are taken at exactly the same phase, however late; those
    of another period at times that are rounded once each.

    References
    ----------
    M. Wiercigroch and E. Pavlovskaia, Engineering Applications of Non-smooth Dynamics, 2012,
    section 2: Poincaré maps of the mole.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> points = ns.stroboscopic_map(ns.models.soft_impact(), transient=100, record=50)
    >>> dict(points.sizes), points.attrs["status"]
    ({'point': 50}, 'completed')
    """
    system = check_run_options(system, parameters, mode, tolerance)
    if system.slow:
        raise OptionError(
            "stroboscopic_map: the parameters in slow= change from period to period, so there is no"
            " map; simulate the system, or leave slow= out"
        )
    length = _period(system, period)
    part = check_phase(phase)
    left_out = 0 if transient == 0 else whole_number("transient", transient)
    count = check_count(whole_number("record", record))
    tables = build_tables(system)
    window = float(tables.clock[0])
    start = resolve_start(system, tables, initial, t_start, mode, parameters is not None)
    numbers, phases = strobes(window, start.instant, length, part, left_out, count)
    plan = Plan(Instant(int(numbers[-1]), float(phases[-1])), numbers, phases)
    check_signals(system, start.instant.time(window), plan.end.time(window))

    def run(first_mode: int) -> Outcome:
        return run_plan(
            tables, plan, tolerance, anchor=start.anchor, state=start.state, begin=start.instant,
            mode=first_mode, keep_events=False,
        )  # fmt: skip

    outcome = in_first_mode(system, tables, start, run)
    options = {
        "transient": left_out,
        "record": count,
        "phase_of_period": part,
        "strobe_period": window if length is None else length,
        "tolerance": float(tolerance),
        "changed_parameters": str(dict(parameters)) if parameters else "",
    }
    points = _over_points(system, run_dataset(system, outcome, options))
    if outcome.status not in (Status.COMPLETED, Status.STOPPED):
        warnings.warn(f"{system.name}: {points.attrs['message']}", RunWarning, stacklevel=2)
    return points


def _period(system: System, period: Any) -> float | None:
    """Length of time between strobes; None for the period of the system."""
    if period is None:
        require_period(system, "stroboscopic_map")
        return None
    if isinstance(period, str):
        try:
            period = constant_value(parse(period, where="period"), system.parameter_values)
        except KeyError as unknown:
            raise ModelError(
                f"period = {unknown.args[0]!r} is no parameter of {system.name!r}; known are"
                f" {', '.join(system.parameters)}"
            ) from None
    length = finite_number("period", period)
    if not length > 0.0:
        raise OptionError(f"period = {length:g} must be positive")
    return length


def _over_points(system: System, run: xr.Dataset) -> xr.Dataset:
    """The samples of a run as points of a map."""
    names = (*system.states, *system.outputs, "mode")
    variables: Columns = {
        name: (("point",), run[name].values, dict(run[name].attrs)) for name in names
    }
    coords: Columns = {
        "point": (("point",), np.arange(run.sizes["time"]), {"long_name": "strobe"}),
        "time": (("point",), run["time"].values, dict(run["time"].attrs)),
    }
    kept = (
        "system", "system_name", "nonsmooth_version", "status", "message", "certified",
        "n_uncertain", "transient", "record", "phase_of_period", "strobe_period", "tolerance",
        "changed_parameters",
    )  # fmt: skip
    attrs = {name: run.attrs[name] for name in kept if name in run.attrs}
    return assemble(variables, coords, {}, attrs)
