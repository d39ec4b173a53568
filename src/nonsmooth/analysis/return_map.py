"""`return_map`: a motion from section to section, by one coordinate."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.returns.borders import border_kinds, find_borders, pieces
from nonsmooth.analysis.returns.coordinate import Coordinate, read_coordinate
from nonsmooth.analysis.returns.family import Family, read_family
from nonsmooth.analysis.returns.fixed_points import find_fixed_points
from nonsmooth.analysis.returns.from_points import map_of_points
from nonsmooth.analysis.returns.images import Imaging, imaging_of
from nonsmooth.analysis.returns.lane_log import settle
from nonsmooth.analysis.returns.reduced_map import ReducedMap
from nonsmooth.analysis.returns.return_dataset import (
    BorderTable,
    Reduction,
    common_attributes,
    over_borders,
    over_fixed,
    over_starts,
)
from nonsmooth.analysis.returns.spread import deviations_of_family, deviations_of_points, relative
from nonsmooth.engine.status import Status
from nonsmooth.errors import OptionError, ResultWarning
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.first_mode import explain_misfit
from nonsmooth.runs.lane_runner import LaneRunner
from nonsmooth.runs.maps import Map
from nonsmooth.runs.of_system import map_of
from nonsmooth.runs.options import finite_number, whole_number
from nonsmooth.runs.poincare_map import PoincareMap
from nonsmooth.runs.progress import Progress
from nonsmooth.runs.start import Start

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["return_map"]

_MUCH = 0.01  # of the range of images; what a coordinate does not tell is told to the user
_PER_START = 5  # times that the map is taken, about, with borders and fixed points


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
        Mode of the starts, as in `simulate`.
    longest : int, optional
        Periods of the forcing, or windows of time without one, after which a start without a
        return is given up.
    parameters : mapping of str to float, optional
        Changed values of parameters.
    tolerance : float, optional
        As in `simulate`.

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
    chosen, name = _read_map(system, coordinate, parameters, tolerance, order)
    count, most = whole_number("samples", samples), whole_number("longest", longest)
    imaging = imaging_of(chosen, tolerance, most)
    options: dict[str, Any] = {
        "order": order,
        "longest": most,
        "initial_mode": mode or "",
        "completion": str(dict(completion)) if isinstance(completion, Mapping) else "",
        "tolerance": float(tolerance),
        "changed_parameters": str(dict(parameters)) if parameters else "",
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
    order: int,
) -> tuple[Map, Coordinate]:
    """The map, applied so many times, and the coordinate."""
    hidden = not isinstance(system, PoincareMap)
    chosen = map_of(system, parameters, tolerance, "return_map", states_only=hidden)
    if chosen.system.signals:
        raise OptionError(
            "return_map: a measured input does not repeat, so that there is no map; take"
            " poincare_section for points of one motion"
        )
    return chosen ** whole_number("order", order), read_coordinate(chosen, coordinate)


def _interval(between: Any) -> tuple[float, float]:
    try:
        low, high = (finite_number("between", value) for value in between)
    except (TypeError, ValueError):
        low = high = 0.0
    if not low < high:
        raise OptionError(
            f"between = {between!r:.60}: give two finite numbers, the lower one first, such as"
            " (0.0, 1.0)"
        )
    return low, high


def _of_family(
    imaging: Imaging,
    coordinate: Coordinate,
    family: Family,
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


def _misfit(imaging: Imaging, family: Family, values: npt.NDArray[np.float64]) -> OptionError:
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
