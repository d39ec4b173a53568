"""`edge_state`: the motion on the border between two basins."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor_search import (
    FIRST_LOOK,
    AttractorSearch,
    drift_mask,
    measure_of,
)
from nonsmooth.analysis.basins.folded_runner import runner_within_turns
from nonsmooth.analysis.basins.recurrences import Known
from nonsmooth.analysis.basins.region import Completion, read_completion
from nonsmooth.analysis.edges.edge_dataset import edge_dataset
from nonsmooth.analysis.edges.straddle import Straddle
from nonsmooth.analysis.edges.track import Spans, follow_edge
from nonsmooth.analysis.options import SharedOptions, check_match
from nonsmooth.engine.lanes import ANY
from nonsmooth.errors import OptionError
from nonsmooth.progress import Progress
from nonsmooth.runs.maps import Map
from nonsmooth.runs.of_system import map_of
from nonsmooth.runs.options import positive_number, whole_number
from nonsmooth.runs.part_names import OF_EDGES, check_part_names
from nonsmooth.runs.runner import build_tables
from nonsmooth.runs.start import check_carried, resolve_start
from nonsmooth.runs.whole_turns import periods_of_states

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["edge_state"]

Floats = npt.NDArray[np.float64]

_LEAST = 1e-13  # beside the spread, above the rounding of a state


def edge_state(
    system: Any,
    start_a: Any,
    start_b: Any,
    *,
    completion: Mapping[str, float | str] | None = None,
    iterates: int = 1000,
    points: int = 32,
    narrow: float = 1e-9,
    wide: float = 1e-4,
    cells: int = 64,
    longest: int = 10_000,
    record: int = 20_000,
    match: float = 1e-6,
    parameters: Mapping[str, float] | None = None,
    mode: str | None = None,
    tolerance: float = 1e-12,
) -> xr.Dataset:
    """Follow the border between two basins to the saddle on it, from one start in each.

    Parameters
    ----------
    system : System or map
        A system with a period, for its stroboscopic map, or a `StroboscopicMap` or `PoincareMap`.
    start_a, start_b : mapping or dataset
        Starts that come to different attractors: states by name, a point of a dataset, which is
        first followed to the next point of the map, or one attractor of `attractors` or
        `basins_of_attraction`, as in ``found.sel(attractor=1)``. On one side motions may also end
        early, as those that diverge.
    completion : mapping of str to float or str, optional
        States that the others give at a start, as in `attractors`, such as ``{"q": "max(0, p -
        g)"}``: starts between the two get them anew, so that a mode admits each. The others lie on
        the straight line.
    iterates : int, optional
        Iterates for which the border is followed, at most.

    Other Parameters
    ----------------
    points : int, optional
        Starts along a segment that run side by side in each level of the bisection; 1 halves it.
    narrow : float, optional
        Distance, beside the spread of the states, to which a pair that straddles the border is
        brought together.
    wide : float, optional
        Distance to which it may come apart before it is brought together again.
    cells, longest, record, match : optional
        How the attractor of each start is found, see `attractors`.
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.
    mode : str, optional
        Mode to start in, where several would fit; a cell, or a mode for any of its cells.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.

    Returns
    -------
    xarray.Dataset
        Over ``point``: the states by name and ``mode``, at the points of the saddle, or, where the
        track came to none, at those of its later half. ``kind`` is "periodic" for a saddle, else
        "chaotic", "quasi-periodic" or "aperiodic", or "unresolved" where the track repeats and the
        map has no derivative there. Of the saddle ``period`` in iterates, ``multipliers`` (complex,
        exactly one outside the unit circle), ``word``, ``residual`` and, for every drifting state
        and angle, its change per iterate, as in ``q_per_iterate``; of other sets the two
        largest exponents, ``exponent`` and ``exponent_error``. ``mean`` and ``deviation`` of the
        states over the points. Over ``iterate``: ``track``, states along the border, and
        ``width``, how far it may be away. Over ``side``: the ``start``, ``outcome``, the kind of
        motion to which that side leads, its ``outcome_period``, the ``distance`` of the points from
        it, and its ``nearest`` point. ``crossing``: part of the way from a to b at which the
        segment crosses the border. Widths are those of states beside their spread, the ``distance``
        beside the largest one along each state, whatever the starts. Attributes:
        ``status``, ``message``, ``levels`` (of bisection) and ``starts_settled``.

    Raises
    ------
    OptionError
        For starts that come to one attractor or to none, or an option out of its range.

    See Also
    --------
    basins_of_attraction : all basins on a grid.
    find_orbit : an orbit with its legs, from a point of the saddle.
    manifold : the border itself, as the stable manifold of the saddle.
    nonsmooth.plot.edge_state : a picture of it.

    Notes
    -----
    The border is unstable, but a motion on it, left to itself there, settles as any other: to a
    saddle, or to a chaotic set. So a pair of states on both sides is brought together by bisection,
    runs until it has come apart, and is brought together again (Skufca, Yorke and Eckhardt 2006).
    At each level the starts along the segment run side by side until each has come to an attractor,
    and neighbours with different outcomes are the next pair.

    Where the track repeats, Newton's method on the exact map, with derivatives through all events,
    finds the saddle to rounding, and the result no longer depends on ``narrow`` and ``wide``. It is
    taken only if exactly one of its multipliers lies outside the unit circle, as it must on a
    border. Otherwise the result is the track itself, to within its ``width``.

    Where the border is fractal, a segment crosses it many times; the first crossing between the
    outcomes of both ends is followed. Where a third basin lies between, its border with the first
    one is, and ``outcome`` tells. The states between two points of the map are taken on a straight
    line, which a curved constraint of a mode may not admit. That line runs between the values of an
    angle that are given; afterwards angles count up to whole turns.

    References
    ----------
    J. D. Skufca, J. A. Yorke and B. Eckhardt, Edge of chaos in a parallel shear flow, Physical
    Review Letters 96, 174101 (2006).

    G. Datseris and A. Wagemakers, Effortless estimation of basins of attraction, Chaos 32, 023104
    (2022).

    Examples
    --------
    Between the wells of a double well that is not shaken lies the top of the hill:

    >>> import nonsmooth as ns
    >>> wells = ns.System(
    ...     states=["x", "v"], equations={"x": "v", "v": "x - x**3 - 0.5*v"}, period=1.0
    ... )
    >>> edge = ns.edge_state(wells, {"x": -0.7}, {"x": 1.2}, iterates=50)
    >>> edge["kind"].item(), bool(abs(edge["x"]).max() < 1e-12)
    ('periodic', True)
    >>> edge["multipliers"].values.real.round(4)
    array([2.1831, 0.2778])
    """
    chosen = map_of(system, parameters, tolerance, "edge_state", mode=mode, states_only=True)
    check_part_names(chosen.system, OF_EDGES)
    spans = _read_spans(narrow, wide, iterates)
    whole = {
        name: whole_number(name, value)
        for name, value in (("points", points), ("cells", cells), ("longest", longest),
                            ("record", record))
    }  # fmt: skip
    close = check_match(match)
    given = tuple(
        n
        for n in chosen.system.states
        if not isinstance(completion, Mapping) or n not in completion
    )
    rule = read_completion(chosen.system, given, completion)
    ends, modes = _read_starts(chosen, {"start_a": start_a, "start_b": start_b}, parameters, mode,
                               tolerance)  # fmt: skip
    drifting = drift_mask(chosen.system)
    complete = _completed(rule) if completion else None
    straddle = Straddle(
        _search(chosen, ends, complete, whole, close, tolerance, drifting), whole["points"],
        periods_of_states(chosen.system),
    )  # fmt: skip
    pair = straddle.begin(ends, modes)
    with Progress("edge state", spans.iterates) as progress:
        found = follow_edge(straddle, pair, spans, drifting, complete, progress.update)
    options = {
        "narrow": spans.narrow, "wide": spans.wide, "iterates": spans.iterates, "match": close,
        **whole, "completion": str(dict(rule.texts)), **chosen.protocol,
        **SharedOptions(parameters, tolerance).recorded,
    }  # fmt: skip
    return edge_dataset(chosen, straddle, found, ends, options, tolerance)


def _read_spans(narrow: Any, wide: Any, iterates: Any) -> Spans:
    small, large = positive_number("narrow", narrow), positive_number("wide", wide)
    if not _LEAST <= small < large < 1.0:
        raise OptionError(
            f"narrow = {small:g} and wide = {large:g} must grow in this order, from {_LEAST:g} to"
            " less than 1"
        )
    return Spans(small, large, whole_number("iterates", iterates))


def _read_starts(
    chosen: Map, given: Mapping[str, Any], parameters: Any, mode: Any, tolerance: float
) -> tuple[Floats, tuple[tuple[int, ...], tuple[int, ...]]]:
    """States of both starts, and the modes that each may begin in."""
    found = []
    for name, start in given.items():
        try:
            found.append(_read_start(chosen, start, parameters, mode, tolerance))
        except OptionError as fault:
            raise OptionError(re.sub(r"^initial\b", name, str(fault))) from None
    (a, of_a), (b, of_b) = found
    return np.array([a, b]), (of_a, of_b)


def _read_start(
    chosen: Map, given: Any, parameters: Any, mode: Any, tolerance: float
) -> tuple[Floats, tuple[int, ...]]:
    """State of one start, and the modes that it may begin in."""
    check_carried(chosen.system, given, parameters)
    if not hasattr(given, "data_vars"):
        start = resolve_start(chosen.system, build_tables(chosen.system), given, None, mode)
        return start.state, start.modes
    if "points" not in given:
        point = chosen.iterate(given, 1, mode=mode, tolerance=tolerance)
        if not point.sizes["point"]:
            raise OptionError(
                "initial: the motion from it comes to no point of the map:"
                f" {point.attrs['message']}"
            )
        state = [float(point[name][0]) for name in chosen.system.states]
        number = int(point["mode"][0])
    else:
        if given["points"].dims != ("point", "state"):
            raise OptionError(
                "initial: the dataset has several attractors; take one, as in"
                " found.sel(attractor=1)"
            )
        if list(given["state"].values) != list(chosen.system.states):
            raise OptionError(f"initial: the attractor is not one of {chosen.system.name!r}")
        state, number = given["points"].values[0], int(given["mode"][0])
    return np.array(state, float), (number, ANY) if number >= 0 else (ANY,)


def _completed(rule: Completion) -> Any:
    """What gives starts on a segment the states that follow from others."""
    columns = [rule.system.states.index(name) for name in rule.given]
    return lambda states: rule.states(np.ascontiguousarray(states[:, columns]))


def _search(
    chosen: Map,
    ends: Floats,
    complete: Any,
    whole: Mapping[str, int],
    match: float,
    tolerance: float,
    drifting: npt.NDArray[np.bool_],
) -> AttractorSearch:
    """A search for attractors whose units are those of motions from all over the segment."""
    runner = runner_within_turns(chosen, tolerance)
    starts = ends[0] + np.linspace(0.0, 1.0, whole["points"] + 2)[:, None] * (ends[1] - ends[0])
    if complete is not None:
        starts = complete(starts)
    images, _ = runner.iterate(runner.start(starts, ANY), FIRST_LOOK)
    known = Known(measure_of(images, starts, drifting, whole["cells"]))
    return AttractorSearch(
        runner, known, drifting, match=match, longest=whole["longest"], record=whole["record"]
    )
