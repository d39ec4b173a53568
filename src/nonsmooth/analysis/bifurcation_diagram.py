"""Settled motions over one parameter, by brute force."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.columns import Look, Protocol, run_chain
from nonsmooth.analysis.diagrams.diagram_dataset import diagram_dataset
from nonsmooth.analysis.diagrams.look_arrays import pack_looks, unpack_looks
from nonsmooth.analysis.diagrams.section_columns import run_section_chain
from nonsmooth.engine.layout import Tables
from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.maps.of_system import Map, map_of
from nonsmooth.maps.poincare import PoincareMap
from nonsmooth.maps.section_runner import SectionRunner
from nonsmooth.maps.stroboscopic import StroboscopicMap
from nonsmooth.simulation.crew import check_threads
from nonsmooth.simulation.lane_runner import LaneRunner
from nonsmooth.simulation.options import finite_number, whole_number
from nonsmooth.simulation.runner import build_tables
from nonsmooth.simulation.start import resolve_start
from nonsmooth.simulation.stored_tasks import run_stored_tasks
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["bifurcation_diagram"]

_STARTS = ("restart", "follow up", "follow down")
_SIDES = ("before", "after")
_TOGETHER = 16  # columns in a task: a few milliseconds of work


def bifurcation_diagram(
    system: System | StroboscopicMap | PoincareMap,
    parameter: str,
    values: npt.ArrayLike,
    *,
    initial: Any = None,
    start: str = "restart",
    transient: int = 200,
    record: int = 100,
    at: str = "strobe",
    side: str = "before",
    phase: float = 0.0,
    match: float = 1e-6,
    parameters: Mapping[str, float] | None = None,
    tolerance: float = 1e-12,
    mode: str | None = None,
    threads: int | None = None,
    store: str | Path | None = None,
) -> xr.Dataset:
    """Compute settled motions for many values of a parameter.

    Parameters
    ----------
    system : System, StroboscopicMap or PoincareMap
        A system with a period, or a map of any system: points are its iterates then, and what
        counts periods below counts iterates.
    parameter : str
        The parameter that is changed.
    values : array_like
        Its values, one column of the diagram each.
    initial : mapping, dataset, or a list of these, optional
        Initial state as in `simulate`, or several: each is a ``lane`` of its own. States that are
        not given are those at rest, for each value anew.
    start : {"restart", "follow up", "follow down"}, optional
        Whether every column begins at the initial state, or where the column with the next lower
        (higher) value has ended. Where several attractors coexist, the answers differ.
    transient : int, optional
        Periods left out at the beginning of each column.
    record : int, optional
        Periods looked at after that.
    at : str, optional
        ``"strobe"`` for the states once per period, or the name of an exit or a surface for the
        states whenever it is passed.
    side : {"before", "after"}, optional
        Whether states at events are those before or after it.
    phase : float, optional
        Part of the period at which strobes are taken, from 0 to less than 1.
    match : float, optional
        A motion has period p when its strobes repeat after p periods to this part of the size of
        each state, seen twice at least.
    parameters : mapping of str to float, optional
        Changed values of other parameters.
    tolerance : float, optional
        As in `simulate`.
    mode : str, optional
        Mode of the starts, as in `simulate`.
    threads : int, optional
        Threads to use; all processors without it. The result does not depend on it.
    store : path, optional
        A folder, made where it is missing, in which columns are kept as they are done: after an
        interruption the same call goes on there. A followed diagram goes on from whole chains, one
        for each initial state.

    Returns
    -------
    xarray.Dataset
        Over ``parameter``, ``lane`` and ``point``: states, outputs and ``mode``, nan and -1 where
        there are no more points. Over ``parameter`` and ``lane``: ``period`` in periods of the
        forcing, or in iterates of a map (0: none up to half of ``record``), ``word`` (modes of
        that period), ``events`` and ``impacts`` (events of that kind) per period, ``status``,
        ``n_uncertain``, and for every drifting state its change per period and per unit time, as
        in ``v_per_period`` (of a map, per iterate, as in ``v_per_iterate``). After an interruption
        the columns that are done are there, the others have the status ``interrupted``.

    Raises
    ------
    OptionError
        For an option out of its range, an unknown parameter or event, a system without a
        period, or a ``store`` that was begun with other options.
    RunError
        When the store could not be written, for want of room for one; what is done is kept there.

    See Also
    --------
    stroboscopic_map, poincare_section : one motion in more detail.
    PoincareMap : the points of a system without a period.

    Notes
    -----
    The motion of a system without a period is periodic where the points of its return map repeat,
    with the same times between them.

    A value that the system refuses leaves an empty column with the status ``refused``.

    References
    ----------
    M. Wiercigroch and E. Pavlovskaia, Engineering Applications of Non-smooth Dynamics, 2012,
    section 2: diagrams of the mole.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> diagram = ns.bifurcation_diagram(
    ...     ns.models.soft_impact(), "omega", [0.7, 0.8], transient=100, record=20
    ... )
    >>> diagram["x"].shape, diagram["status"].values.ravel().tolist()
    ((2, 1, 20), ['completed', 'completed'])
    """
    chosen = map_of(system, parameters, tolerance, "bifurcation_diagram", phase=phase, mode=mode)
    system = chosen.system
    grid = _check_values(system, parameter, values)
    if start not in _STARTS:
        raise OptionError(f"start = {start!r}: {unknown_name('way', str(start), _STARTS)}")
    if side not in _SIDES:
        raise OptionError(f"side = {side!r}: {unknown_name('side', str(side), _SIDES)}")
    protocol = Protocol(
        chosen=chosen,
        parameter=parameter,
        transient=0 if transient == 0 else whole_number("transient", transient),
        record=whole_number("record", record),
        match=_check_match(match),
        exits=_exits(chosen, at, side),
        after=side == "after",
        drifting=np.array([name in system.drift_states for name in system.states]),
        outputs=bool(system.outputs),
    )
    tables = build_tables(system)
    given = list(initial) if isinstance(initial, Sequence) else [initial]
    if not given:
        raise OptionError("initial= is an empty list; give at least one initial state")
    # refuse here what no column could begin with
    begins = [resolve_start(system, tables, each, None, mode, True) for each in given]
    looks: list[list[Look | None]] = [[None] * len(given) for _ in grid]
    tasks, places = [], []
    for lane, each in enumerate(given):
        for links in _chains(grid, start):
            tasks.append(_task(protocol, grid[links].tolist(), each, mode, start))
            places.append((lane, links))

    def keep(i: int, found: list[Look]) -> None:
        lane, links = places[i]
        for column, look in zip(links, found, strict=True):
            looks[column][lane] = look

    options = {
        "start": start,
        "transient": protocol.transient,
        "record": protocol.record,
        "at": at,
        **({"side": side} | chosen.protocol),
        "match": protocol.match,
        "tolerance": float(tolerance),
        "changed_parameters": str(dict(parameters)) if parameters else "",
        "initial": str([_said(each) for each in given]),
    }
    complete = run_stored_tasks(
        tasks,
        lambda: _worker(chosen, tolerance),
        store=store,
        protocol={
            "system": system.to_toml(),
            "parameter": parameter,
            "values": grid,
            **options,
            "initial_states": [[*one.state, *one.modes] for one in begins],
        },
        pack=pack_looks,
        unpack=unpack_looks,
        threads=check_threads(threads),
        label="bifurcation diagram",
        keep=keep,
    )
    return diagram_dataset(protocol, grid, looks, options, complete)


def _task(
    protocol: Protocol, values: list[float], initial: Any, mode: str | None, start: str
) -> Any:
    """Some columns of one lane, each by itself or one after the other."""

    def begin(system: System, tables: Tables) -> tuple[npt.NDArray[np.float64], int]:
        # states that are not given are those at rest, which may depend on the parameter
        found = resolve_start(system, tables, initial, None, mode, repeated=True)
        return found.state, found.modes[0]

    chain: Any = run_section_chain if isinstance(protocol.chosen, PoincareMap) else run_chain

    def run(runner: Any, stop: threading.Event) -> list[Look]:
        return list(chain(protocol, runner, stop, values, begin, follow=start != "restart"))

    return run


def _worker(chosen: Map, tolerance: float) -> LaneRunner | SectionRunner:
    """What one thread runs motions with."""
    if isinstance(chosen, PoincareMap):
        return chosen.runner(tolerance)
    return LaneRunner(chosen.system, tolerance)


def _said(initial: Any) -> str:
    """An initial state as the protocol tells it."""
    if initial is None:
        return "at rest"
    return str(dict(initial)) if isinstance(initial, Mapping) else "a point of a dataset"


def _chains(grid: npt.NDArray[np.float64], start: str) -> list[list[int]]:
    """Columns that one task computes, in order."""
    if start == "restart":
        return [
            list(range(i, min(i + _TOGETHER, grid.size))) for i in range(0, grid.size, _TOGETHER)
        ]
    order = np.argsort(grid, kind="stable")
    return [(order if start == "follow up" else order[::-1]).tolist()]


def _check_values(system: System, parameter: Any, values: Any) -> npt.NDArray[np.float64]:
    if parameter not in system.parameters:
        raise OptionError(unknown_name("parameter", str(parameter), system.parameters))
    try:
        grid = np.atleast_1d(np.asarray(values, dtype=float))
    except (TypeError, ValueError):
        raise OptionError(f"values = {values!r:.60}: give a list of numbers") from None
    if grid.ndim != 1 or grid.size == 0 or not np.all(np.isfinite(grid)):
        raise OptionError(
            "values= takes a one-dimensional, non-empty list of finite numbers, such as"
            " np.linspace(0.5, 1.0, 400)"
        )
    return grid


def _check_match(match: Any) -> float:
    number = finite_number("match", match)
    if not 0.0 < number < 1.0:
        raise OptionError(f"match = {number:g} must lie between 0 and 1; 1e-6 is usual")
    return number


def _exits(chosen: Map, at: Any, side: Any) -> npt.NDArray[np.bool_] | None:
    """Exits of each mode with a name; None for the points of the map."""
    system = chosen.system
    if isinstance(chosen, PoincareMap) and (at, side) != ("strobe", "before"):
        raise OptionError(
            f"at = {at!r:.60}, side = {side!r:.60}: the map says itself where its points lie and on"
            " which side of an event; give these to PoincareMap"
        )
    if at == "strobe":
        return None
    names = system.compiled.exit_names
    known = dict.fromkeys(name for of_mode in names for name in of_mode)
    if at not in known:
        raise OptionError(f"at: {unknown_name('event', str(at), ['strobe', *known])}")
    most = max(len(of_mode) for of_mode in names)
    found = np.zeros((len(names), most), bool)
    for m, of_mode in enumerate(names):
        found[m, : len(of_mode)] = [name == at for name in of_mode]
    return found
