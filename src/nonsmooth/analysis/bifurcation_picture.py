"""`bifurcation_picture`: attractors, basins' shares and all branches over a parameter, at once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.basins.attractor_search import SearchOptions, drift_mask, read_search
from nonsmooth.analysis.basins.region import read_box
from nonsmooth.analysis.options import SharedOptions, refuse_fixed, result_attributes
from nonsmooth.analysis.orbit_search.branches import read_bounds
from nonsmooth.analysis.orbits import orbits
from nonsmooth.analysis.pictures.branches import BranchCollector, OrbitPoints, strobes_of
from nonsmooth.analysis.pictures.chunks import Chunks, open_chunks
from nonsmooth.analysis.pictures.columns import Column, follow_numbers, settle_columns
from nonsmooth.analysis.pictures.picture_dataset import picture_dataset
from nonsmooth.analysis.statistics.escape import said_of_chaos
from nonsmooth.errors import ModelError, OptionError, is_known, unknown_name
from nonsmooth.progress import Progress
from nonsmooth.runs.of_system import map_of
from nonsmooth.runs.options import whole_number
from nonsmooth.runs.packed_datasets import pack_dataset, unpack_dataset
from nonsmooth.runs.part_names import OF_BRANCHES, check_part_names
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.system.compile.clock_states import clock_states
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["bifurcation_picture"]

_CELLS = 32  # across the spread of each state, which the points of a record fill
_ITERATES = 10  # records after which a start that has come to nothing is unsettled
_ALONG = 15  # times between two strobes, at which motions are looked at for the sizes of states
_CONSTANT = 1e-6  # of its size: the spread of a state that only rounding changes
_EXPONENT_STEPS = 250  # of four iterates each: enough to tell chaos, at each of many values
_SAMPLES, _GUESSES, _RECORD = 20, 40, 200  # of the search for unstable orbits


def bifurcation_picture(
    system: System | StroboscopicMap,
    parameter: str,
    between: tuple[float, float],
    region: Mapping[str, Any],
    *,
    columns: int = 101,
    longest: int = 2,
    searches: int = 5,
    completion: Mapping[str, float | str] | None = None,
    samples: int = 50,
    seed: int = 0,
    record: int = 1000,
    points: int = 100,
    steps: int = 1000,
    parameters: Mapping[str, float] | None = None,
    tolerance: float = 1e-12,
    store: str | Path | None = None,
) -> xr.Dataset:
    """Draw up all that a system does over a parameter: attractors, basins and branches of orbits.

    Parameters
    ----------
    system : System or StroboscopicMap
        A system with a period; a map says at which phase points lie.
    parameter : str
        The parameter that varies.
    between : tuple of float
        Its lowest and its highest value.
    region : mapping of str to (float, float)
        For some states the range from which starts are drawn.
    columns : int, optional
        Values of the parameter at which attractors are looked for, spread evenly.
    longest : int, optional
        Longest period of the orbits whose branches are followed, in periods of the forcing.
    searches : int, optional
        Values of the parameter at which unstable orbits are looked for, spread evenly; 0 for none
        but those on the branches of stable orbits, and those that leave them.
    completion : mapping of str to float or str, optional
        States outside the region, as in `attractors`.
    samples : int, optional
        Number of admissible starts at each value; the same at all values.
    seed : int, optional
        Seed of the random numbers: the same seed gives the same result. They scramble the Sobol
        sequence from which starts are drawn.
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.

    Other Parameters
    ----------------
    record : int, optional
        Iterates of an attractor that does not repeat, as in `attractors`. A start that has come to
        nothing within ten times as many is unsettled.
    points : int, optional
        Points of each attractor that are kept at each value.
    steps : int, optional
        Points of a branch in either direction, at most.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.
    store : str or Path, optional
        Folder in which finished parts are kept, made where it is missing. After an interruption
        the same call goes on from them. A part is what is found at one value of the parameter, one
        search, or one branch. ``points`` may change.

    Returns
    -------
    xarray.Dataset
        Over ``parameter`` and ``attractor``: ``settled`` (points over ``strobe`` and ``state``),
        ``kind``, ``period``, ``fraction`` of the starts with its standard error, and of what does
        not repeat ``exponent``, ``chaotic_for`` and ``escape_rate_below``, as in `attractors`;
        empty, 0 and nan where the attractor does not exist. Over
        ``parameter``, the shares of starts that are ``unsettled`` and ``ended``. The branches stand
        one behind another over ``point``, with ``branch_of_point``, the states, the parameter,
        ``stable``, ``admissible``, ``word`` and more; their special points over ``special``, with
        ``branch_of_special``. Over ``branch``: ``branch_period``, and how both ends came about.

    Raises
    ------
    OptionError
        For an unknown state or parameter, an empty range, a region without admissible starts, an
        option out of its range, or a ``store`` that was begun with other options.
    RunError
        When the store could not be written, for want of room for one; what is done is kept there.

    See Also
    --------
    bifurcation_diagram : settled motions alone, faster.
    attractors : those at one value, with more about each.
    continue_orbit : one branch, with all about its orbits.
    nonsmooth.plot.bifurcation_picture : draws the result.

    Notes
    -----
    At each value starts drawn from the region run to their attractors, as in `attractors`. Two
    more passes, up and down, begin on the attractors of the neighbouring value; so an attractor
    with a small basin is kept once it was found. Two attractors of neighbouring values have the
    same number where motions from each lead to the other when the parameter takes the step, up and
    down (compare G. Datseris, K. Luiz Rossi and A. Wagemakers, Chaos 33, 073151, 2023, who match
    them by their distance).

    Every stable cycle up to the longest period, and every orbit that `orbits` finds at the values
    of the searches, begins a branch, unless the orbit of a known branch at the same value agrees
    with it to 1e-6 of the spread of the states along the motions. Branches that leave others at
    flips, at points where a symmetry breaks and at crossings are followed too. So a branch that
    ends at a corner goes on with the motion that settles beyond, as a branch of its own. A branch
    of unstable orbits that neither crosses a value of the searches nor leaves another branch is
    missed.

    References
    ----------
    G. Datseris, K. Luiz Rossi and A. Wagemakers, Framework for global stability analysis of
    dynamical systems, Chaos 33, 073151 (2023).

    Examples
    --------
    A soft stop beyond its grazing, where two motions exist:

    >>> import nonsmooth as ns
    >>> soft = ns.models.soft_impact(omega=0.8)
    >>> picture = ns.bifurcation_picture(
    ...     soft,
    ...     "a",
    ...     (0.3, 0.5),
    ...     {"x": (-2, 2), "v": (-2, 2)},
    ...     columns=5,
    ...     samples=10,
    ...     searches=0,
    ...     longest=1,
    ... )
    >>> picture["period"].values[:, 0].tolist(), picture.sizes["branch"]
    ([1, 1, 1, 1, 1], 1)
    """
    shared = SharedOptions(parameters, tolerance, store=store, seed=seed)
    chosen = map_of(
        system, parameters, tolerance, "bifurcation_picture", states_only=True, strobes_only=True
    )
    if not isinstance(chosen, StroboscopicMap):
        raise OptionError(
            "system: a bifurcation picture is one of strobes; give a system with a period, or a"
            " StroboscopicMap of one"
        )
    base = chosen.system
    clocks = {} if base.is_driven else clock_states(base.structure)
    if clocks:
        raise OptionError(
            f"system: no equation of {base.name!r} reads the time; its clock is the state"
            f" {next(iter(clocks))!r}, which may begin anywhere, so no motion of the map attracts"
            " those beside it; follow branches by continue_orbit, and draw them over a diagram:"
            " plot.branch(branch, y, diagram=diagram)"
        )
    if not is_known(parameter, base.parameters):
        raise OptionError(unknown_name("parameter", parameter, base.parameters))
    check_part_names(base, OF_BRANCHES, parameters=(parameter,))
    refuse_fixed(system, parameters, (parameter,), "parameter")
    low, high = read_bounds(between)
    box = read_box(base, region, completion)
    longest, steps = whole_number("longest", longest), whole_number("steps", steps)
    points = whole_number("points", points)
    n_searches = whole_number("searches", searches, least=0)
    record = whole_number("record", record)
    how = read_search(samples, _CELLS, _ITERATES * record, record, 1e-6, shared)
    how = replace(how, exponent_steps=_EXPONENT_STEPS)
    values = np.linspace(low, high, whole_number("columns", columns, least=2))
    maps = [(float(value), _at(chosen, parameter, float(value))) for value in values]
    options = {
        "parameter": parameter, "between": f"{low:g} {high:g}",
        **{f"region_{name}": str((a, b)) for name, a, b in zip(
            box.completion.given, box.low.tolist(), box.high.tolist(), strict=True)},
        "completion": str(dict(box.completion.texts)), **chosen.protocol, **how.options,
        "longest_period": longest, "searches": n_searches, "phase_of_period": chosen.phase,
        **shared.recorded,
    }  # fmt: skip
    protocol = {
        "call": "bifurcation_picture",
        "system": base.to_toml(), "parameter": parameter, "between": [low, high],
        "columns": values.size, "longest": longest, "searches": n_searches, "steps": steps,
        "region": {name: [float(end) for end in ends] for name, ends in region.items()},
        "completion": dict(box.completion.texts), "samples": how.samples, "record": record,
        **chosen.protocol, "phase": chosen.phase, **shared.recorded, "seed": how.seed,
    }  # fmt: skip
    with open_chunks(shared.store, protocol) as chunks:
        with Progress("attractors", 2 * len(maps) - 1) as progress:
            found, complete = settle_columns(
                maps, lambda each: read_box(each.system, region, completion), how,
                progress.update, chunks,
            )  # fmt: skip
        collector = BranchCollector(
            chosen, parameter, (low, high), longest, _scale(maps, found, tolerance), steps,
            tolerance, chunks,
        )  # fmt: skip
        if complete:
            anchors = np.linspace(low, high, n_searches + 2)[1:-1]
            try:
                collector.add_all(_cycles(found, longest))
                collector.add_all(
                    _unstable(chosen, parameter, anchors, region, completion, longest, how, chunks)
                )
            except KeyboardInterrupt:
                collector.complete = False
    complete = complete and collector.complete
    said = _message(found, collector, complete)
    attrs = result_attributes(base, "completed" if complete else "interrupted", said, options)
    return picture_dataset(
        base, parameter, found, follow_numbers(found), collector.branches, points, attrs
    )


def _at(chosen: StroboscopicMap, parameter: str, value: float) -> StroboscopicMap:
    """The map at a value; an error says which value the system refuses."""
    try:
        return chosen.with_parameters(**{parameter: value})
    except ModelError as fault:
        raise OptionError(f"between: the system refuses {parameter} = {value:g}: {fault}") from None


def _scale(
    maps: Sequence[tuple[float, StroboscopicMap]], columns: Sequence[Column], tolerance: float
) -> Any:
    """Spread of each state along motions on the attractors; infinite for states that drift.

    On the way between strobes too: at the strobe itself a machine may be at rest at all values.
    """
    drifting = drift_mask(maps[0][1].system)
    every = [np.zeros((0, drifting.size))]
    for (_, there), column in zip(maps, columns, strict=False):  # those that are done
        if column.attractors:
            every += [each.points for each in column.attractors]
            last = np.array([each.points[-1] for each in column.attractors])
            moving = there.runner(tolerance).along(last, _ALONG).reshape(-1, drifting.size)
            every.append(moving[np.isfinite(moving).all(axis=1)])
    states = np.concatenate(every)
    if not len(states):
        return np.where(drifting, np.inf, 1.0)
    spread, size = np.ptp(states, axis=0), np.abs(states).max(axis=0)
    least = 1e-9 * float(np.max(spread[~drifting], initial=0.0)) or 1.0
    return np.where(drifting, np.inf, np.maximum(np.maximum(spread, _CONSTANT * size), least))


def _cycles(columns: Sequence[Column], longest: int) -> Iterator[OrbitPoints]:
    """Stable cycles, the shortest first, from the middle of the range outwards."""
    middle = len(columns) // 2
    order = sorted(range(len(columns)), key=lambda k: abs(k - middle))
    for period in range(1, longest + 1):
        for k in order:
            for each in columns[k].attractors:
                if each.period == period:
                    yield OrbitPoints(columns[k].value, each.points)


def _unstable(
    chosen: StroboscopicMap,
    parameter: str,
    anchors: Any,
    region: Mapping[str, Any],
    completion: Any,
    longest: int,
    how: SearchOptions,
    chunks: Chunks,
) -> Iterator[OrbitPoints]:
    """Orbits of any stability at some values."""
    for value in anchors:
        there = _at(chosen, parameter, float(value))
        search = partial(
            orbits,
            there,
            region,
            completion=completion,
            longest=longest,
            seed=how.seed,
            samples=_SAMPLES,
            guesses=_GUESSES,
            record=_RECORD,
            tolerance=how.tolerance,
        )
        found = chunks.take(
            search, pack_dataset, unpack_dataset, lambda one: one.attrs["status"] != "interrupted"
        )
        if found.attrs["status"] == "interrupted":
            raise KeyboardInterrupt
        for k in range(found.sizes["orbit"]):
            orbit = found.isel(orbit=k)
            state = np.array([float(orbit[name]) for name in chosen.system.states])
            points = strobes_of(there, state, int(orbit["period"]), how.tolerance)
            yield OrbitPoints(float(value), points, orbit)


def _message(columns: Sequence[Column], collector: BranchCollector, complete: bool) -> str:
    """What was found, and what was not."""
    said = ["completed" if complete else "interrupted by the user; what was found is kept"]
    most = max((len(column.attractors) for column in columns), default=0)
    said.append(
        f"up to {most} attractors at one value; {len(collector.branches)} branches of orbits"
    )
    unsettled = sum(bool(np.any(column.labels == 0)) for column in columns)
    if unsettled:
        said.append(f"at {unsettled} values some starts are unsettled: raise record=")
    horizons = [one.chaotic_for for each in columns for one in each.attractors if one.chaotic_for]
    if horizons:
        where = sum(any(one.chaotic_for for one in each.attractors) for each in columns)
        said.append(
            f"chaos at {where} value{'s' * (where > 1)} may be a long transient:"
            f" {said_of_chaos(min(horizons), 'period')}"
        )
    ended = sum(bool(np.any(column.labels < 0)) for column in columns)
    if ended:
        statuses = dict.fromkeys(one for each in columns for one in each.found.settled.endings)
        told = ", ".join(one.word for one in statuses)
        said.append(f"at {ended} values some starts ended early" + (f": {told}" if told else ""))
    if collector.is_full:
        said.append(
            f"no more branches than {len(collector.branches)} are followed: lower longest=, or"
            " choose a shorter range"
        )
    if collector.failures:
        said.append(
            f"{len(collector.failures)} orbits began no branch, the first at"
            f" {collector.failures[0]}"
        )
    return "; ".join(said)
