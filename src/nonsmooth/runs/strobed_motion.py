"""Strobes of one motion: when it is looked at, and its points, also of one that never repeats."""

from __future__ import annotations

import warnings
from dataclasses import KW_ONLY, dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.status import Status
from nonsmooth.errors import ModelError, OptionError, RunWarning
from nonsmooth.runs.clock import Instant, Plan
from nonsmooth.runs.dataset import run_dataset
from nonsmooth.runs.first_mode import in_first_mode
from nonsmooth.runs.labels import Columns, assemble
from nonsmooth.runs.options import (
    check_count,
    check_run_options,
    check_signals,
    finite_number,
    whole_number,
)
from nonsmooth.runs.runner import Outcome, build_derivatives, build_tables, run_plan
from nonsmooth.runs.start import Start, resolve_start, start_at_end
from nonsmooth.runs.strobe_times import check_phase, hides_phase, require_period, strobes
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import constant_value
from nonsmooth.system.text.grammar import parse

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["StrobeRequest", "StrobeSchedule", "run_strobes", "strobe_points"]


_SAME = 1e-12  # of a strobe period, within which two times are one


@dataclass(frozen=True)
class StrobeSchedule:
    """When the motions of a system are looked at: options as those of `StroboscopicMap`."""

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


def strobe_points(chosen: StrobeSchedule, wanted: StrobeRequest, changed: str = "") -> xr.Dataset:
    """Dataset of the points of one motion; a warning where it ended early."""
    system = chosen.system
    outcome = run_strobes(chosen, wanted, derivatives=False)
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


def run_strobes(chosen: StrobeSchedule, wanted: StrobeRequest, *, derivatives: bool) -> Outcome:
    """Run to the strobes that are wanted, with derivatives by the first of them or without."""
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
    chosen: StrobeSchedule, wanted: StrobeRequest, start: Start, window: float
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
