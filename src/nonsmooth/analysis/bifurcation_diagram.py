"""Settled motions over one parameter, by brute force."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.chain_links import End, check_way, links_of
from nonsmooth.analysis.diagrams.columns import (
    DiagramProtocol,
    Look,
    pack_looks,
    read_protocol,
    unpack_looks,
)
from nonsmooth.analysis.diagrams.diagram_dataset import diagram_dataset
from nonsmooth.analysis.diagrams.section_columns import run_section_chain
from nonsmooth.analysis.diagrams.strobe_columns import strobe_looks
from nonsmooth.analysis.options import SharedOptions, check_values, refuse_fixed
from nonsmooth.analysis.settle import ParameterSets, at_time_zero, said_of_start, settle
from nonsmooth.errors import OptionError
from nonsmooth.runs.maps import Map
from nonsmooth.runs.of_system import map_of
from nonsmooth.runs.poincare_map import PoincareMap
from nonsmooth.runs.runner import build_tables
from nonsmooth.runs.section_runner import SectionRunner
from nonsmooth.runs.start import check_carried, resolve_start
from nonsmooth.runs.stored_tasks import run_stored_tasks
from nonsmooth.runs.sweep_runner import SweepRunner, motions_per_task, seconds_of_motion

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.runs.stroboscopic_map import StroboscopicMap
    from nonsmooth.system.system import System

__all__ = ["bifurcation_diagram"]


def bifurcation_diagram(
    system: System | StroboscopicMap | PoincareMap,
    parameter: str,
    values: npt.ArrayLike,
    *,
    initial: Any = None,
    start: str = "restart",
    transient: int = 200,
    record: int = 100,
    longest: int | None = None,
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
        ``"restart"`` begins the motion at each value at the initial state; ``"follow up"`` where
        the motion at the next lower value has ended, and ``"follow down"`` where that at the next
        higher one has. Where several attractors coexist, the answers differ.
    transient : int, optional
        Periods left out at the beginning of each column.
    record : int, optional
        Periods looked at after that.
    longest : int, optional
        Largest transient: where a motion shows no period, its transient is doubled until there, and
        it is looked at again each time. Without it, no motion is run on.
    at : str, optional
        When states are taken: ``"strobe"``, once per period; or the name of an exit or a surface,
        whenever the motion passes it.
    side : {"before", "after"}, optional
        Whether states at events are those before or after it.
    phase : float, optional
        Part of the period at which strobes are taken, from 0 to less than 1.
    match : float, optional
        A motion has period p when its strobes repeat after p periods to this part of the size of
        each state, seen twice at least, and lie far apart beside the way that is left to go: a
        motion that turns by nearly 1/p per strobe as it settles gets the period 0 until then.
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.
    mode : str, optional
        Mode to start in, where several would fit; a cell, or a mode for any of its cells.
    threads : int, optional
        Number of threads; without it, one for each processor. The result does not depend on it.
    store : str or Path, optional
        Folder in which finished parts are kept, made where it is missing. After an interruption the
        same call goes on from them. It does so within a followed diagram too.

    Returns
    -------
    xarray.Dataset
        Over ``parameter``, ``lane`` and ``point``: states, outputs and ``mode``, nan and -1 where
        there are no more points. Over ``parameter`` and ``lane``: ``period`` in periods of the
        forcing, or in iterates of a map (0: none up to half of ``record``), ``word`` (modes of
        that period), ``events`` and ``impacts`` per period, see notes, ``transient_used``,
        ``status``, ``n_uncertain``, ``n_estimated``, and for every drifting state and angle its
        change per period and per unit time, as in ``v_per_period`` (of a map, per iterate, as in
        ``v_per_iterate``). After an interruption the columns that are done are there; a lane of
        them that is not has the status ``interrupted``.

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

    Events are instants at which something changes. Impacts are exits with a reset, or with the word
    ``impact`` in their name, as in ``impact`` or ``upper_impact``; two at one instant count as two.
    Events, impacts and drifts are means over the last whole periods of the motion in ``record``;
    where no period was found, they are means over all of it.

    A motion without a period has not settled as far as it was looked at: it is chaotic or
    quasi-periodic, its period is longer than half of ``record``, or it is a long transient. The
    message tells for how many periods that holds, and never calls it chaos; `regime` tells which.

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
    shared = SharedOptions(parameters, tolerance, mode, threads, store)
    chosen = map_of(system, parameters, tolerance, "bifurcation_diagram", phase=phase, mode=mode)
    grid = check_values(chosen.system, parameter, values)
    refuse_fixed(system, parameters, (parameter,), "values")
    system = chosen.system
    if phase != 0.0 and at != "strobe":
        raise OptionError(
            f"phase = {phase:g} is that of strobes, and points are taken at {at!r}; leave out"
            " phase=, or at="
        )
    way = check_way(start)
    protocol = read_protocol(chosen, parameter, transient, record, longest, match, at, side)
    given = list(initial) if isinstance(initial, Sequence) else [initial]
    if not given:
        raise OptionError("initial= is an empty list; give at least one initial state")
    # refuse here what no column could begin with
    tables = build_tables(system)
    for each in given:
        check_carried(system, each, parameters, (parameter,))
    begins = [resolve_start(system, tables, each, None, mode, True) for each in given]
    looks: list[list[Look | None]] = [[None] * len(given) for _ in grid]
    work = _tasks(protocol, grid, given, mode, way)

    def keep(i: int, found: tuple[list[Look], End | None]) -> None:
        lane, columns = work.places[i]
        for column, look in zip(columns, found[0], strict=True):
            looks[column][lane] = look
        work.ends[i] = found[1]

    options = {
        "start": way,
        "transient": protocol.transient,
        "record": protocol.record,
        "longest": protocol.longest,
        "at": at,
        **({"side": side} | chosen.protocol),
        "match": protocol.match,
        **shared.recorded,
        "initial": str([said_of_start(each) for each in given]),
    }
    complete = run_stored_tasks(
        work.tasks,
        lambda: _make_worker(chosen, tolerance),
        store=shared.store,
        protocol={
            "call": "bifurcation_diagram",
            "follow": ["longest"] if longest is None else [],
            "system": system.to_toml(),
            "parameter": parameter,
            "values": grid,
            **options,
            "initial_states": [[*one.state, *one.modes] for one in begins],
        },
        pack=pack_looks,
        unpack=unpack_looks,
        threads=shared.workers,
        label="bifurcation diagram",
        keep=keep,
        after=work.after,
    )
    return diagram_dataset(protocol, grid, looks, options, complete)


class _Tasks(NamedTuple):
    """Tasks of a diagram; where columns follow each other, one begins at the end of another."""

    tasks: list[Any]
    places: list[tuple[int, list[int]]]  # lane and columns of each
    after: dict[int, int]  # the task that each one follows
    ends: dict[int, End | None]  # of tasks that are done


def _tasks(
    protocol: DiagramProtocol,
    grid: npt.NDArray[np.float64],
    given: list[Any],
    mode: str | None,
    start: str,
) -> _Tasks:
    """Tasks, and the lane and the columns that each one computes."""
    found = _Tasks([], [], {}, {})
    size = motions_per_task(grid.size)
    if not isinstance(protocol.chosen, PoincareMap):  # whose motions are searched one by one
        seconds = seconds_of_motion(protocol.system, protocol.transient + protocol.record)
        size = motions_per_task(grid.size, seconds)
    for lane, each in enumerate(given):
        make = _maker(protocol, grid, each, mode)
        for k, columns in enumerate(links_of(grid, start, size)):
            number = len(found.tasks)
            follow = None if start == "restart" else partial(found.ends.get, -1)
            if k and start != "restart":
                found.after[number] = number - 1
                follow = partial(found.ends.get, number - 1)
            found.tasks.append(make(columns, follow))
            found.places.append((lane, columns))
    return found


def _maker(
    protocol: DiagramProtocol, grid: npt.NDArray[np.float64], initial: Any, mode: str | None
) -> Callable[[list[int], Callable[[], End | None] | None], Any]:
    """Makes tasks: some columns of one lane, each by itself or one after the other."""
    if isinstance(protocol.chosen, PoincareMap):
        return lambda columns, follow: partial(
            run_section_chain, protocol=protocol, values=grid[columns].tolist(), initial=initial,
            mode=mode, follow=follow,
        )  # fmt: skip
    sets = ParameterSets(protocol.strobed, {protocol.parameter: grid}, initial, mode, at_time_zero)
    return lambda columns, follow: partial(
        settle,
        sets=sets,
        which=columns,
        times=lambda group: group.iterates(protocol.transient, protocol.record + 1),
        reduce=partial(strobe_looks, protocol),
        follow=follow,
        alone=follow is not None and protocol.longest > protocol.transient,
    )


def _make_worker(chosen: Map, tolerance: float) -> SweepRunner | SectionRunner:
    """What one thread runs motions with."""
    if isinstance(chosen, PoincareMap):
        return chosen.runner(tolerance)
    return SweepRunner(chosen.system, tolerance)
