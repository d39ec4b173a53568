"""`manifold`: the curves along which motions leave a saddle orbit, or come to it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

from nonsmooth.analysis.manifolds.grow_curves import (
    SIDES,
    check_choice,
    grow_curves,
    read_spacing,
)
from nonsmooth.analysis.manifolds.manifold_dataset import manifold_dataset
from nonsmooth.analysis.manifolds.saddle import find_saddle
from nonsmooth.analysis.options import SharedOptions
from nonsmooth.runs.of_system import map_of
from nonsmooth.runs.options import positive_number
from nonsmooth.runs.part_names import OF_MANIFOLDS, check_part_names

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["manifold"]

_WHICH = ("unstable", "stable")


def manifold(
    system: Any,
    orbit: Any,
    *,
    which: Literal["unstable", "stable"] = "unstable",
    length: float = 10.0,
    side: Literal["both", "+", "-"] = "both",
    scales: Mapping[str, float] | None = None,
    largest_step: float | None = None,
    parameters: Mapping[str, float] | None = None,
    smallest_step: float | None = None,
    angle: float = 0.2,
    accuracy: float = 1e-11,
    steps: int = 20_000,
    longest: int = 200,
    tolerance: float = 1e-12,
) -> xr.Dataset:
    """Follow the unstable or the stable manifold of a saddle orbit, as curves of a map.

    Parameters
    ----------
    system : System or map
        A system with a period, for its stroboscopic map, or a `StroboscopicMap` or `PoincareMap`.
    orbit : xarray.Dataset
        Result of `find_orbit`, or one orbit of `orbits` or `continue_orbit`, as in
        ``branch.isel(point=3)``, of the same system at the same parameters. Exactly one of its
        multipliers is outside the unit circle, and it is real.
    which : {"unstable", "stable"}, optional
        The curves along which motions leave the orbit, or those along which they come to it.
    length : float, optional
        Length of each curve, in scaled states.
    side : {"both", "+", "-"}, optional
        Curves to both sides of the orbit, or to one. The plus side is that to which the largest
        component of the direction, in scaled states, is positive; of components that are equal to
        within 1e-6 of the largest, the first.
    scales : mapping of str to float, optional
        Sizes by which states are divided before lengths and angles are measured, 1 without it.
        Give them where states have very different sizes, as in SI units.
    largest_step : float, optional
        Largest distance of neighbouring points, in scaled states; ``length/200`` without it.
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.

    Other Parameters
    ----------------
    smallest_step : float, optional
        Length of a step below which points are close enough at whatever angle; a thousandth of the
        largest step without it.
    angle : float, optional
        Angle that a curve turns by at a point, at most (rad), but for corners.
    accuracy : float, optional
        Deviation of the manifold from the first, straight piece, at most, in scaled states.
    steps : int, optional
        Points of one curve, at most.
    longest : int, optional
        Images of the first piece, at most, of an unstable manifold.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.

    Returns
    -------
    xarray.Dataset
        Over ``point``, one curve after the other, each from the orbit on: the states by name
        (drifts left out), ``arclength``, ``image`` (applications of the map between the point and
        the first piece), ``word`` (modes on the way to the point from its preimage on the curve;
        of a stable manifold from the point to its image), ``border`` (kind of the border at which
        the point lies, or empty), and the coordinates ``side`` (1 or -1), ``orbit_point`` (iterate
        of the orbit) and ``curve_of_point``. Over ``at_border``: ``border_point`` (number of the
        first of two neighbours that rounding alone separates), ``border_kind``, ``border_turn``
        and ``border_gap``. Over ``curve``: ``curve_side``, ``curve_orbit_point``, ``curve_end``
        (why it ends), ``first_length`` and ``first_deviation`` of the straight piece, ``saddle``
        and ``saddle_direction``. ``multipliers`` of the orbit. Attributes: ``status``, ``message``,
        ``period`` (iterates in one turn), ``sides_alternate`` (1 where motions come to one side of
        the orbit and the other in turn, so that the map of two turns is taken), ``multiplier`` of
        the map that is taken, and ``residual`` of the orbit.

    Raises
    ------
    OptionError
        For an orbit that is no saddle or belongs to another system or other parameters, a stable
        manifold of a map that is not one of the plane, or an option out of its range.

    See Also
    --------
    find_orbit : a periodic orbit, stable or not.
    basins_of_attraction : regions between which a stable manifold may be the border.
    nonsmooth.plot.manifold : a picture of it.

    Notes
    -----
    Each point of an orbit of period n has its own curves, of the map applied n times. Where the
    multiplier is negative it is applied 2n times, so that a curve is mapped to itself.

    The first piece lies along the eigenvector of the map's derivative through all events. It is
    halved until the quadratic term of the manifold, which one image of it tells, is below
    ``accuracy`` at its far end, and all of it does the same events on its way. That half the
    length leaves a quarter of the deviation, or rounding, is checked; ``first_deviation`` has it.

    *Unstable*: images of the first piece follow each other on the curve (Hobson 1993). Points are
    inserted on the first piece itself until images are dense enough, so that every point is an
    image of the exact map and nothing is interpolated. Deviations of the first piece shrink on the
    way, as the other directions contract. Where neighbours have different itineraries (modes or
    exits on their way), the first piece is halved to rounding between them. ``border_kind`` is then
    ``corner`` where the curve turns by an angle there, as at a border of a piecewise-linear map or
    a graze of a rigid wall, ``jump`` where images do not come together, ``end`` where one has no
    image, and ``smooth`` where there is no corner: the angle is that between points close beside
    the border, and one that halves as they come a hundred times as near is a bend.

    *Stable*: flows through resets do not run backwards, so the search circle of England,
    Krauskopf and Osinga is used, for maps of the plane. The next point lies on a circle around the
    last one, where its image lies on the curve known so far. Afterwards every point is put onto
    the manifold itself: halving a line across the curve by the side to which further images leave
    it locates it to rounding, without an error from chords between points. Borders are found by
    halving along the curve; ``unresolved`` are those where that has failed. Of several preimages
    the one that continues the curve is taken, and parts of a stable set that do not touch the
    curve are not found. The map has to keep its orientation, as flows with impacts do.

    Curves end at the length, at ``steps``, at ``longest``, or where the map ends them;
    ``curve_end`` is one of length, points, images, attractor (later images are shorter and
    shorter), no_image, no_preimage, not_located, and interrupted.

    References
    ----------
    D. Hobson, An efficient method for computing invariant manifolds of planar maps, Journal of
    Computational Physics 104, 14-22 (1993).

    B. Krauskopf and H. M. Osinga, Growing 1D and quasi-2D unstable manifolds of maps, Journal of
    Computational Physics 146, 404-419 (1998).

    J. P. England, B. Krauskopf and H. M. Osinga, Computing one-dimensional stable manifolds and
    stable sets of planar maps without the inverse, SIAM Journal on Applied Dynamical Systems 3,
    161-190 (2004).

    Examples
    --------
    The oscillator on a hill stays there only on one line, and leaves along another, with slopes
    minus one and one:

    >>> import nonsmooth as ns
    >>> hill = ns.System(states=["x", "v"], equations={"x": "v", "v": "x + cos(t)"}, period="2*pi")
    >>> orbit = ns.find_orbit(hill, {"x": -0.5})
    >>> curves = ns.manifold(hill, orbit, length=2.0)
    >>> rises = (curves["v"] / (curves["x"] + 0.5))[curves["arclength"] > 0]
    >>> float(rises.min().round(9)), float(rises.max().round(9))
    (1.0, 1.0)
    """
    chosen = map_of(system, parameters, tolerance, "manifold", states_only=True)
    check_part_names(chosen.system, OF_MANIFOLDS)
    check_choice("which", which, _WHICH)
    check_choice("side", side, tuple(SIDES))
    spacing = read_spacing(length, largest_step, smallest_step, angle, steps, longest)
    exact = positive_number("accuracy", accuracy)
    saddle = find_saddle(chosen, orbit, which, scales, tolerance)
    branches, complete = grow_curves(saddle, which, side, spacing, exact)
    options = {
        "which": which,
        "length": spacing.length,
        "largest_step": spacing.largest,
        "smallest_step": spacing.smallest,
        "angle": spacing.angle,
        "accuracy": exact,
        "scales": str(dict(scales)) if scales else "",
        **chosen.protocol,
        **SharedOptions(parameters, tolerance).recorded,
    }
    return manifold_dataset(saddle, branches, options, complete=complete)
