"""`return_map`: a motion from section to section, by one coordinate."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.options import SharedOptions, result_attributes
from nonsmooth.analysis.returns.borders import border_kinds, find_borders, find_fixed_points, pieces
from nonsmooth.analysis.returns.family import Coordinate, StartFamily, read_coordinate, read_family
from nonsmooth.analysis.returns.from_points import map_of_points
from nonsmooth.analysis.returns.images import Imaging, imaging_of, settle
from nonsmooth.analysis.returns.reduced_map import (
    MappedStarts,
    ReducedMap,
    deviations_of_family,
    deviations_of_points,
    relative,
)
from nonsmooth.engine.status import Status
from nonsmooth.errors import OptionError, ResultWarning, quote
from nonsmooth.progress import Progress
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.first_mode import explain_misfit
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.lane_runner import LaneRunner
from nonsmooth.runs.maps import Map
from nonsmooth.runs.of_system import map_of
from nonsmooth.runs.options import finite_number, whole_number
from nonsmooth.runs.poincare_map import PoincareMap
from nonsmooth.runs.start import Start

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["return_map"]

_MUCH = 0.01  # of the range of images; what a coordinate does not tell is told to the user
_PER_START = 5  # times that the map is taken, about, with borders and fixed points

Floats = npt.NDArray[np.float64]


def return_map(
    system: Any,
    coordinate: str,
    between: tuple[float, float] | None = None,
    *,
    points: xr.Dataset | None = None,
    completion: Mapping[str, float | str] | None = None,
    samples: int = 401,
    order: int = 1,
    mode: str | None = None,
    longest: int = 1000,
    parameters: Mapping[str, float] | None = None,
    tolerance: float = 1e-12,
) -> xr.Dataset:
    """Compute the map of one coordinate from a point of a section to the next.

    Where motions contract strongly, or modes hold some states to others, a single number tells
    nearly all about a point of a section: the phase of an impact, say. The map of that number
    shows cycles as fixed points, chaos as a slope above one, and where the word changes it jumps
    or has corners.

    Parameters
    ----------
    system : System or map
        A `PoincareMap`, whose section may be the name of an event, a `StroboscopicMap`, or a
        system with a period, for its stroboscopic map.
    coordinate : str
        A state, or ``"phase"``: the time since the period began, at a point of a section.
    between : (float, float), optional
        Interval of the coordinate in which starts lie.
    points : xarray.Dataset, optional
        In place of ``between``: points of one motion on the section, as `poincare_section` and
        `stroboscopic_map` give them. Their map is a first-return plot.
    completion : mapping of str to float or str, optional
        The other states of a start, and for a section its ``"phase"``: numbers, or expressions of
        the coordinate, of parameters, and of those completed before. States that are not given
        are as ``mode`` holds them, or at rest, and the phase is 0.
    samples : int, optional
        Starts in the interval, evenly spaced; both sides of each border are added to them.
    order : int, optional
        Which return is the image: 2 is the map applied twice.
    mode : str, optional
        Mode to start in, where several would fit; a cell, or a mode for any of its cells.
    longest : int, optional
        Periods of the forcing, or windows of time without one, after which a start without a
        return is given up.
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.

    Returns
    -------
    xarray.Dataset
        Over ``start``, the values of the coordinate: ``image``, its exact ``slope``,
        ``deviation`` (see Notes), ``return_time``, ``word`` and ``exits`` on the way,
        ``n_events``, ``certified``, ``status`` (why there is no image: ``inadmissible`` where no
        mode admits the start, ``time_limit`` where nothing returned), the number of the
        ``piece`` between borders, ``start_state`` and ``image_state``.

        Over ``border``, with ``between``: ``border_start``, refined to rounding, ``border_kind``,
        ``image_before`` and ``image_after``, ``exits_before`` and ``exits_after``. A border is a
        "jump", a "corner", a "root" (continuous, with a slope that grows without bound, as by
        grazing a rigid wall), "smooth" up to the first derivative, or an "end" of the images.

        Over ``fixed_point``, with ``between``: ``fixed_start``, ``fixed_slope``,
        ``fixed_stable``, ``fixed_deviation``, ``fixed_word``, ``fixed_state``.

        ``turn``, for a phase or an angle: where it begins anew. ``spread`` and
        ``largest_spread``: median and largest deviation over the range of the
        images. With ``points``, ``exponent_per_return``: growth of the two fastest directions.

    Raises
    ------
    OptionError
        For an unknown coordinate, a coordinate that drifts, no start that any mode admits, or an
        option out of its range.

    Warns
    -----
    ResultWarning
        When the coordinate does not say all: ``spread`` is above 0.01.

    See Also
    --------
    PoincareMap, StroboscopicMap : all coordinates of the map.
    plot.cobweb, plot.return_map : pictures of the result.

    Notes
    -----
    The image of a start need not lie on the family of starts. ``deviation`` tells what that
    costs: the motion goes on to the next point, and the map is applied to the coordinate of the
    first; the difference is the deviation. It is zero where one coordinate says all, and where a
    fixed point of the map is a periodic motion. With ``points`` it is how far an image is off the
    line through those of the two neighbours in the coordinate.

    Slopes are derivatives along the family, through all events. With ``points`` they are those
    along the motion's own direction, in which neighbours separate fastest, and nan until that is
    known to nine digits. Borders are told by starts that do something else on their way; two of
    them between neighbouring starts that do the same are missed, so take enough ``samples``.
    At most 200 are followed.

    References
    ----------
    E. E. Pavlovskaia and M. Wiercigroch, Low dimensional maps for piecewise smooth oscillators,
    Journal of Sound and Vibration 305, 750-771 (2007), reference 44 of the chapter.

    Examples
    --------
    The speed after the next impact of a ball that keeps four fifths of it, on a table that rises
    at the speed 0.1:

    >>> import nonsmooth as ns
    >>> impact = ns.Exit("h", reset={"u": "-r*u"}, name="impact")
    >>> ball = ns.System(
    ...     states=["h", "u"],
    ...     parameters={"r": 0.8, "w": 0.1},
    ...     modes={
    ...         "flight": ns.Mode(
    ...             {"h": "u - w", "u": "-1"},
    ...             exits=[ns.Exit("h", reset={"u": "w + r*(w - u)"}, name="impact")],
    ...         )
    ...     },
    ... )
    >>> bounce = ns.PoincareMap(ball, "impact", side="after")
    >>> found = ns.return_map(bounce, "u", (0.2, 2.0), samples=10)
    >>> found["slope"].values.round(12).tolist()[:3], float(found["spread"])
    ([0.8, 0.8, 0.8], 0.0)
    """
    chosen, name = _read_map(system, coordinate, parameters, tolerance, mode, order)
    count, most = whole_number("samples", samples), whole_number("longest", longest)
    imaging = imaging_of(chosen, tolerance, most)
    options: dict[str, Any] = {
        "order": order,
        "longest": most,
        "initial_mode": mode or "",
        "completion": str(dict(completion)) if isinstance(completion, Mapping) else "",
        **SharedOptions(parameters, tolerance).recorded,
    }
    if (between is None) == (points is None):
        raise OptionError(
            "give either between=(low, high), an interval of the coordinate, or points=, a dataset"
            " of points of a motion; " + ("neither is" if points is None else "both are") + " given"
        )
    if points is not None:
        if completion or mode:
            raise OptionError(
                "points bring their states and modes: leave out completion= and mode="
            )
        return _of_points(imaging, name, points, options)
    low, high = _interval(between)
    if count < 3:
        raise OptionError(f"samples = {count}: give at least 3 starts")
    timed = chosen.points_have_time
    family = read_family(chosen.system, name, imaging.begin, completion, mode, timed=timed)
    options |= {"between": str((low, high)), "samples": count}
    return _of_family(imaging, name, family, np.linspace(low, high, count), options)


def _read_map(
    system: Any,
    coordinate: str,
    parameters: Mapping[str, float] | None,
    tolerance: float,
    mode: str | None,
    order: int,
) -> tuple[Map, Coordinate]:
    """The map, applied so many times, and the coordinate."""
    hidden = not isinstance(system, PoincareMap)
    chosen = map_of(system, parameters, tolerance, "return_map", mode=mode, states_only=hidden)
    return chosen ** whole_number("order", order), read_coordinate(chosen, coordinate)


def _interval(between: Any) -> tuple[float, float]:
    try:
        low, high = (finite_number("between", value) for value in between)
    except (TypeError, ValueError):
        low = high = 0.0
    if not low < high:
        raise OptionError(
            f"between = {quote(between)}: give two finite numbers, the lower one first, such as"
            " (0.0, 1.0)"
        )
    return low, high


def _of_family(
    imaging: Imaging,
    coordinate: Coordinate,
    family: StartFamily,
    values: npt.NDArray[np.float64],
    options: dict[str, Any],
) -> xr.Dataset:
    """Map of an interval, with its borders and fixed points."""
    import xarray as xr

    done = 0
    with Progress("return map", _PER_START * values.size) as progress:

        def report(count: int) -> None:
            nonlocal done
            done += count
            progress.update(min(done, _PER_START * values.size))

        reduced = ReducedMap(coordinate, family, imaging, report)
        branch = reduced.at(values)
        if np.all(branch.images.status == Status.INADMISSIBLE):
            raise _misfit(imaging, family, values)
        borders = find_borders(reduced, branch)
        kinds = border_kinds(reduced, borders, branch)
        low, high = reduced.at(borders.low), reduced.at(borders.high)
        whole = reduced.at(np.unique(np.concatenate([values, borders.low, borders.high])))
        piece = pieces(whole, borders)
        fixed = find_fixed_points(reduced, whole, piece)
        deviations = deviations_of_family(reduced, whole)
        at_fixed = deviations_of_family(reduced, fixed)
    median, largest = relative(coordinate, whole, deviations)
    reduction = Reduction(deviations, median, largest)
    variables, coords = over_starts(imaging, coordinate, whole, piece, reduction)
    variables |= over_borders(coordinate, BorderTable(low, high, kinds))
    variables |= over_fixed(coordinate, fixed, at_fixed)
    attrs = common_attributes(imaging.chosen, coordinate, whole, options)
    if not borders.complete:
        attrs["message"] += "; there are more borders than were followed, see piece"
    _tell_spread(imaging.chosen, coordinate, reduction)
    return xr.Dataset(variables, coords, attrs)


def _of_points(
    imaging: Imaging, coordinate: Coordinate, points: Any, options: dict[str, Any]
) -> xr.Dataset:
    """First-return plot of the points of a motion."""
    import xarray as xr

    done = 0
    with Progress("return map", max(1, int(np.size(getattr(points, "point", 1))))) as progress:

        def report(count: int) -> None:
            nonlocal done
            done += count
            progress.update(done)

        branch, exponents = map_of_points(imaging, coordinate, points, report)
    deviations = deviations_of_points(coordinate, branch)
    median, largest = relative(coordinate, branch, deviations)
    reduction = Reduction(deviations, median, largest)
    piece = np.where(branch.images.there, 0, -1)
    variables, coords = over_starts(imaging, coordinate, branch, piece, reduction)
    words = {"long_name": "growth of the fastest directions per return, as logarithm"}
    variables["exponent_per_return"] = ("exponent", exponents, words)
    attrs = common_attributes(imaging.chosen, coordinate, branch, options)
    _tell_spread(imaging.chosen, coordinate, reduction)
    return xr.Dataset(variables, coords, attrs)


def _tell_spread(chosen: Map, coordinate: Coordinate, reduction: Reduction) -> None:
    if reduction.median > _MUCH:
        # told where the user calls the verb
        warnings.warn(
            f"{chosen.system.name}: {coordinate.name!r} alone does not say all about the next"
            f" point: what it leaves open is {100.0 * reduction.median:.2g} % of the range of the"
            " images in the median; take a section behind a stronger contraction, a completion"
            " nearer to the motion, or read the map as a projection",
            ResultWarning,
            stacklevel=4,
        )


def _misfit(imaging: Imaging, family: StartFamily, values: npt.NDArray[np.float64]) -> OptionError:
    """Why no mode admits the start in the middle of the interval."""
    middle = values[[values.size // 2]]
    system = imaging.chosen.system
    engine = LaneRunner(system, imaging.tolerance)
    starts = family.starts(middle)
    settle(engine, starts, imaging.tolerance)
    instant = Instant(int(starts.number[0]), float(starts.phase[0]))
    start = Start(starts.states[0], instant, tuple(int(m) for m in starts.modes[0]))
    told = explain_misfit(system, engine.tables, start, engine.segment.z.copy())
    name = family.coordinate.name
    return OptionError(
        f"no start on {name} from {values[0]:g} to {values[-1]:g} fits a mode; at {name} ="
        f" {middle[0]:g} {told}"
    )


class BorderTable(NamedTuple):
    """Borders with the map on both sides."""

    low: MappedStarts
    high: MappedStarts
    kinds: list[str]


class Reduction(NamedTuple):
    """How one-dimensional the map is."""

    deviations: Floats
    median: float
    largest: float


def over_starts(
    imaging: Imaging, coordinate: Coordinate, branch: MappedStarts, piece: Any, reduction: Reduction
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables and coordinates over ``start``."""
    images, starts, system = branch.images, branch.starts, imaging.chosen.system
    words, label = dict(coordinate.words), coordinate.words["long_name"]
    time = labels_of(system).attributes("time")
    length = (images.number - starts.number) * imaging.window + (images.phase - starts.phase)
    statuses = [Status(int(code)).word for code in images.status]
    variables: dict[str, Any] = {
        "image": ("start", branch.image, {**words, "long_name": f"{label}, at the image"}),
        "slope": ("start", branch.slope, {"long_name": "derivative of the image by the start"}),
        "deviation": ("start", reduction.deviations, {
            **words, "long_name": "what the coordinate alone does not tell of an image"}),
        "return_time": ("start", np.where(images.there, length, np.nan), {
            **time, "long_name": "time from the start to the image"}),
        "word": ("start", images.words, {"long_name": "modes on the way"}),
        "exits": ("start", images.exits, {"long_name": "exits passed on the way"}),
        "n_events": ("start", images.n_events, {"long_name": "events on the way"}),
        "certified": ("start", images.certified & images.there, {
            "long_name": "whether rounding leaves no doubt about the events"}),
        "status": ("start", np.array(statuses), {"long_name": "how the way to the image ended"}),
        "piece": ("start", piece, {
            "long_name": "part of the map without a border, from 0; -1 without an image"}),
        "start_state": (("start", "state"), images.begun, {
            "long_name": "states at the start"}),
        "image_state": (("start", "state"), images.states, {"long_name": "states at the image"}),
        "spread": ((), reduction.median, {
            "long_name": "median of the deviations over the range of the images"}),
        "largest_spread": ((), reduction.largest, {
            "long_name": "largest deviation over the range of the images"}),
    }  # fmt: skip
    if coordinate.turn is not None:
        turn = {**words, "long_name": "length after which the coordinate begins anew"}
        variables["turn"] = ((), coordinate.turn, turn)
    coords = {
        "start": ("start", branch.values, words),
        "state": ("state", np.array(system.states), {"long_name": "state"}),
    }
    return variables, coords


