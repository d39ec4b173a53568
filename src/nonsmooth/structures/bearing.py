"""`Bearing`: stiffness and damping between coordinates, which may depend on the speed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import (
    ModelError,
    NonsmoothError,
    OptionError,
    is_known,
    quote,
    unknown_choice,
)
from nonsmooth.real_numbers import finite_numbers
from nonsmooth.structures.coordinates import places_of

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline, PchipInterpolator

__all__ = ["Bearing", "through_table"]

_INTERPOLATIONS = ("spline", "monotone")
_LOOKS = 16  # in each interval of a table
_ROUNDING = 1e-9  # of the largest coefficient: what is no change of sign

Coefficients = Callable[[float], npt.NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class Bearing:
    r"""Stiffness and damping between some coordinates of a structure and the ground.

    The force on the coordinates q of the bearing is :math:`-K_b(\Omega) q - C_b(\Omega) \dot q`.

    Parameters
    ----------
    coordinates : str, int or list of these
        The coordinates, by name or number; k of them. Two nodes that a bearing connects give one
        list with the coordinates of both.
    stiffness, damping : float, array_like or callable
        Coefficients in the order of ``coordinates``: a number for each coordinate alike, an
        array of k by k, a table of one of these for each of ``speeds``, n or n by k by k, or a
        function of the speed that returns a number or an array of k by k.
    speeds : array_like, optional
        Speeds of the tables in rad/s, increasing. Of a function the first and the last one are
        those between which it may be used.
    interpolation : {"spline", "monotone"}, optional
        What goes through the values of a table: a cubic spline, of two speeds a line, of three a
        parabola; or cubics that rise and fall only where the table does, after Fritsch and Butland.
        A spline is smoother and closer to smooth coefficients, and may overshoot steep ones.
    name : str, optional
        What messages call it.

    Raises
    ------
    ModelError
        When shapes do not fit, or numbers are not finite.

    See Also
    --------
    Structure : what a bearing holds. It warns of splines that change the sign of a coefficient.

    References
    ----------
    F. N. Fritsch and J. Butland, "A method for constructing local monotone piecewise cubic
    interpolants", SIAM Journal on Scientific and Statistical Computing 5 (1984), 300-304.

    Examples
    --------
    An oil film that grows stiffer with the speed:

    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> film = ns.structures.Bearing(
    ...     ["0x", "0y"], [1e6, 2e6, 4e6], np.full((3, 2, 2), 500.0), speeds=[0.0, 100.0, 200.0]
    ... )
    >>> K, C = film.at_speed(50.0)
    >>> K
    array([[1375000.,       0.],
           [      0., 1375000.]])
    """

    coordinates: Any
    stiffness: Any
    damping: Any = 0.0
    speeds: Any = field(default=None, kw_only=True)
    name: str = field(default="", kw_only=True)
    interpolation: Literal["spline", "monotone"] = field(default="spline", kw_only=True)

    def __post_init__(self) -> None:
        listed = self.coordinates
        if isinstance(listed, str) or not hasattr(listed, "__iter__"):
            listed = (listed,)
        listed = tuple(listed)
        if not listed:
            raise ModelError("Bearing: coordinates: there is none; give at least one")
        for each in listed:
            if isinstance(each, bool) or not isinstance(each, str | int | np.integer):
                raise ModelError(
                    f"Bearing: coordinates: {quote(each)} is neither a name nor a number"
                )
        if not isinstance(self.name, str):
            raise ModelError(f"Bearing: name = {quote(self.name)}: give a text")
        if not is_known(self.interpolation, _INTERPOLATIONS):
            raise ModelError(unknown_choice("interpolation", self.interpolation, _INTERPOLATIONS))
        object.__setattr__(self, "coordinates", listed)
        object.__setattr__(self, "speeds", _speeds(self._called, self.speeds))
        for part in ("stiffness", "damping"):
            where, given = f"{self._called}: {part}", getattr(self, part)
            law = _law(where, given, len(listed), self.speeds, self.interpolation)
            object.__setattr__(self, f"_{part}_at", law)

    @property
    def constant(self) -> bool:
        """Whether the coefficients are the same at all speeds."""
        return all(
            not callable(part) and (self.speeds is None or np.ndim(part) in (0, 2))
            for part in (self.stiffness, self.damping)
        )

    @property
    def speed_range(self) -> tuple[float, float] | None:
        """Least and largest speed at which the coefficients are known; None without limits."""
        if self.speeds is None or self.constant:
            return None
        return float(self.speeds[0]), float(self.speeds[-1])

    @checked
    def at_speed(self, speed: float) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Stiffness and damping at a speed.

        Parameters
        ----------
        speed : float
            Speed of the shaft in rad/s.

        Returns
        -------
        tuple of numpy.ndarray
            Stiffness and damping, each k by k.

        Raises
        ------
        OptionError
            When the speed lies outside of the table.
        ModelError
            When a function fails at this speed, or returns something else than coefficients.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> ns.structures.Bearing("2x", 1e5, lambda speed: 10 + speed).at_speed(90.0)
        (array([[100000.]]), array([[100.]]))
        """
        limits = self.speed_range
        if limits and not limits[0] <= speed <= limits[1]:
            raise OptionError(
                f"speed = {speed:g} rad/s lies outside the table of the {self._called}, from"
                f" {limits[0]:g} to {limits[1]:g}; give speeds within, or a longer table"
            )
        return self._stiffness_at(float(speed)), self._damping_at(float(speed))  # type: ignore[attr-defined]  # set where it is made

    @checked
    def scaled(self, stiffness: Any, damping: Any, speed: float = 1.0) -> Bearing:
        """The bearing with other numbers, as in other units.

        Parameters
        ----------
        stiffness, damping : float or array_like
            What the coefficients are multiplied by; k by k for each one on its own.
        speed : float, optional
            What the speeds are multiplied by.

        Returns
        -------
        Bearing
            Its coefficients, tables and functions in the new units.

        Raises
        ------
        OptionError
            When factors do not fit.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> ns.structures.Bearing("2x", 50.0).scaled(1e3, 1e3).at_speed(0.0)[0]
        array([[50000.]])
        """
        size = len(self.coordinates)
        stiffness = finite_numbers("stiffness", stiffness)
        damping = finite_numbers("damping", damping)
        for name, factor in (("stiffness", stiffness), ("damping", damping)):
            if factor.shape not in ((), (size, size)):
                raise OptionError(f"{name} has shape {factor.shape}; give one, or {size} x {size}")
        if not speed > 0.0:
            raise OptionError(f"speed = {speed:g} must be positive")

        def times(given: Any, law: Coefficients, factor: Any) -> Any:
            if callable(given):
                return lambda at: law(at / speed) * factor
            return _spread(given, size) * factor

        return Bearing(
            self.coordinates,
            times(self.stiffness, self._stiffness_at, stiffness),  # type: ignore[attr-defined]  # set where it is made
            times(self.damping, self._damping_at, damping),  # type: ignore[attr-defined]  # as above
            speeds=None if self.speeds is None else self.speeds * speed,
            name=self.name,
            interpolation=self.interpolation,
        )

    def at(self, coordinates: Any) -> Bearing:
        """The bearing between some of its coordinates, while the others do not move.

        Parameters
        ----------
        coordinates : str, int or list of these
            Those that move: their names, or their places among those of the bearing.

        Returns
        -------
        Bearing
            With the rows and columns of these.

        Raises
        ------
        OptionError
            When the bearing has no such coordinate.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> ns.structures.Bearing(["2x", "2y"], [[5.0, 1.0], [1.0, 6.0]]).at("2y").stiffness
        array([[6.]])
        """
        size = len(self.coordinates)
        places = places_of(coordinates, tuple(map(str, self.coordinates)), "coordinates")
        rows, columns = np.ix_(places, places)

        def part(given: Any, law: Coefficients) -> Any:
            if callable(given):
                return lambda speed: law(speed)[rows, columns]
            return _spread(given, size)[..., rows, columns]

        return Bearing(
            [self.coordinates[i] for i in places],
            part(self.stiffness, self._stiffness_at),  # type: ignore[attr-defined]  # set where it is made
            part(self.damping, self._damping_at),  # type: ignore[attr-defined]  # as above
            speeds=self.speeds,
            name=self.name,
            interpolation=self.interpolation,
        )

    def overshoot(self) -> str | None:
        """Where a spline gives a direct coefficient a sign that its table has nowhere.

        Returns
        -------
        str or None
            The coefficient, its value and the speed; None where there is none. Direct ones are
            those on the diagonal, whose sign tells a bearing that holds from one that pushes.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> steep = ns.structures.Bearing(
        ...     "2x", [9e7, 1e6, 9e5, 8e5], speeds=[0.0, 100.0, 200.0, 300.0]
        ... )
        >>> steep.overshoot()
        'stiffness[0, 0] is -4.73e+06 at 140 rad/s'
        """
        if self.speeds is None or self.interpolation != "spline":
            return None
        between = np.linspace(self.speeds[:-1], self.speeds[1:], _LOOKS).T.ravel()
        for part in ("stiffness", "damping"):
            law = getattr(self, f"_{part}_at")
            if callable(getattr(self, part)) or not hasattr(law, "x"):
                continue
            table, values = (
                np.diagonal(law(at), axis1=1, axis2=2) for at in (self.speeds, between)
            )
            for sign in (1.0, -1.0):
                beyond = np.where((sign * table >= 0.0).all(axis=0), sign * values, 0.0)
                beyond = beyond / (np.abs(table).max(axis=0) + np.finfo(float).tiny)
                at, i = np.unravel_index(beyond.argmin(), beyond.shape)
                if beyond[at, i] < -_ROUNDING:
                    value = float(values[at, i])
                    return f"{part}[{i}, {i}] is {value:.3g} at {between[at]:.3g} rad/s"
        return None

    @property
    def _called(self) -> str:
        where = ", ".join(map(str, self.coordinates))
        return f"bearing {self.name!r}" if self.name else f"bearing at {where}"


