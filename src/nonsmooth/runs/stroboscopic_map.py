"""`StroboscopicMap`: from one period to the next."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from nonsmooth.engine.status import CURES
from nonsmooth.errors import OptionError, ResultWarning, RunError
from nonsmooth.runs.maps import Map, tangent_array
from nonsmooth.runs.options import check_run_options, whole_number
from nonsmooth.runs.strobe_runner import StrobeRunner
from nonsmooth.runs.strobe_times import require_repeats
from nonsmooth.runs.strobed_motion import StrobeRequest, StrobeSchedule, run_strobes, strobe_points

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["StroboscopicMap"]


@dataclass(frozen=True)
class StroboscopicMap(StrobeSchedule, Map):
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
    does not carry the forcing into itself, the map depends on the time at which it begins. A system
    whose equations never repeat, as with ``signals``, has no map; `stroboscopic_map` looks at one
    motion of it.

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

    def __post_init__(self) -> None:
        super().__post_init__()
        require_repeats(self.system, "a stroboscopic map")

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
        return _strobe_tangent(self, self._wanted(initial, count, mode, tolerance))

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
    def points_have_time(self) -> bool:
        """Whether points lie at different phases of the period: strobes lie at one."""
        return False

    def check_whole_periods(self) -> None:
        """Refuse a time between strobes after which the forcing of a periodic system differs.

        Strobes of a motion with the period of the forcing then never repeat, which would be taken
        for a motion on a torus.
        """
        own = self.system.period_value
        if self.length is None or own is None or not self.hides_phase:
            return
        text = self.system.period
        told = f"{own:.10g}" if not isinstance(text, str) else f"{text} = {own:.10g}"
        raise OptionError(
            f"period = {self.period} is no whole multiple of {told}, the period of"
            f" {self.system.name!r}, so strobes would meet the forcing at another phase each time."
            " Leave period= out: it is for systems without forcing; or give a multiple of that"
            " period as an expression"
        )

    def check_states_suffice(self, verb: str) -> None:
        """Warn where strobes meet the forcing at other phases.

        Parameters
        ----------
        verb : str
            What asks, as the message names it.
        """
        if self.hides_phase:
            # told where the user calls the verb, which asks `map_of`, which calls this
            warnings.warn(
                f"{verb}: {self.system.name!r} has a frequency that is at another phase at each"
                " strobe. All starts begin at the same phases, and later points differ by more than"
                " their states: closed curves may be called aperiodic, and basins belong to this"
                " start alone. Take a period that holds whole turns of every frequency, where there"
                " is one",
                ResultWarning,
                stacklevel=4,
            )

    def _wanted(
        self, initial: Any, count: int, mode: str | None, tolerance: float
    ) -> StrobeRequest:
        check_run_options(self.system, None, mode, tolerance)
        return StrobeRequest(
            initial, transient=0, record=whole_number("count", count), from_start=False,
            mode=mode, t_start=None, tolerance=tolerance, repeated=True,
        )  # fmt: skip


def _strobe_tangent(chosen: StroboscopicMap, wanted: StrobeRequest) -> xr.DataArray:
    """Derivative of the last of some strobes by the start."""
    system = chosen.system
    outcome = run_strobes(chosen, wanted, derivatives=True)
    if outcome.n_samples < wanted.record:
        status = outcome.status
        raise RunError(
            f"{system.name}: {status.word} at t = {outcome.end_time:.9g}, so there is no"
            f" derivative: {CURES.get(status, '')}",
            status=status.word,
            time=outcome.end_time,
        )
    assert outcome.columns is not None
    return tangent_array(system, outcome.columns[-1].T.copy(), system.states)
