"""`period_statistics`: what each period of a run shows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.options import derived_attributes
from nonsmooth.analysis.spectra.segments import check_run
from nonsmooth.analysis.statistics.series import clock_name, is_by_angle, slow_names
from nonsmooth.analysis.sweeps.contacts import visits_of
from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.runs.options import whole_number
from nonsmooth.runs.start import mode_numbers
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["period_statistics"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def period_statistics(
    run: xr.Dataset,
    variables: str | Sequence[str] = (),
    *,
    contact: str | None = None,
    periods: int = 1,
) -> xr.Dataset:
    """Largest and smallest values, and contacts, period by period: the envelope of a run.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `simulate`, such as a run-up with a slow parameter; or of `measured.synchronous`.
    variables : str or sequence of str, optional
        States and outputs.
    contact : str, optional
        A mode, for all of its cells, whose visits are counted.
    periods : int, optional
        Periods that are put together, so that a motion of a longer period has one amplitude.

    Returns
    -------
    xarray.Dataset
        Over ``period``, the whole periods of the run by number, or each so many-th: of each
        variable ``_min``, ``_max`` and ``_amplitude``, half of what lies between; with ``contact``
        also ``contacts``, how many begin per period, and ``contact_share``, the part of the time.
        ``begin`` is the time at which a period begins; slow parameters have their names, and so has
        the ``speed`` of a measured motion. They are means where periods are put together.

    Raises
    ------
    OptionError
        For an unknown name, a run without a period or shorter than one, or without its event log
        where contacts are to be counted.

    See Also
    --------
    contact_statistics : of settled motions, and over a parameter.
    order_tracking : the frequencies in it.

    Notes
    -----
    Extremes are those of the samples and, of states, of the values just before and just after
    events; a smooth peak between two of N samples per period is missed by up to (pi h / N)**2 / 2
    of the amplitude of harmonic h. Contacts are exact.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.moling(), periods=20)
    >>> found = ns.period_statistics(run, "y", contact="progression")
    >>> found["contacts"].values[-3:], found["y_amplitude"].values[-3:].round(4)
    (array([1., 1., 1.]), array([5.1159, 5.1159, 5.1159]))
    """
    check_run(run)
    if not isinstance(variables, str | Sequence):
        raise OptionError(f"variables = {quote(variables)}: give a name, or a list of names")
    names = [variables] if isinstance(variables, str) else [str(name) for name in variables]
    known = [str(v) for v in run.data_vars if run[v].dims == ("time",) and v != "mode"]
    for name in names:
        if name not in known:
            raise OptionError(f"variables: {unknown_name('variable', name, known)}")
    frame = _Frame(run, whole_number("periods", periods))
    time = run[clock_name(run)].attrs
    found: dict[str, Any] = {}
    for name in slow_names(run):
        found[name] = ("period", frame.constant(run[name].values), run[name].attrs)
    if is_by_angle(run) and "speed" in run.coords:
        found["speed"] = ("period", frame.begun(run["speed"].values), run["speed"].attrs)
    for name in names:
        low, high = frame.extremes(name)
        label = run[name].attrs.get("long_name", name)
        for key, text, values in (
            ("min", "least {}", low),
            ("max", "largest {}", high),
            ("amplitude", "half the range of the {}", (high - low) / 2.0),
        ):
            attrs = run[name].attrs | {"long_name": text.format(label)}
            found[f"{name}_{key}"] = ("period", values, attrs)
    if contact is not None:
        contacts, share = frame.contacts(contact)
        found["contacts"] = ("period", contacts, {"long_name": "contacts per period"})
        found["contact_share"] = ("period", share, {"long_name": "part of the time in contact"})
    import xarray as xr

    coords: dict[str, Any] = {
        "period": (
            "period", frame.numbers[:: frame.together], {"long_name": "whole periods before"},
        ),
        "begin": (
            "period", frame.begin[: -1 : frame.together],
            time | {"long_name": "time at which the period begins"},
        ),
    }  # fmt: skip
    attrs = derived_attributes(run) | {
        "contact": contact or "",
        "periods": frame.together,
    }
    attrs["slow"] = " ".join(slow_names(run))
    return xr.Dataset(found, coords, attrs)


class _Frame:
    """The whole periods of a run, and which samples lie in them."""

    def __init__(self, run: xr.Dataset, together: int) -> None:
        if "phase" not in run.coords:
            raise OptionError("the system of the run has no period; there are no statistics of any")
        self.run, self.together = run, together
        number, phase = run["period_number"].values, run["phase"].values
        first = int(number[0]) + (1 if phase[0] > 0.0 else 0) if number.size else 0
        count = int(number[-1]) - first if number.size else 0
        count -= count % together
        if count < 1:
            what = "no whole period" if together == 1 else f"fewer than {together} whole periods"
            raise OptionError(f"the run holds {what}; simulate a longer one")
        self.numbers = np.arange(first, first + count)
        at_begin = phase == 0.0
        # a sample at a strobe ends one period and begins the next
        self._inner = number - first
        self._closed = self._inner - at_begin
        self.begin = np.full(count + 1, np.nan)
        # of samples even in the angle of a shaft, the phase is no measured time
        begins = at_begin if is_by_angle(run) else np.ones(phase.size, bool)
        elapsed = run[clock_name(run)].values - np.where(begins, phase, 0.0)
        self._put(self.begin, self._inner[begins], elapsed[begins])

    def _put(self, target: npt.NDArray[Any], place: Integers, values: npt.NDArray[Any]) -> None:
        within = (place >= 0) & (place < target.size)
        target[place[within]] = values[within]

    def constant(self, values: Floats) -> Floats:
        """Values of what is constant in each period; at its end it is that before the change."""
        found = np.full(self.numbers.size, np.nan)
        self._put(found, self._closed, values)
        return self._mean(found)

    def begun(self, values: Floats) -> Floats:
        """Values of what is constant in each period and changes with its first sample."""
        found = np.full(self.numbers.size, np.nan)
        self._put(found, self._inner, values)
        return self._mean(found)

    def _mean(self, values: npt.NDArray[Any]) -> Floats:
        return np.asarray(values.reshape(-1, self.together).mean(axis=1))

    def extremes(self, name: str) -> tuple[Floats, Floats]:
        """Smallest and largest value in each period."""
        values = self.run[name].values
        parts = [(self._inner, values), (self._closed, values)]
        states = [str(state) for state in self.run["state"].values] if "state" in self.run else []
        if name in states and "state_before" in self.run:
            place = self.run["event_period_number"].values - self.numbers[0]
            k = states.index(name)
            for side in ("before", "after"):
                parts.append((place, self.run[f"state_{side}"].values[:, k]))
        low = np.full(self.numbers.size, np.inf)
        high = -low
        for place, some in parts:
            within = (place >= 0) & (place < low.size)
            np.minimum.at(low, place[within], some[within])
            np.maximum.at(high, place[within], some[within])
        shape = (-1, self.together)
        return low.reshape(shape).min(axis=1), high.reshape(shape).max(axis=1)

    def contacts(self, contact: str) -> tuple[Floats, Floats]:
        """ModeVisits that begin per period, and the part of its time."""
        run = self.run
        if "event_time" not in run:
            raise OptionError("the run has no event log; simulate without events=False")
        if "system" not in run.attrs:
            raise OptionError(
                "the run does not say of which system it is, as one in other units does not; count"
                " the contacts of the run as it came from simulate"
            )
        try:
            modes = mode_numbers(System.from_toml(run.attrs["system"]), contact)
        except OptionError as fault:
            raise OptionError(f"contact: {str(fault).removeprefix('mode: ')}") from None
        kept = ~np.isin(run["event_kind"].values.astype(str), ["graze", "start"])
        times, number = (run[f"event_{x}"].values[kept] for x in ("time", "period_number"))
        inside = np.isin(run["event_to"].values[kept], modes)
        before = np.isin(run["event_from"].values[kept], modes)
        at_first = bool(before[0]) if before.size else bool(np.isin(run["mode"].values[-1], modes))
        count = np.zeros(self.numbers.size, np.int64)
        place = number[inside & ~before] - self.numbers[0]
        np.add.at(count, place[(place >= 0) & (place < count.size)], 1)
        low, high = float(run["time"][0]), float(run["time"][-1])
        visits = visits_of(times, inside, at_first, low, high)
        knots = np.column_stack([visits.begin, visits.end]).ravel()
        passed = np.column_stack([np.zeros(visits.begin.size), visits.end - visits.begin]).ravel()
        total = np.interp(self.begin, knots, np.cumsum(passed)) if knots.size else 0.0 * self.begin
        every = slice(None, None, self.together)
        return self._mean(count), np.diff(total[every]) / np.diff(self.begin[every])