def _speeds(called: str, given: Any) -> npt.NDArray[np.float64] | None:
    if given is None:
        return None
    speeds = finite_numbers(f"{called}: speeds", given, ModelError)
    if speeds.ndim != 1 or speeds.size < 2 or not (np.diff(speeds) > 0.0).all():
        raise ModelError(f"{called}: speeds = {quote(given)}: give two or more, increasing")
    speeds.setflags(write=False)
    return speeds


def _law(
    part: str,
    given: Any,
    size: int,
    speeds: npt.NDArray[np.float64] | None,
    interpolation: str,
) -> Coefficients:
    """Coefficients as a function of the speed."""
    if callable(given):

        def law(speed: float) -> npt.NDArray[np.float64]:
            return _square(f"{part} at the speed {speed:g}", _value(part, given, speed), size)

        return law
    values = finite_numbers(part, given, ModelError)
    count = None if speeds is None else len(speeds)
    if values.ndim in (0, 2):
        always = _square(part, values, size)
        return lambda speed: always
    if count is None and values.ndim in (1, 3):
        raise ModelError(f"{part} is a table of {len(values)}; give the speeds= that it is for")
    if values.shape not in ((count,), (count, size, size)):
        raise ModelError(
            f"{part} has shape {values.shape}; give one number, {size} x {size}, or a table of"
            f" {count} of these"
        )
    if values.ndim == 1:
        values = _spread(values, size)
    assert speeds is not None  # a table has speeds
    return through_table(speeds, values, interpolation)


