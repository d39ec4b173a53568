"""`homoclinic_tangency`: the parameter at which two manifolds touch."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from nonsmooth.analysis.find_orbit import find_orbit
from nonsmooth.analysis.homoclinic_points import both_saddles, curves_of_both, read_orbits
from nonsmooth.analysis.manifolds.crossings import ManifoldCrossing, find_crossings
from nonsmooth.analysis.manifolds.curve import Spacing
from nonsmooth.analysis.manifolds.grow_curves import SIDES, check_choice, read_spacing
from nonsmooth.analysis.manifolds.saddle import with_sides_of
from nonsmooth.analysis.manifolds.tangency import Both, Tangency, bumps_of, touch
from nonsmooth.analysis.options import SharedOptions, refuse_fixed, result_attributes
from nonsmooth.errors import ModelError, OptionError, is_known, quote, unknown_name
from nonsmooth.progress import Progress
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.maps import Map
from nonsmooth.runs.of_system import map_of
from nonsmooth.runs.options import finite_number, positive_number, whole_number
from nonsmooth.runs.part_names import OF_TANGENCIES, check_part_names
from nonsmooth.runs.whole_turns import periods_of_states, whole_turns
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["homoclinic_tangency"]

_SAME = 1e-8  # of the range: tangencies that are one, seen at several points of its orbit
_PARTS = 8  # of the way from one value to the other, in which orbits are followed
_HALVINGS = 4  # of the range, where no pair of crossings can be followed


def homoclinic_tangency(
    system: Any,
    parameter: str,
    between: tuple[float, float],
    orbit: Any,
    to: Any = None,
    *,
    bumps: int = 4,
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
    """Find the parameter at which the manifolds of one saddle, or of two, touch.

    Parameters
    ----------
    system : System or map
        A system with a period, for its stroboscopic map, or a `StroboscopicMap` or `PoincareMap`,
        whose points lie in a plane.
    parameter : str
        Name of the parameter.
    between : (float, float)
        Two values of it: at one the manifolds cross more often than at the other.
    orbit : xarray.Dataset
        The saddle whose unstable manifold is taken, at any value near; it is followed to others.
    to : xarray.Dataset, optional
        The saddle whose stable manifold is taken, the same one by default. With a saddle on the
        border of a basin, the tangency is the *boundary crisis* of an attractor that contains
        ``orbit``.
    bumps : int, optional
        Pairs of crossings that are followed, at most, those of the fewest iterates first.
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
        Over ``tangency``, that farthest from the value with more crossings first: the value of the
        ``parameter`` by its name, ``value_error``, the states by name at which the manifolds touch,
        ``tangency_kind`` ("corner" where a corner touches, else "smooth"), ``place``, ``images``
        and ``ahead`` as in `homoclinic_points`. Attributes: ``status``, "completed" or
        "no_tangency", ``message``, ``crossings`` at both values.

    Raises
    ------
    OptionError
        As in `manifold`; for an unknown parameter, or an orbit that is lost between the values.

    See Also
    --------
    homoclinic_points : crossings at one value.
    erosion_profile : what becomes of basins behind a tangency.

    Notes
    -----
    Manifolds are followed at both values only. At that with more crossings, two in a row along the
    unstable manifold and in opposite senses enclose a bump across the stable one. The top of the
    bump is a start on the straight first piece of the unstable manifold; how far it is across the
    first piece of the stable one, after the iterates that lead there, is a number that the map
    gives to rounding. It is followed over the parameter, with the saddles, until it is zero.

    A tangency at one point is one at all its images, so the same value is found several times and
    told once. Of the first in each row of tangencies the others are behind it: a bump of more
    iterates touches later, or earlier. To be sure of the first one of all, let ``between`` begin
    where there is none, and raise ``bumps`` and ``length`` until the value stays.

    In a piecewise-linear map, bumps have corners, and the value is exact but for rounding. Where
    two crossings are farther apart than the bump is long, as far from a tangency, it may be lost.
    If no bump can be followed to where it vanishes, a half of the range is asked in which crossings
    become fewer, up to four times; beyond that, narrow ``between``.

    Both sides keep their names on the way: "+" is where the largest entry of a direction grows at
    the parameters of ``orbit``.

    References
    ----------
    C. Grebogi, E. Ott and J. A. Yorke, Crises, sudden changes in chaotic attractors, and transient
    chaos, Physica D 7, 181-200 (1983).

    M. Misiurewicz, Strange attractors for the Lozi mappings, Annals of the New York Academy of
    Sciences 357, 348-358 (1980).

    Examples
    --------
    The attractor of Lozi's map touches the stable manifold of the saddle on its border where
    2 a + b = 4:

    >>> import nonsmooth as ns
    >>> kick = ns.Exit("cos(2*pi*t)", to="after", reset={"x": "1 - a*abs(x) + y", "y": "b*x"})
    >>> back = ns.Exit("-cos(2*pi*t)", to="before")
    >>> lozi = ns.System(
    ...     states=["x", "y"],
    ...     parameters={"a": 1.8, "b": 0.3},
    ...     period=1.0,
    ...     modes={
    ...         "before": ns.Mode({"x": "0", "y": "0"}, exits=[kick]),
    ...         "after": ns.Mode({"x": "0", "y": "0"}, exits=[back]),
    ...     },
    ... )
    >>> inside, border = ns.find_orbit(lozi, {"x": 0.4}), ns.find_orbit(lozi, {"x": -0.9})
    >>> found = ns.homoclinic_tangency(
    ...     lozi, "a", (1.84, 1.88), inside, border, side="-", to_side="+", length=2.0,
    ...     largest_step=0.2, bumps=1,
    ... )  # fmt: skip
    >>> float(found["a"][0].round(9)), found["tangency_kind"].values.tolist()
    (1.85, ['corner'])
    """
    chosen = map_of(system, parameters, tolerance, "homoclinic_tangency", states_only=True)
    if not is_known(parameter, chosen.system.parameters):
        raise OptionError(unknown_name("parameter", parameter, chosen.system.parameters))
    check_part_names(chosen.system, OF_TANGENCIES, parameters=(parameter,))
    refuse_fixed(system, parameters, (parameter,), "parameter")
    ends = _read_between(between)
    check_choice("side", side, tuple(SIDES))
    check_choice("to_side", to_side, tuple(SIDES))
    spacing = read_spacing(length, largest_step, smallest_step, angle, steps, longest)
    exact, most = positive_number("accuracy", accuracy), whole_number("bumps", bumps)
    orbits = _Orbits(chosen, parameter, ends, read_orbits(orbit, to), scales, tolerance)
    for value in ends:  # before long work
        orbits.check(value)
    search = _TangencySearch(orbits, (side, to_side), spacing, exact, most)
    found = search.tangencies(*ends)
    options = {
        "parameter": parameter, "between": f"{ends[0]:g} {ends[1]:g}",
        "crossings": " ".join(str(len(search.crossings(value))) for value in ends), "bumps": most,
        "length": spacing.length,
        "largest_step": spacing.largest, "accuracy": exact,
        "scales": str(dict(scales)) if scales else "", **chosen.protocol,
        **SharedOptions(parameters, tolerance).recorded,
    }  # fmt: skip
    return _dataset(chosen, parameter, found, search, options)


def _read_between(between: Any) -> tuple[float, float]:
    try:
        first, second = between
    except (TypeError, ValueError):
        raise OptionError(
            f"between = {quote(between)}: give two values of the parameter, such as (1.0, 1.2)"
        ) from None
    low, high = finite_number("between", first), finite_number("between", second)
    if low == high:
        raise OptionError(f"between = ({low:g}, {high:g}): give two different values")
    return low, high


class _TangencySearch:
    """Tangencies between two values of the parameter, from the crossings at these."""

    def __init__(
        self, orbits: _Orbits, sides: tuple[str, str], spacing: Spacing, accuracy: float, most: int
    ) -> None:
        self.orbits, self.sides = orbits, sides
        self.spacing, self.accuracy, self.most = spacing, accuracy, most
        self.tried = 0  # pairs of crossings
        self._crossings: dict[float, list[ManifoldCrossing]] = {}

    def crossings(self, value: float) -> list[ManifoldCrossing]:
        """Crossings of both manifolds at a value."""
        if value not in self._crossings:
            both = self.orbits.saddles(value)
            assert both is not None  # as it has been checked, or followed
            curves = curves_of_both(both, self.sides, self.spacing, self.accuracy)
            self._crossings[value] = find_crossings(*curves[:2])[0]
        return self._crossings[value]

    def tangencies(self, first: float, second: float) -> list[Tangency]:
        """All of them, that farthest from the value with more crossings first.

        Where no pair of crossings can be followed to where it vanishes, as they are too far apart,
        a half of the range with fewer behind it is asked.
        """
        begin, end = first, second
        if len(self.crossings(first)) <= len(self.crossings(second)):
            begin, end = second, first
        for _ in range(_HALVINGS + 1):
            found = self._touching(begin, end)
            fewer = len(self.crossings(end))
            if found or len(self.crossings(begin)) == fewer:
                return _unique(found, begin, abs(second - first))
            middle = 0.5 * (begin + end)
            if self.orbits.saddles(middle) is None:
                break
            if len(self.crossings(middle)) > fewer:
                begin = middle
            else:
                end = middle
        return []

    def _touching(self, begin: float, end: float) -> list[Tangency]:
        """Those in which crossings at one value vanish on the way to another."""
        both, found = self.orbits.saddles(begin), []
        assert both is not None  # its curves have been followed
        candidates = bumps_of(self.crossings(begin), both)[: self.most]
        self.tried += len(candidates)
        with Progress("homoclinic tangency", len(candidates)) as progress:
            for k, bump in enumerate(candidates):
                one = touch(bump, begin, end, self.orbits.saddles)
                if one is not None:
                    found.append(one)
                progress.update(k + 1)
        return found


class _Orbits:
    """The saddles at any value of the parameter, followed from those that are given."""

    def __init__(
        self, chosen: Map, parameter: str, between: tuple[float, float], orbits: tuple[Any, Any],
        scales: Any, tolerance: float,
    ) -> None:  # fmt: skip
        self.chosen, self.parameter = chosen, parameter
        self.step = abs(between[1] - between[0]) / _PARTS
        self.scales, self.tolerance = scales, tolerance
        own = float(chosen.system.parameter_values[parameter])
        self.known: dict[float, tuple[Any, Any]] = {}
        found = self._followed(orbits, own)
        if found is None:
            raise OptionError(
                f"orbit: it is lost at {parameter} = {own:g}; give one of the same system at these"
                " parameters"
            )
        self.known[own] = found
        self.both: dict[float, Both] = {}
        self.saddles(own)

    def at(self, value: float) -> tuple[Map, tuple[Any, Any]]:
        """The map at a value and the orbits there."""
        begin = min(self.known, key=lambda each: abs(each - value))
        parts = int(np.ceil(abs(value - begin) / self.step))
        for part in np.linspace(begin, value, parts + 1)[1:].tolist():
            near = min(self.known, key=lambda each: abs(each - part))
            found = self._followed(self.known[near], part)
            if found is None:
                raise OptionError(
                    f"between: an orbit is lost at {self.parameter} = {part:g}, where it may have"
                    " ended in a fold; give a narrower range"
                )
            self.known[part] = found
            if part != value:
                self.saddles(part)  # so that sides are known on the way
        return self._map(value), self.known[value]

    def check(self, value: float) -> None:
        """Refuse a value at which an orbit is no saddle."""
        at, given = self.at(value)
        try:
            self.both[value] = self._saddles(at, given)
        except OptionError as fault:
            where = f"between: at {self.parameter} = {value:g} there is no such manifold"
            raise OptionError(f"{where}: {fault}") from None

    def saddles(self, value: float) -> Both | None:
        """Both saddles at a value; None where one is lost."""
        if value not in self.both:
            try:
                self.both[value] = self._saddles(*self.at(value))
            except OptionError:
                return None
        return self.both[value]

    def _saddles(self, at: Map, orbits: tuple[Any, Any]) -> Both:
        """The saddles, with the sides of those at the nearest value."""
        found = Both(*both_saddles(at, orbits, self.scales, self.tolerance))
        if not self.both:
            return found
        value = float(at.system.parameter_values[self.parameter])
        near = self.both[min(self.both, key=lambda each: abs(each - value))]
        return Both(*(with_sides_of(*pair) for pair in zip(found, near, strict=True)))

    def _map(self, value: float) -> Map:
        try:
            return self.chosen.with_parameters(**{self.parameter: value})
        except ModelError as fault:
            raise OptionError(
                f"between: the system refuses {self.parameter} = {value:g}: {fault}"
            ) from None

    def _followed(self, orbits: tuple[Any, Any], value: float) -> tuple[Any, Any] | None:
        """Orbits at another value, from those nearby; one search serves where they are one."""
        system = self._map(value).system
        found = []
        for orbit in orbits[: 1 if orbits[0] is orbits[1] else 2]:
            each = find_orbit(system, orbit, parameters={}, tolerance=self.tolerance)
            if each.attrs["status"] != "completed":
                return None
            found.append(_beside(system, each, orbit))
        return found[0], found[-1]


def _beside(system: System, orbit: Any, near: Any) -> Any:
    """The orbit with its angles those whole turns on that are nearest to those of another one.

    So what lies some turns beyond a saddle does so at all values of the parameter.
    """
    periods = periods_of_states(system)
    here, there = (np.array([float(each[n]) for n in system.states]) for each in (orbit, near))
    turns = whole_turns(here - there, periods)
    return orbit.assign({n: orbit[n] - turns[system.states.index(n)] for n in system.angles})


def _unique(found: list[Tangency], begin: float, whole: float) -> list[Tangency]:
    """Tangencies one by one, the one farthest from the value with more crossings first."""
    kept: list[Tangency] = []
    for each in sorted(found, key=lambda one: (-abs(one.value - begin), one.bump.images)):
        if all(abs(each.value - one.value) > _SAME * whole for one in kept):
            kept.append(each)
    return kept


def _dataset(
    chosen: Map,
    parameter: str,
    found: list[Tangency],
    search: _TangencySearch,
    options: dict[str, Any],
) -> xr.Dataset:
    """Dataset over ``tangency``."""
    import xarray as xr

    system, dim = chosen.system, ("tangency",)
    labels = labels_of(system)
    states = np.array([each.state for each in found]).reshape(-1, len(system.states))
    named = system.describe.get(parameter, parameter)
    variables: dict[str, Any] = {
        name: (dim, states[:, k], labels.attributes(name))
        for k, name in enumerate(system.states) if name not in system.drift_states
    }  # fmt: skip
    variables |= {
        parameter: (dim, np.array([each.value for each in found], float), {"long_name": named}),
        "value_error": (dim, np.array([each.error for each in found], float), {
            "long_name": "error of the value"}),
        "tangency_kind": (dim, np.array([each.kind for each in found], str), {
            "long_name": "whether a corner touches"}),
        "place": (dim, np.array([each.place for each in found], float), {
            "long_name": "place on the first piece"}),
        "images": (dim, np.array([each.bump.images for each in found], int), {
            "long_name": "applications of the map to the point"}),
        "ahead": (dim, np.array([each.bump.ahead for each in found], int), {
            "long_name": "applications of the map from it on"}),
    }  # fmt: skip
    message, status = "completed", "completed"
    if not found:
        status, fewer, more = "no_tangency", *sorted(map(int, options["crossings"].split()))
        cure = "let between= begin where the manifolds cross and end where they do not"
        if fewer < more:
            cure = (
                f"the manifolds cross {fewer} times at one value and {more} times at the other,"
                " but no pair could be followed to where it vanishes: narrow between="
            )
        message = (
            f"none of {search.tried} pairs of crossings vanishes between the values; {cure}, or"
            " raise length= and bumps="
        )
    return xr.Dataset(variables, None, result_attributes(system, status, message, options))
