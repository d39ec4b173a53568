"""`homoclinic_points`: where the unstable manifold of a saddle crosses a stable one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from nonsmooth.analysis.manifolds.crossings import Curves, ManifoldCrossing, find_crossings
from nonsmooth.analysis.manifolds.curve import Spacing
from nonsmooth.analysis.manifolds.grow_curves import (
    SIDES,
    check_choice,
    grow_curves,
    read_spacing,
)
from nonsmooth.analysis.manifolds.saddle import Saddle, find_saddle
from nonsmooth.analysis.options import SharedOptions, result_attributes
from nonsmooth.errors import OptionError
from nonsmooth.periodic_orbits.restart import is_orbit
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.maps import Map
from nonsmooth.runs.of_system import map_of
from nonsmooth.runs.options import positive_number
from nonsmooth.runs.part_names import OF_CROSSINGS, check_part_names

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["both_saddles", "curves_of_both", "homoclinic_points", "read_orbits"]

_SAME = 1e-9  # of a place: points of one orbit


def homoclinic_points(
    system: Any,
    orbit: Any,
    to: Any = None,
    *,
    length: float = 10.0,
    side: Literal["both", "+", "-"] = "both",
    to_side: Literal["both", "+", "-"] = "both",
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
    """Find where the unstable manifold of a saddle crosses its stable one, or that of another.

    Parameters
    ----------
    system : System or map
        A system with a period, for its stroboscopic map, or a `StroboscopicMap` or `PoincareMap`,
        whose points lie in a plane: two states beside drifts, or a section of three.
    orbit : xarray.Dataset
        The saddle whose unstable manifold is taken, as in `manifold`.
    to : xarray.Dataset, optional
        The saddle whose stable manifold is taken: the same one by default, whose points are
        *homoclinic*. Those between two saddles are *heteroclinic*.
    length : float, optional
        Length of each curve, in scaled states.
    side, to_side : {"both", "+", "-"}, optional
        Sides of the unstable and of the stable manifold, as in `manifold`.
    scales : mapping of str to float, optional
        Sizes by which states are divided before lengths and angles are measured, 1 without it.
    largest_step : float, optional
        Largest distance of neighbouring points, in scaled states; ``length/200`` without it.
        Crossings closer to each other than that may be missed.
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.

    Other Parameters
    ----------------
    smallest_step, angle, accuracy, steps, longest : optional
        How curves are followed, see `manifold`.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.

    Returns
    -------
    xarray.Dataset
        Over ``crossing``, in order along the unstable curves: the states by name,
        ``crossing_angle`` of both manifolds (rad, at most pi/2), ``sense`` (1 or -1, in which
        direction the stable one is crossed), ``orbit_number`` (points that the map takes to each
        other have the same), ``place`` (distance from the saddle, on the straight first piece, of
        the start that leads to the point), ``images`` and ``ahead`` (applications of the map from
        there to the point, and from the point to the first piece of the stable manifold),
        ``position_error`` along the curve, ``unstable_side``, ``stable_side``, ``orbit_point`` and
        ``to_point``. For every angle ``q_turns``: the point lies on the unstable curve as
        `manifold` gives it, and on the stable one so many turns farther on. Attributes:
        ``status``, ``message``, ``n_orbits`` and ``unrefined``.

    Raises
    ------
    OptionError
        As in `manifold`.

    See Also
    --------
    manifold : the curves themselves.
    homoclinic_tangency : the parameter at which they begin to cross.

    Notes
    -----
    Pieces of both curves that cross tell where to look. The crossing itself is then found by the
    map alone: a start on the straight first piece of the unstable manifold is mapped to the point
    and on, until it is beside the straight first piece of the stable manifold. How far it is across
    that piece is a function of the place of the start; its zero is found to rounding. So the point
    is off by ``position_error`` along the unstable curve, and by the deviation of the first pieces,
    ``accuracy`` at most, which contracts on the way.

    Where a homoclinic point exists and the manifolds cross at an angle, there are infinitely many,
    and motion is chaotic at least for a while (Smale). With ``to`` a saddle on the border of a
    basin, the basin has a fractal border from there on.

    References
    ----------
    J. Guckenheimer and P. Holmes, Nonlinear Oscillations, Dynamical Systems, and Bifurcations of
    Vector Fields, Springer (1983), chapter 5.

    R. Lozi, Un attracteur etrange du type attracteur de Henon, Journal de Physique Colloques 39,
    C5-9 (1978).

    Examples
    --------
    Lozi's map, written as kicks in time:

    >>> import nonsmooth as ns
    >>> kick = ns.Exit("cos(2*pi*t)", to="after", reset={"x": "1 - a*abs(x) + y", "y": "b*x"})
    >>> back = ns.Exit("-cos(2*pi*t)", to="before")
    >>> lozi = ns.System(
    ...     states=["x", "y"],
    ...     parameters={"a": 1.7, "b": 0.5},
    ...     period=1.0,
    ...     modes={
    ...         "before": ns.Mode({"x": "0", "y": "0"}, exits=[kick]),
    ...         "after": ns.Mode({"x": "0", "y": "0"}, exits=[back]),
    ...     },
    ... )
    >>> saddle = ns.find_orbit(lozi, {"x": 0.455, "y": 0.227})
    >>> found = ns.homoclinic_points(
    ...     lozi, saddle, length=3.0, side="+", to_side="-", largest_step=0.1
    ... )
    >>> found.sizes["crossing"], found["x"].values[:2].round(6)
    (2, array([ 0.122137, -0.109789]))
    """
    chosen = map_of(system, parameters, tolerance, "homoclinic_points", states_only=True)
    check_part_names(chosen.system, OF_CROSSINGS)
    check_choice("side", side, tuple(SIDES))
    check_choice("to_side", to_side, tuple(SIDES))
    spacing = read_spacing(length, largest_step, smallest_step, angle, steps, longest)
    exact = positive_number("accuracy", accuracy)
    saddles = both_saddles(chosen, read_orbits(orbit, to), scales, tolerance)
    unstable, stable, complete = curves_of_both(saddles, (side, to_side), spacing, exact)
    found, lost = find_crossings(unstable, stable)
    options = {
        "length": spacing.length, "largest_step": spacing.largest, "angle": spacing.angle,
        "accuracy": exact, "scales": str(dict(scales)) if scales else "", **chosen.protocol,
        **SharedOptions(parameters, tolerance).recorded,
    }  # fmt: skip
    return _dataset(chosen, unstable, stable, found, lost, options, complete=complete)


def read_orbits(orbit: Any, to: Any) -> tuple[Any, Any]:
    """The orbits of the unstable and of the stable manifold; one serves as both."""
    for name, each in (("orbit", orbit), ("to", to)):
        if not is_orbit(each) and not (name == "to" and each is None):
            raise OptionError(
                f"{name} = {type(each).__name__}: give a result of find_orbit, or one orbit of a"
                " branch, as in branch.isel(point=0)"
            )
    return orbit, orbit if to is None else to


def both_saddles(
    chosen: Map, orbits: tuple[Any, Any], scales: Any, tolerance: float
) -> tuple[Saddle, Saddle]:
    """The saddle with the unstable manifold, and that with the stable one."""
    return (
        find_saddle(chosen, orbits[0], "unstable", scales, tolerance),
        find_saddle(chosen, orbits[1], "stable", scales, tolerance),
    )


def curves_of_both(
    saddles: tuple[Saddle, Saddle], sides: tuple[str, str], spacing: Spacing, accuracy: float
) -> tuple[Curves, Curves, bool]:
    """The unstable curves of one saddle, the stable ones of another, and whether all are there."""
    found, whole = [], True
    for which, saddle, side in zip(("unstable", "stable"), saddles, sides, strict=True):
        branches, complete = grow_curves(saddle, which, side, spacing, accuracy)
        found.append(Curves(saddle, branches, spacing.largest))
        whole &= complete
    return found[0], found[1], whole


def _orbit_numbers(found: list[ManifoldCrossing]) -> list[int]:
    """Numbers of homoclinic orbits: the map takes their points to each other."""
    known: list[tuple[int, float]] = []
    numbers = []
    for each in found:
        same = [
            k for k, (out, place) in enumerate(known)
            if out == each.out and abs(place - each.place) <= _SAME * place
        ]  # fmt: skip
        if not same:
            known.append((each.out, each.place))
        numbers.append(same[0] if same else len(known) - 1)
    return numbers


def _dataset(
    chosen: Map, unstable: Curves, stable: Curves, found: list[ManifoldCrossing], lost: int,
    options: dict[str, Any], *, complete: bool,
) -> xr.Dataset:  # fmt: skip
    """Dataset over ``crossing``."""
    import xarray as xr

    system, dim = chosen.system, ("crossing",)
    labels, numbers = labels_of(system), _orbit_numbers(found)
    states = np.array([each.state for each in found]).reshape(-1, len(system.states))
    active = stable.saddle.points[0].here.coordinates.active

    def each_of(values: list[Any], kind: Any, label: str, **more: str) -> Any:
        return dim, np.array(values, kind), {"long_name": label, **more}

    outs = [unstable.branches[each.out] for each in found]
    intos = [stable.branches[each.into] for each in found]
    variables: dict[str, Any] = {
        system.states[k]: (dim, states[:, k], labels.attributes(system.states[k])) for k in active
    }
    variables |= {
        "crossing_angle": each_of(
            [each.angle for each in found], float, "angle of both manifolds", units="rad"),
        "sense": each_of([each.sense for each in found], float, "sense of the crossing"),
        "orbit_number": each_of(numbers, int, "number of the orbit of the point"),
        "place": each_of([each.place for each in found], float, "place on the first piece"),
        "images": each_of(
            [each.passage.images for each in found], int, "applications of the map to the point"),
        "ahead": each_of(
            [each.passage.ahead for each in found], int, "applications of the map from it on"),
        "position_error": each_of(
            [each.error for each in found], float, "error along the curve, in scaled states"),
        "unstable_side": each_of([int(o.first.side) for o in outs], int, "side of the orbit"),
        "stable_side": each_of([int(o.first.side) for o in intos], int, "side of the orbit"),
        "orbit_point": each_of([o.number for o in outs], int, "iterate of the orbit"),
        "to_point": each_of([o.number for o in intos], int, "iterate of the second orbit"),
    }  # fmt: skip
    shifts = np.array([each.passage.shift for each in found]).reshape(-1, len(system.states))
    for name, period in system.angles.items():
        turns = np.rint(shifts[:, system.states.index(name)] / period)
        variables[f"{name}_turns"] = each_of(
            turns.tolist(), int, f"turns of {name} from the stable curve to the point"
        )
    told = [] if complete else ["interrupted by the user; curves are shorter than they might be"]
    if lost:
        told.append(f"{lost} crossings of the curves are no crossings of the manifolds, or unsure")
    if not found:
        told.append("the curves do not cross; raise length=, or take another parameter")
    attrs = {"n_orbits": len(set(numbers)), "unrefined": lost, **options}
    status = "completed" if complete else "interrupted"
    return xr.Dataset(
        variables, None,
        result_attributes(system, status, "; ".join(told) or "completed", attrs),
    )  # fmt: skip