def through_table(
    speeds: npt.NDArray[np.float64], values: npt.ArrayLike, interpolation: str
) -> CubicSpline | PchipInterpolator:
    """Cubics in pieces through the values of a table."""
    from scipy import interpolate

    made = interpolate.CubicSpline if interpolation == "spline" else interpolate.PchipInterpolator
    return made(speeds, values)


def _value(part: str, function: Callable[[float], Any], speed: float) -> Any:
    """What a function of the user's returns, or an error that says where it fails."""
    try:
        return function(speed)
    except NonsmoothError:  # of the bearing that this one was made of
        raise
    except Exception as error:
        raise ModelError(
            f"{part}: the function fails at the speed {speed:g} with {type(error).__name__}:"
            f" {error}; it takes one speed in rad/s, and needs a value at each that is asked for"
        ) from error


def _spread(given: Any, size: int) -> npt.NDArray[np.float64]:
    """Numbers as arrays with one on each place of the diagonal."""
    values = np.asarray(given, dtype=float)
    return values[..., None, None] * np.eye(size) if values.ndim in (0, 1) else values


def _square(where: str, given: Any, size: int) -> npt.NDArray[np.float64]:
    """Array of coefficients between the coordinates; one number is for each of them alike."""
    values = finite_numbers(where, given, ModelError)
    if values.ndim == 0:
        values = _spread(values, size)
    if values.shape != (size, size):
        raise ModelError(
            f"{where} has shape {values.shape}; give one number, or {size} x {size} for the"
            f" {size} coordinates"
        )
    values.setflags(write=False)
    return values
