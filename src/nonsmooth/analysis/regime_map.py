"""`regime_map`: what motions settle to over two parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.chain_links import check_way
from nonsmooth.analysis.regimes.border_refinement import (
    check_levels,
    refine_borders,
    refined_values,
)
from nonsmooth.analysis.regimes.map_question import ask_map
from nonsmooth.analysis.regimes.points import Plane
from nonsmooth.analysis.regimes.regime_dataset import map_dataset
from nonsmooth.analysis.settle import said_of_start
from nonsmooth.errors import OptionError, is_known, unknown_choice
from nonsmooth.runs.crew import check_threads
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["regime_map"]

_MOST = 2 * 10**6  # points; each computed one takes a kilobyte
_FILLS = ("labels", "motions")


def regime_map(
    system: System,
    over: Mapping[str, npt.ArrayLike],
    *,
    initial: Any = None,
    start: str = "restart",
    refine: int = 0,
    fill: str = "labels",
    transient: int = 200,
    record: int = 100,
    evidence: int = 500,
    longest: int | None = None,
    confirm: int = 10_000,
    phase: float = 0.0,
    period: float | str | None = None,
    match: float = 1e-6,
    parameters: Mapping[str, float] | None = None,
    tolerance: float = 1e-12,
    mode: str | None = None,
    threads: int | None = None,
    store: str | Path | None = None,
) -> xr.Dataset:
    """Tell what motions settle to, for many values of two parameters.

    Parameters
    ----------
    system : System
        The system; it needs a period, or ``period``.
    over : mapping of str to array_like
        Two parameters and their values, which grow: the first one is the horizontal axis of a
        picture.
    initial : mapping or dataset, or a list of them, optional
        Initial state as in `simulate`, the same everywhere; several in a list make a map each,
        over a ``lane``. States that are not given are those at rest, for each point anew.
    start : {"restart", "follow up", "follow down"}, optional
        Where motions begin: at the initial state; or where the motion at the next smaller, or
        larger, value of the first parameter has settled, so that a row stays on its attractor.
        Drifting states begin at their initial value everywhere. Needs ``refine=0``.
    refine : int, optional
        How often cells are halved where the labels of their corners differ. What then lies among
        equal labels is filled and not computed, so an island smaller than a cell of the grid that
        is given may be missed.
    fill : {"labels", "motions"}, optional
        What refined cells are filled with: the label that is found all around, and no
        numbers (nan); or motions, so that every number of the result is computed.

    Other Parameters
    ----------------
    transient, record, evidence : int, optional
        As in `regime`.
    longest, confirm : int, optional
        As in `regime`. A chaotic point takes most of the time; a smaller ``confirm`` saves a part.
    phase : float, optional
        As in `regime`.
    period : float or str, optional
        As in `regime`; an expression is evaluated at each point.
    match : float, optional
        As in `regime`.
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
        same call goes on from them.

    Returns
    -------
    xarray.Dataset
        Over the second and the first parameter: ``regime``, numbers whose names are CF flags in its
        attributes, ``period`` and ``word`` as in `regime`, and ``computed``, 0 where these were
        filled. Where computed, else nan: ``events``, ``impacts``, ``exponent``,
        ``exponent_error``, ``K``, ``residual``, ``multiplier`` (the largest modulus), changes of
        drifting states and angles per period and per unit time, ``transient_used``,
        ``n_uncertain``, ``n_estimated``. A variable that has the name of a parameter gets
        ``_of_motion`` behind its name. After an interruption the points that are missing have the
        regime ``interrupted``.

    Raises
    ------
    OptionError
        For parameters that are not two, unknown, or without values, for an option out of its
        range, a system without a period, or a ``store`` that was begun with other options.
    RunError
        When the store could not be written, for want of room for one; what is done is kept there.

    See Also
    --------
    regime : one motion, with the labels and their rules.
    bifurcation_diagram : states over one parameter.

    Notes
    -----
    Where several attractors coexist, a map shows those that the initial state leads to. Values
    that the system refuses have the regime ``refused``, starts that fit no mode ``inadmissible``.

    Cells differ where label, period, number of impacts or word do; the word may begin anywhere.
    They are halved, and all their points computed, until no cell of a level differs that has not
    been.

    References
    ----------
    M. Wiercigroch and E. Pavlovskaia, Engineering Applications of Non-smooth Dynamics, 2012,
    section 2: regions of progression of the mole.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> grid = ns.regime_map(
    ...     ns.models.soft_impact(), {"omega": [0.8, 0.905], "zeta": [0.01, 0.05]}, transient=300
    ... )
    >>> names = grid["regime"].attrs["flag_meanings"].split()
    >>> [[names[code] for code in row] for row in grid["regime"].values]
    [['periodic', 'chaotic'], ['periodic', 'periodic']]
    """
    if isinstance(initial, list | tuple):
        same: dict[str, Any] = {
            "start": start, "refine": refine, "fill": fill, "transient": transient,
            "record": record, "evidence": evidence, "longest": longest, "confirm": confirm,
            "phase": phase, "period": period, "match": match, "parameters": parameters,
            "tolerance": tolerance, "mode": mode, "threads": threads,
        }  # fmt: skip
        return _maps_of_starts(partial(regime_map, system, over, **same), initial, store)
    question = ask_map(
        "regime_map", system, over, initial=initial, transient=transient, record=record,
        evidence=evidence, longest=longest, confirm=confirm, phase=phase, period=period,
        match=match, parameters=parameters, tolerance=tolerance, mode=mode,
    )  # fmt: skip
    workers = check_threads(threads)
    levels = check_levels(refine)
    way = check_way(start)
    if levels and way != "restart":
        raise OptionError(
            f"start = {way!r} and refine = {levels}: motions follow each other along whole rows;"
            " take more values of the first parameter, and refine=0"
        )
    if not is_known(fill, _FILLS):
        raise OptionError(unknown_choice("fill", fill, _FILLS))
    fine = (
        refined_values(question.values[0], levels),
        refined_values(question.values[1], levels),
    )
    if fine[0].size * fine[1].size > _MOST:
        raise OptionError(
            f"over: {fine[0].size} times {fine[1].size} points are asked for, at most {_MOST:g};"
            " take fewer values, or a smaller refine=, or nonsmooth.cluster.plan_map, which has no"
            " such limit"
        )
    options = {"start": way, "initial": said_of_start(initial), "refine": levels, "fill": fill}
    options |= question.recorded
    follow = ["longest"] if longest is None else []
    plane = Plane(
        question.protocol, question.strobes, question.names, fine, initial, mode, tolerance,
        workers, store, way, {"call": "regime_map", "follow": follow} | options | question.told,
    )  # fmt: skip
    filled = refine_borders(plane.grid.keys, levels, plane.compute)
    if fill == "motions":
        # what an interruption leaves undone is missing, and not filled
        plane.compute(filled)
        filled = filled[:0]
    plane.grid.fill(filled)
    return map_dataset(question.system, question.names, fine, plane.grid.verdicts, filled, options)


def _maps_of_starts(
    make: Callable[..., xr.Dataset], given: Sequence[Any], store: str | Path | None
) -> xr.Dataset:
    """Maps of initial states over a dimension ``lane``, one after the other.

    ``make`` computes one of them, given ``initial`` and ``store``. After an interruption those that
    were begun are there.
    """
    import xarray as xr

    if not given:
        raise OptionError("initial: the list is empty; give a state, or leave it out for rest")
    if store is not None:
        Path(store).mkdir(exist_ok=True)
    maps: list[xr.Dataset] = []
    for lane, initial in enumerate(given):
        folder = None if store is None else Path(store) / f"lane-{lane:03d}"
        maps.append(make(initial=initial, store=folder))
        if maps[-1].attrs["status"] != "completed":
            break
    lanes = xr.DataArray(np.arange(len(maps)), dims="lane", attrs={"long_name": "initial state"})
    whole = xr.concat(maps, lanes.rename("lane"), combine_attrs="override", join="exact")
    told = [f"lane {lane}: {each.attrs['message']}" for lane, each in enumerate(maps)]
    return whole.assign_attrs(
        status=maps[-1].attrs["status"],
        message="; ".join(told),
        initial=str([each.attrs["initial"] for each in maps]),
    )
