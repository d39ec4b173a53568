"""`PoincareMap`: from one point of a section to the next."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from nonsmooth.runs.options import check_run_options, whole_number
from nonsmooth.runs.return_tangent import return_tangent
from nonsmooth.runs.section_map import SectionMap
from nonsmooth.runs.section_points import take_points
from nonsmooth.runs.section_runner import SectionRunner

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["PoincareMap"]


@dataclass(frozen=True)
class PoincareMap(SectionMap):
    """The map of a system from a section to itself: where the motion comes through it next.

    Points lie where an expression vanishes, or at events of a name, as in `poincare_section`. Maps
    are values: they compare, hash and pickle, and analyses take them in place of a system.

    Parameters
    ----------
    system : System
        The system; its parameters do not vary (``slow``).
    section : str
        An expression such as ``"v"`` or ``"x = 0.5"``, or the name of an event, as in
        `poincare_section`.
    direction : {1, -1, 0}, optional
        Crossings that count: the expression grows (1, the default), falls (-1), or either (0).
        Events have none, and give 0.
    side : {"before", "after"}, optional
        Whether a point has the states just before or just after the instant: events may jump.
    every : int, optional
        Crossings from one point to the next: the map is the return map applied so many times.

    See Also
    --------
    StroboscopicMap : from one period of the forcing to the next.
    poincare_section : points of one motion, with its transient left out.

    Notes
    -----
    A point is where the motion is on the section *and* when, which matters in a system with
    forcing: there the time of a point is a coordinate of the map, like its states. A point of a
    dataset brings its time with it, a mapping of states begins at ``t_start``.

    Examples
    --------
    The speed of a ball after its impacts on the ground:

    >>> import nonsmooth as ns
    >>> impact = ns.Exit("h", reset={"u": "-r*u"}, name="impact")
    >>> ball = ns.System(
    ...     states=["h", "u"],
    ...     parameters={"r": 0.8},
    ...     modes={"flight": ns.Mode({"h": "u", "u": "-1"}, exits=[impact])},
    ... )
    >>> bounce = ns.PoincareMap(ball, "impact", side="after")
    >>> bounce.iterate({"u": 1.0}, 3)["u"].values.round(4)
    array([0.8  , 0.64 , 0.512])
    >>> float((bounce**3).iterate({"u": 1.0})["u"].squeeze().round(4))
    0.512
    """

    def iterate(
        self,
        initial: Any = None,
        count: int = 1,
        *,
        mode: str | None = None,
        t_start: float | None = None,
        t_end: float | None = None,
        tolerance: float = 1e-12,
    ) -> xr.Dataset:
        """Apply the map some times.

        Parameters
        ----------
        initial : mapping, dataset or run, optional
            Start as in `simulate`; it need not lie on the section.
        count : int, optional
            How often the map is applied.
        mode : str, optional
            Mode of the start, as in `simulate`.
        t_start : float, optional
            Time of the start, as in `simulate`.
        t_end : float, optional
            Time at which the search ends, as in `poincare_section`.
        tolerance : float, optional
            As in `simulate`.

        Returns
        -------
        xarray.Dataset
            Over ``point``: the images in order, as in `poincare_section`. The start, which is none,
            is not among them.

        Raises
        ------
        OptionError
            When the start fits no mode, or an option is out of its range.

        Warns
        -----
        RunWarning
            When there are fewer points than asked for: the result holds those that there are.

        Examples
        --------
        Maxima of a damped oscillation:

        >>> import nonsmooth as ns
        >>> bell = ns.System(states=["x", "v"], equations={"x": "v", "v": "-x - 0.2*v"})
        >>> top = ns.PoincareMap(bell, "v", direction=-1)
        >>> top.iterate({"v": 1.0}, 2)["x"].values.round(4)
        array([0.8626, 0.4587])
        """
        check_run_options(self.system, None, mode, tolerance)
        return take_points(
            self, initial, transient=0.0, record=whole_number("count", count), mode=mode,
            t_start=t_start, t_end=t_end, tolerance=tolerance,
        )  # fmt: skip

    def tangent(
        self,
        initial: Any = None,
        count: int = 1,
        *,
        mode: str | None = None,
        t_start: float | None = None,
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
        t_start : float, optional
            Time of the start, as in `simulate`.
        tolerance : float, optional
            As in `simulate`.

        Returns
        -------
        xarray.DataArray
            Over ``state`` and ``state_0``: how the states of the last image change with those of
            the start. Where time stands in the system or the section, as with forcing, ``time``
            is the last entry of both: the time of the image, and that of the start.

        Raises
        ------
        OptionError
            When the start fits no mode, or an option is out of its range.
        RunError
            When the motion ends, or does not come through the section so often.

        Notes
        -----
        A start a little later is a point a little later, so the derivative is that at the time of
        the point, taken along the motion onto the section: ``(I - f h_x/(h_x f + h_t)) Phi`` with
        the section ``h``, the flow ``f`` and the derivatives ``Phi`` at a fixed time. With
        ``side="after"`` an event that resets is passed, and ``f`` is the flow behind it. A shift
        of the start along the motion changes nothing, hence one eigenvalue of a periodic
        motion is zero; the others are its multipliers, with forcing those of the stroboscopic map.

        Examples
        --------
        The maxima of a damped oscillation shrink by exp(-0.1 T) each:

        >>> import nonsmooth as ns
        >>> bell = ns.System(states=["x", "v"], equations={"x": "v", "v": "-x - 0.2*v"})
        >>> top = ns.PoincareMap(bell, "v", direction=-1)
        >>> float(top.tangent({"x": 1.0}).sel(state="x", state_0="x").round(4))
        0.5318
        """
        check_run_options(self.system, None, mode, tolerance)
        times = whole_number("count", count) * self.every
        return return_tangent(self, initial, times, mode, t_start, tolerance)

    def runner(self, tolerance: float) -> SectionRunner:
        """Return what applies the map to many starts at once, arrays in and out.

        Analyses use it; one belongs to one thread.

        Parameters
        ----------
        tolerance : float
            As in `simulate`.

        Returns
        -------
        SectionRunner
            With ``start`` and ``iterate``.
        """
        return SectionRunner(self, tolerance)
