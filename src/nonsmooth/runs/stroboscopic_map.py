"""`StroboscopicMap`: from one period to the next, with the points of one motion."""

from __future__ import annotations

import warnings
from dataclasses import KW_ONLY, dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.status import CURES, Status
from nonsmooth.errors import ModelError, OptionError, ResultWarning, RunError, RunWarning
from nonsmooth.runs.clock import Instant, Plan
from nonsmooth.runs.dataset import run_dataset
from nonsmooth.runs.first_mode import in_first_mode
from nonsmooth.runs.labels import Columns, assemble
from nonsmooth.runs.maps import Map, tangent_array
from nonsmooth.runs.options import (
    check_count,
    check_run_options,
    check_signals,
    finite_number,
    whole_number,
)
from nonsmooth.runs.runner import Outcome, build_derivatives, build_tables, run_plan
from nonsmooth.runs.start import Start, resolve_start, start_at_end
from nonsmooth.runs.strobe_runner import StrobeRunner
from nonsmooth.runs.strobe_times import check_phase, hides_phase, require_period, strobes
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import constant_value
from nonsmooth.system.text.grammar import parse

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["StrobeRequest", "StroboscopicMap", "strobe_points"]


_SAME = 1e-12  # of a strobe period, within which two times are one


@dataclass(frozen=True)
class StroboscopicMap(Map):
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
    def length(self) -> float | None:
        """Length of time between strobes; None for the period of the system."""
        period = self.period
        if period is None:
            return None
        if isinstance(period, str):
            try:
                period = constant_value(parse(period, where="period"), self.system.parameter_values)
            except KeyError as unknown:
                raise OptionError(
                    f"period: {unknown.args[0]!r} is no parameter of {self.system.name!r}; known"
                    f" are {', '.join(self.system.parameters)}"
                ) from None
            except ModelError as fault:  # the text is no part of the system
                raise OptionError(str(fault)) from None
        length = finite_number("period", period)
        if not length > 0.0:
            raise OptionError(f"period = {length:g} must be positive")
        return length

    @property
    def hides_phase(self) -> bool:
        """Whether points meet the forcing at different phases, which their states do not tell."""
        tables = build_tables(self.system)
        length = tables.window if self.length is None else self.length
        return bool(hides_phase(tables.harmonics[:1], np.array([length * self.every]))[0])

    @property
    def protocol(self) -> dict[str, Any]:
        """What the map is, as attributes of a result."""
        length = self.system.period_value if self.length is None else self.length
        return {"phase_of_period": self.phase, "strobe_period": length, "every": self.every}

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
        """Refuse forcing that does not repeat, and warn where strobes meet it at other phases.

        Parameters
        ----------
        verb : str
            What asks, as the message names it.
        """
        if self.system.unrepeated:
            raise OptionError(
                f"{verb}: {self.system.name!r} has {self.system.unrepeated}, which does not repeat,"
                " so a state at a strobe does not say what follows; leave it out, or look at runs"
                " from one time with simulate or ensemble"
            )
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


class StrobeRequest(NamedTuple):
    """Which strobes of a motion, and from where.

    ``from_start``: count them from the first strobe that is not before the start, otherwise from
    the first one after it, mappings of states being at the phase of the strobe.
    """

    initial: Any
    transient: int
    record: int
    from_start: bool
    mode: str | None
    t_start: float | None
    tolerance: float
    repeated: bool


def strobe_points(chosen: StroboscopicMap, wanted: StrobeRequest, changed: str = "") -> xr.Dataset:
    """Dataset of the points of one motion; a warning where it ended early."""
    system = chosen.system
    outcome = _run(chosen, wanted, derivatives=False)
    options = chosen.protocol | {
        "transient": wanted.transient,
        "record": wanted.record,
        "tolerance": float(wanted.tolerance),
        "changed_parameters": changed,
    }
    points = _over_points(system, run_dataset(system, outcome, options), options)
    if not wanted.from_start:
        label = {"long_name": "iterate"}
        points = points.assign_coords(point=("point", points["point"].values + 1, label))
    if outcome.status not in (Status.COMPLETED, Status.STOPPED):
        # told where the user calls the verb or method that calls this
        warnings.warn(f"{system.name}: {points.attrs['message']}", RunWarning, stacklevel=3)
    return points


def _strobe_tangent(chosen: StroboscopicMap, wanted: StrobeRequest) -> xr.DataArray:
    """Derivative of the last of some strobes by the start."""
    system = chosen.system
    outcome = _run(chosen, wanted, derivatives=True)
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


def _run(chosen: StroboscopicMap, wanted: StrobeRequest, *, derivatives: bool) -> Outcome:
    system = chosen.system
    tables = build_tables(system)
    window = tables.window
    start = resolve_start(
        system, tables, wanted.initial, wanted.t_start, wanted.mode, wanted.repeated
    )
    if derivatives:
        start = start_at_end(start)
    first = wanted.transient
    if not wanted.from_start:
        start, first = _behind(chosen, wanted, start, window)
    every = chosen.every
    numbers, phases = strobes(
        window, start.instant, chosen.length, chosen.phase, first,
        check_count((wanted.record - 1) * every + 1),
    )  # fmt: skip
    numbers, phases = numbers[::every].copy(), phases[::every].copy()
    plan = Plan(Instant(int(numbers[-1]), float(phases[-1])), numbers, phases)
    check_signals(system, start.instant.time(window), plan.end.time(window))
    carried = build_derivatives(system, tables, () if derivatives else None)

    run = partial(
        run_plan, tables, plan, wanted.tolerance, anchor=start.anchor, state=start.state,
        begin=start.instant, keep_events=False, derivatives=carried,
    )  # fmt: skip
    return in_first_mode(system, tables, start, run)


def _behind(
    chosen: StroboscopicMap, wanted: StrobeRequest, start: Start, window: float
) -> tuple[Start, int]:
    """Start, and the number of its image among the strobes that are not before it."""
    length, phase, every = chosen.length, chosen.phase, chosen.every
    if not hasattr(wanted.initial, "data_vars"):  # states at the phase of the strobe
        number, at = strobes(window, Instant(0, 0.0), length, phase, 0, 1)
        return Start(start.state, Instant(int(number[0]), float(at[0])), start.modes), every
    numbers, phases = strobes(window, start.instant, length, phase, 0, 1)
    wait = (int(numbers[0]) - start.instant.number) * window + (
        float(phases[0]) - start.instant.phase
    )
    # a start at a strobe up to rounding is at it, and one just behind it comes after it anyway
    rounding = _SAME * (window if length is None else length)
    rounding += 4.0 * np.finfo(float).eps * abs(start.instant.time(window))
    return start, every if wait <= rounding else every - 1


def _over_points(system: System, run: xr.Dataset, options: dict[str, Any]) -> xr.Dataset:
    """The samples of a run as points of a map."""
    names = (*system.states, *system.outputs, "mode")
    variables: Columns = {
        name: (("point",), run[name].values, dict(run[name].attrs)) for name in names
    }
    number: npt.NDArray[np.int64] = np.arange(run.sizes["time"])
    coords: Columns = {
        "point": (("point",), number, {"long_name": "strobe"}),
        "time": (("point",), run["time"].values, dict(run["time"].attrs)),
    }
    kept = (
        "system", "system_name", "nonsmooth_version", "status", "message", "certified",
        "n_uncertain", "n_estimated", *options,
    )  # fmt: skip
    attrs = {name: run.attrs[name] for name in kept if name in run.attrs}
    return assemble(variables, coords, {}, attrs)