def over_borders(coordinate: Coordinate, table: BorderTable) -> dict[str, Any]:
    """Variables over ``border``."""
    words, label = dict(coordinate.words), coordinate.words["long_name"]
    low, high = table.low, table.high
    return {
        "border_start": ("border", 0.5 * (low.values + high.values), {
            **words, "long_name": f"{label}, at a border"}),
        "border_kind": ("border", np.array(table.kinds, dtype=str), {
            "long_name": "what the map does at a border"}),
        "image_before": ("border", low.image, {
            **words, "long_name": f"{label}, at the image of a start just below"}),
        "image_after": ("border", high.image, {
            **words, "long_name": f"{label}, at the image of a start just above"}),
        "exits_before": ("border", low.images.exits, {"long_name": "exits passed just below"}),
        "exits_after": ("border", high.images.exits, {"long_name": "exits passed just above"}),
    }  # fmt: skip


def over_fixed(coordinate: Coordinate, fixed: MappedStarts, deviations: Floats) -> dict[str, Any]:
    """Variables over ``fixed_point``."""
    words, label = dict(coordinate.words), coordinate.words["long_name"]
    return {
        "fixed_start": ("fixed_point", fixed.values, {
            **words, "long_name": f"{label}, at a fixed point"}),
        "fixed_slope": ("fixed_point", fixed.slope, {"long_name": "derivative at a fixed point"}),
        "fixed_stable": ("fixed_point", np.abs(fixed.slope) < 1.0, {
            "long_name": "whether the map of one coordinate is stable there"}),
        "fixed_deviation": ("fixed_point", deviations, {
            **words, "long_name": "what the coordinate alone does not tell at a fixed point"}),
        "fixed_word": ("fixed_point", fixed.images.words, {"long_name": "modes on the way"}),
        "fixed_state": (("fixed_point", "state"), fixed.images.begun, {
            "long_name": "states at a fixed point"}),
    }  # fmt: skip


def common_attributes(
    chosen: Map, coordinate: Coordinate, branch: MappedStarts, options: dict[str, Any]
) -> dict[str, Any]:
    """Attributes of a result, with how it ended."""
    system = chosen.system
    lost = branch.images.status[~branch.images.there]
    counts = {Status(int(code)).word: int(np.sum(lost == code)) for code in np.unique(lost)}
    message = "completed"
    if counts:
        told = ", ".join(f"{count} {word}" for word, count in counts.items())
        message = f"starts without an image, see status: {told}"
    recorded = {"variable": coordinate.name, **chosen.protocol, **options}
    if system.period_value is not None:
        recorded["period"] = system.period_value
    return result_attributes(system, "completed", message, recorded)
