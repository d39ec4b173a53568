"""`StroboscopicMap`: from one period to the next."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, replace
from typing import TYPE_CHECKING, Any

from nonsmooth.errors import ModelError, OptionError
from nonsmooth.runs.driving import hides_phase
from nonsmooth.runs.options import check_run_options, finite_number, whole_number
from nonsmooth.runs.power import raised
from nonsmooth.runs.runner import build_tables
from nonsmooth.runs.strobe_points import Wanted, strobe_points, strobe_tangent
from nonsmooth.runs.strobe_runner import StrobeRunner
from nonsmooth.runs.stroboscopic import check_phase, require_period
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import constant_value
from nonsmooth.system.text.grammar import parse

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["StroboscopicMap"]


@dataclass(frozen=True)
class StroboscopicMap:
    """The map of a forced system over one period: its state a period on.

    Maps are values: they compare, hash and pickle, and analyses take them in place of a system. A
    system by itself stands for its stroboscopic map at the phase zero.

    Parameters
    ----------
    system : System
        The system; it needs a period, or ``period``.
    phase : float, optional
        Part of the period at which states are looked at, from 0 to less than 1 (dimensionless).
    period : float or str, optional
        Another time between strobes than the period of the system: a length of time, or an
        expression of parameters such as ``"2*pi/omega_2"``, for a system with several
        frequencies or none.
    every : int, optional
        Periods from one point to the next: the map over one period applied so many times.

    See Also
    --------
    PoincareMap : from one crossing of a section to the next.
    stroboscopic_map : points of one motion, with its transient left out.

    Notes
    -----
    The period of the system leads to exactly the same phase, however late. Where another period
    does not carry the forcing into itself, the map depends on the time at which it begins.

    Examples
    --------
    Half the period of an oscillator turns it around:

    >>> import nonsmooth as ns
    >>> circle = ns.System(states=["x", "v"], equations={"x": "v", "v": "-x"})
    >>> half = ns.StroboscopicMap(circle, period="pi")
    >>> half.iterate({"x": 1.0}, 3)["x"].values.round(12)
    array([-1.,  1., -1.])
    >>> (half**2).tangent({"x": 1.0}).values.round(12) + 0.0
    array([[1., 0.],
           [0., 1.]])
    """

    system: System
    _: KW_ONLY
    phase: float = 0.0
    period: float | str | None = None
    every: int = 1

    def __post_init__(self) -> None:
        system = check_run_options(self.system, None, None, 1e-12)
        if system.slow:
            raise OptionError(
                "the parameters in slow= change from period to period, so there is no map;"
                " simulate the system, or leave slow= out"
            )
        if self.period is None:
            require_period(system, "a stroboscopic map")
        object.__setattr__(self, "phase", check_phase(self.phase))
        object.__setattr__(self, "every", whole_number("every", self.every))
        _ = self.length  # refuses what is no length of time

    def iterate(
        self,
        initial: Any = None,
        count: int = 1,
        *,
        mode: str | None = None,
        tolerance: float = 1e-12,
    ) -> xr.Dataset:
        """Apply the map some times.

        Parameters
        ----------
        initial : mapping, dataset or run, optional
            State at the phase of the map. A point of a dataset or a run brings its own time,
            from which the next strobe counts.
        count : int, optional
            How often the map is applied.
        mode : str, optional
            Mode of the start, as in `simulate`.
        tolerance : float, optional
            As in `simulate`.

        Returns
        -------
        xarray.Dataset
            Over ``point``: the images in order, as in `stroboscopic_map`. The start, which is none,
            is not among them.

        Raises
        ------
        OptionError
            When the start fits no mode, or an option is out of its range.

        Warns
        -----
        RunWarning
            When the run ended early: the result holds the images until then.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> year = ns.StroboscopicMap(ns.models.soft_impact())
        >>> points = year.iterate({"x": 0.5}, 4)
        >>> points.sizes["point"], points.attrs["status"]
        (4, 'completed')
        """
        return strobe_points(self, self._wanted(initial, count, mode, tolerance))

    def tangent(
        self,
        initial: Any = None,
        count: int = 1,
        *,
        mode: str | None = None,
        tolerance: float = 1e-12,
    ) -> xr.DataArray:
        """Derivative of the map, applied some times, by its start.

        Parameters
        ----------
        initial : mapping, dataset or run, optional
            Start as in `iterate`.
        count : int, optional
            How often the map is applied.
        mode : str, optional
            Mode of the start, as in `simulate`.
        tolerance : float, optional
            As in `simulate`.

        Returns
        -------
        xarray.DataArray
            Over ``state`` and ``state_0``: how the states of the last image change with those of
            the start, through all events on the way. Its eigenvalues on a periodic motion are
            the multipliers.

        Raises
        ------
        OptionError
            When the start fits no mode, or an option is out of its range.
        RunError
            When the motion ends before.

        Examples
        --------
        The determinant over a period T with damping ratio 0.01 is exp(-0.02 T):

        >>> import numpy as np
        >>> import nonsmooth as ns
        >>> system = ns.models.soft_impact()
        >>> tangent = ns.StroboscopicMap(system).tangent({"x": 0.5})
        >>> float(np.log(np.linalg.det(tangent)) / system.period_value)
        -0.02
        """
        return strobe_tangent(self, self._wanted(initial, count, mode, tolerance))

    def power(self, k: int) -> StroboscopicMap:
        """Return the map applied k times, which ``map**k`` is too.

        Parameters
        ----------
        k : int
            How often.

        Returns
        -------
        StroboscopicMap
            The map with ``every`` so many times as large.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> ns.StroboscopicMap(ns.models.duffing()).power(3).every
        3
        """
        return replace(self, every=raised(self.every, k))

    def __pow__(self, k: int) -> StroboscopicMap:
        return self.power(k)

    def with_parameters(self, **parameters: float | str) -> StroboscopicMap:
        """Return the same map of the system with other values of parameters.

        Parameters
        ----------
        **parameters : float or str
            New values by name.

        Returns
        -------
        StroboscopicMap
            The map of the changed system.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> year = ns.StroboscopicMap(ns.models.soft_impact())
        >>> year.with_parameters(omega=0.5).system.parameter_values["omega"]
        0.5
        """
        return replace(self, system=self.system.with_parameters(**parameters))

    def runner(self, tolerance: float) -> StrobeRunner:
        """Return what applies the map to many starts at once, arrays in and out.

        Analyses use it; one belongs to one thread.

        Parameters
        ----------
        tolerance : float
            As in `simulate`.

        Returns
        -------
        StrobeRunner
            With ``start`` and ``iterate``.
        """
        return StrobeRunner(
            self.system, tolerance, phase=self.phase, period=self.length, every=self.every
        )

    @property
    def length(self) -> float | None:
        """Length of time between strobes; None for the period of the system."""
        period = self.period
        if period is None:
            return None
        if isinstance(period, str):
            try:
                period = constant_value(parse(period, where="period"), self.system.parameter_values)
            except KeyError as unknown:
                raise ModelError(
                    f"period = {unknown.args[0]!r} is no parameter of {self.system.name!r}; known"
                    f" are {', '.join(self.system.parameters)}"
                ) from None
        length = finite_number("period", period)
        if not length > 0.0:
            raise OptionError(f"period = {length:g} must be positive")
        return length

    @property
    def hides_phase(self) -> bool:
        """Whether points meet the forcing at different phases, which their states do not tell."""
        tables = build_tables(self.system)
        length = tables.window if self.length is None else self.length
        return hides_phase(tables, length * self.every)

    @property
    def protocol(self) -> dict[str, Any]:
        """What the map is, as attributes of a result."""
        length = self.system.period_value if self.length is None else self.length
        return {"phase_of_period": self.phase, "strobe_period": length, "every": self.every}

    def _wanted(self, initial: Any, count: int, mode: str | None, tolerance: float) -> Wanted:
        check_run_options(self.system, None, mode, tolerance)
        return Wanted(
            initial, transient=0, record=whole_number("count", count), from_start=False,
            mode=mode, t_start=None, tolerance=tolerance, repeated=True,
        )  # fmt: skip
