"""Commands that look at one motion: what they ask the library for, and what they say of it."""

from __future__ import annotations

import math
import tomllib
import warnings
from collections.abc import Callable, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

import click

from nonsmooth.cli.arguments import names, need_period
from nonsmooth.cli.command import Task
from nonsmooth.cli.console import ENDED_EARLY
from nonsmooth.cli.options import flag
from nonsmooth.cli.report import Report
from nonsmooth.cli.variables import chosen, first_state, pair
from nonsmooth.errors import OptionError, ResultWarning, RunError, RunWarning, unknown_name
from nonsmooth.system.columns import with_error

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.system.system import System

__all__ = ["certified", "lyapunov", "section", "simulate", "spectrum", "strobe", "zero_one"]

_PERIODS = 20.0  # as long as the chapter's time histories
_LENGTH = 50.0  # oscillations, without a period
_OSCILLATIONS = 5.0  # in a window of the clock, which is 32 radians of the fastest one
_LAST = 5  # periods whose progression is printed
_MOST_ALIKE = 9  # modes in a row that are all written out
_MATCH = 1e-6  # of the largest size of each state, as in diagrams
_SHOWN = 8  # amplitudes in the summary


def simulate(task: Task) -> None:
    """``nonsmooth simulate``."""
    system = task.system
    shown = _history_variables(system, task["draw"])
    if task["portrait"] is not None and task["orbit"] is not None:
        raise OptionError("give one of --portrait and --orbit, not both")
    kind = "orbit" if task["orbit"] is not None else "portrait"
    if task[kind] is not None and (task["draw"] is not None or task["modes"]):
        raise OptionError(f"{flag(kind)} draws no time history: leave out --draw and --modes")
    coordinates = pair(system, task[kind], flag(kind)) if task[kind] is not None else None
    options = task.options("simulate") | {"events": not task["no_events"]}
    if options["periods"] is not None and options["t_end"] is not None:
        raise OptionError("give one of --periods and --t-end, not both")
    if options["periods"] is None and options["t_end"] is None:
        options |= _default_length(system, options["samples_per_period"])
    window = _window(system, task)
    _check_window(system, window, options)
    run = _quietly(_run, system, **options)

    drawn = task.plot is not None or task.film is not None
    times = _drawn_times(run, window) if drawn else None
    if task.film is not None:
        slow_down = task["slow_down"]
        task.animation(run, portrait=coordinates, time_range=times, slow_down=slow_down)
    if task.plot is not None:
        if coordinates is None:
            history = "phases" if task["modes"] else "time_history"
            from nonsmooth.plot.histories import groups_alike

            for names in groups_alike(run, shown, times):
                task.picture(history, run, names, time_range=times)
        elif kind == "orbit":
            task.picture("orbit", run, *coordinates, time_range=times)
        else:
            several = len(run["mode"].attrs["flag_meanings"].split()) > 1
            colours = {"phases": several, "surfaces": True}
            task.picture("phase_portrait", run, *coordinates, time_range=times, **colours)
    task.finish(run, _run_report(run), code=task.by_status(run))


def _run(system: System, initial: dict[str, float] | None, **options: Any) -> xr.Dataset:
    from nonsmooth.runs.simulate import simulate as run_system

    return run_system(system, initial, **options)


def _quietly(verb: Callable[..., xr.Dataset], *arguments: Any, **options: Any) -> xr.Dataset:
    """Result of a verb; the summary says what its warning would say."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)
        warnings.simplefilter("ignore", ResultWarning)
        return verb(*arguments, **options)


def _history_variables(system: System, text: str | None) -> list[str]:
    """Variables to draw; by default the motion, and what it drifts by."""
    if text is not None:
        known = [*system.states, *system.outputs]
        return chosen(text, known, definitions=system.definitions)
    drifting = list(system.drift_states)
    # states beside a drift are relative to it, and the motion itself is an output
    return [*list(system.outputs)[:1], *drifting] if drifting else list(system.states[:1])


def _default_length(system: System, samples_per_period: int) -> dict[str, Any]:
    """Length of a run where none is given; without a period, by the fastest oscillation."""
    if system.period is not None:
        return {"periods": _PERIODS}
    from nonsmooth.runs.runner import build_tables

    oscillation = build_tables(system).window / _OSCILLATIONS
    samples = math.ceil(_LENGTH * samples_per_period)
    return {"times": [k * oscillation * _LENGTH / samples for k in range(samples + 1)]}


def _window(system: System, task: Task) -> tuple[float, float] | None:
    """Times to draw, with infinity for the end of the run."""
    first, times = task["from"], task["time_range"]
    if first is not None and times is not None:
        raise OptionError("give one of --from and --time-range, not both")
    if times is not None:
        return times
    if first is None:
        return None
    if not first >= 0.0:
        raise OptionError(f"--from = {first:g} must not be negative: it counts periods of the run")
    if system.period_value is None:
        raise OptionError(f"--from counts periods, and {system.name!r} has none; use --time-range")
    return first * system.period_value, math.inf


def _check_window(
    system: System, window: tuple[float, float] | None, length: dict[str, Any]
) -> None:
    """Refuse times to draw that a run of this length does not reach."""
    begin, end, periods = 0.0, length.get("t_end"), length.get("periods")
    if "times" in length:
        begin, end = length["times"][0], length["times"][-1]
    elif end is None and periods is not None and system.period_value is not None:
        end = periods * system.period_value
    if window is None or end is None:
        return
    if not max(window[0], begin) < window[1] or not window[0] < end:
        last = f"{window[1]:g}" if window[1] < math.inf else "the end"
        raise OptionError(
            f"the times to draw, {window[0]:g} to {last}, must run forward, end after the run"
            f" begins at t = {begin:g} and begin before the run ends at t = {end:g}"
        )


def _drawn_times(run: xr.Dataset, window: tuple[float, float] | None) -> tuple[float, float] | None:
    """Times to draw of a run, all of them where it ended before the window."""
    if window is None:
        return None
    first, last = float(run["time"][0]), float(run["time"][-1])
    window = window[0], min(window[1], last)
    if run.attrs["status"] != "completed" and not first <= window[0] < window[1]:
        click.echo("the run ended before the times to draw; all of it is drawn", err=True)
        return None
    return window


def _run_report(run: xr.Dataset) -> Report:
    """Status, events, last period, end and progression of a run."""
    attrs = run.attrs
    report = Report(attrs["system_name"])
    report.add("status", attrs["message"], status=attrs["status"], message=attrs["message"])
    end = attrs["end_number"] * attrs["window"] + attrs["end_phase"]
    start = float(run["time"][0]) if run.sizes["time"] else end
    report.add("time", f"{start:.7g} to {end:.7g}", time=[start, end])
    events, count = f"{attrs['n_events']}", {"events": attrs["n_events"]}
    if "period" in attrs:
        periods, length = (end - start) / attrs["period"], attrs["period"]
        report.add("periods", f"{periods:.7g} of {length:.7g}", periods=periods, period=length)
        if periods > 0.0:
            count["events_per_period"] = attrs["n_events"] / periods
            events += f", {count['events_per_period']:.4g} per period"
    report.add("events", events, **count)
    certified(report, attrs["n_uncertain"], attrs["n_estimated"])
    label = "phase word, last period" if "period" in attrs else "phase word"
    report.add(label, _short(attrs["phase_word"]), phase_word=attrs["phase_word"])
    states = dict(zip(map(str, run["state"].values), run["end_state"].values, strict=True))
    report.add("end state", _values(states), end_state=states)
    _add_progression(report, run)
    return report


def _values(states: dict[str, Any]) -> str:
    return ", ".join(f"{name} = {float(value):.7g}" for name, value in states.items())


def certified(report: Report, uncertain: int, estimated: int) -> None:
    """Add whether a run is certified, or what stands against it."""
    text = "yes"
    if uncertain:
        text = f"no, {uncertain} within rounding of a tangency"
    elif estimated:
        text = f"no, the error of {estimated} steps is estimated"
    counts = {"n_uncertain": int(uncertain), "n_estimated": int(estimated)}
    report.add("certified", text, certified=text == "yes", **counts)


def _short(word: str) -> str:
    """A phase word in which a mode that follows on itself many times stands once."""
    runs = [(mode, len(list(same))) for mode, same in groupby(word.split())]
    return " ".join(
        f"{mode} ({count} times)" if count > _MOST_ALIKE else " ".join([mode] * count)
        for mode, count in runs
    )


def _add_progression(report: Report, run: xr.Dataset) -> None:
    """Add the progression of each drift state over the last periods."""
    from nonsmooth.models import progression

    for state in tomllib.loads(run.attrs["system"]).get("drift", ()):
        try:
            values = progression(run, state)["progression"].values[-_LAST:]
        except OptionError:  # less than a period, or no period at all
            continue
        text = ", ".join(f"{value:.6g}" for value in values)
        of = f" (last {values.size} periods)" if values.size > 1 else ""
        label = f"progression of {state}"
        report.add(label, f"{text} per period{of}", **{f"progression_of_{state}": values})


def section(task: Task) -> None:
    """``nonsmooth section``."""
    from nonsmooth.analysis.poincare_section import poincare_section

    system = task.system
    shown = pair(system, task["draw"], "--draw", "time", *_CLOCK if system.period_value else ())
    points = _quietly(poincare_section, system, **task.options("poincare_section"))
    attrs = points.attrs
    report = Report(attrs["system_name"])
    _add_points(report, points, attrs["n_points"])
    if attrs["n_points"]:
        _add_times(report, points)
        states = [str(name) for name in points.data_vars if points[name].dtype.kind == "f"]
        for k, label in ((0, "first point"), (-1, "last point")):
            _add_point(report, label, points, states, k)
    _finish_points(task, points, report, shown)


_CLOCK = ("phase", "period_number")


def strobe(task: Task) -> None:
    """``nonsmooth strobe``."""
    from nonsmooth.analysis.diagrams.strobe_periods import period_of_points

    system = task.system
    shown = pair(system, task["draw"], "--draw", "time")
    points = _strobes(task)
    count = points.sizes["point"]
    report = Report(points.attrs["system_name"])
    _add_points(report, points, count)
    if count:
        _add_times(report, points)
        repeats = 0 if system.unrepeated else period_of_points(points, _MATCH)
        text = f"after {repeats} points" if repeats else "not within these points"
        text = f"no: {system.unrepeated} does not either" if system.unrepeated else text
        report.add("repeats", text, repeats=repeats or None)
        _add_point(report, "last point", points, system.states, -1)
    _finish_points(task, points, report, shown)


def _strobes(task: Task) -> xr.Dataset:
    from nonsmooth.analysis.stroboscopic_map import stroboscopic_map

    system, options = task.system, task.options("stroboscopic_map")
    if options["period"] is None:
        need_period(
            system,
            "give the time between strobes by --period, or take points of a section: nonsmooth"
            f" section --section {system.states[-1]}",
        )
    return _quietly(stroboscopic_map, system, **options)


def _add_points(report: Report, points: xr.Dataset, count: int) -> None:
    attrs = points.attrs
    report.add("status", attrs["message"], status=attrs["status"], message=attrs["message"])
    report.add("points", f"{count} of {attrs['record']}", points=count, record=attrs["record"])
    certified(report, attrs["n_uncertain"], attrs["n_estimated"])


def _add_times(report: Report, points: xr.Dataset) -> None:
    time = points["time"].values
    report.add("time", f"{time[0]:.7g} to {time[-1]:.7g}", time=[time[0], time[-1]])


def _add_point(
    report: Report, label: str, points: xr.Dataset, states: Sequence[str], k: int
) -> None:
    values = {name: float(points[name][k]) for name in states}
    report.add(label, _values(values), **{label.replace(" ", "_"): values})


def _finish_points(task: Task, points: xr.Dataset, report: Report, shown: tuple[str, str]) -> None:
    code = task.by_status(points)
    if points.sizes["point"]:
        task.picture("section", points, *shown, phases=task["modes"])
    else:
        drawn = " to draw" if task.plot is not None else ""
        click.echo(f"nonsmooth: there are no points{drawn}; the status says why", err=True)
        code = code or ENDED_EARLY
    task.finish(points, report, code=code)


def lyapunov(task: Task) -> None:
    """``nonsmooth lyapunov``."""
    from nonsmooth.analysis.lyapunov_spectrum import lyapunov_spectrum

    result = _quietly(lyapunov_spectrum, task.system, **task.options("lyapunov_spectrum"))
    if result.sizes["time"]:
        task.picture("exponents", result)
    task.finish(result, _exponents_report(result), code=task.by_status(result))


def _exponents_report(result: xr.Dataset) -> Report:
    """Exponents with their errors, sum, dimension and what they were averaged over."""
    attrs = result.attrs
    report = Report(attrs["system_name"])
    report.add("status", attrs["message"], status=attrs["status"], message=attrs["message"])
    if attrs["chaotic_for"]:  # the message tells it in words
        report.data |= {name: attrs[name] for name in ("chaotic_for", "escape_rate_below")}
    values, errors = result["lyapunov_exponent"].values, result["standard_error"].values
    for k, (value, error) in enumerate(zip(values, errors, strict=True), start=1):
        text = with_error(value, error, 6, 2)
        report.add(
            f"exponent {k}", f"{text} per unit time", exponents=values, standard_errors=errors
        )
    for name, label in (("exponent_sum", "sum"), ("kaplan_yorke_dimension", "dimension")):
        value = float(result[name])
        if value == value:
            report.number(label, value, ".9g")
    length = {name: attrs[name] for name in ("duration", "n_events", "n_impacts")}
    text = f"time {attrs['duration']:.7g}"
    if "period" in attrs:
        length["periods"] = attrs["duration"] / attrs["period"]
        text += f", {length['periods']:.7g} periods"
    text += f", {attrs['n_events']} events, {attrs['n_impacts']} impacts"
    report.add("averaged over", text, averaged_over=length)
    certified(report, attrs["n_uncertain"], attrs["n_estimated"])
    if not attrs["blocks_independent"]:
        text = "too small, blocks are correlated or few; take a longer --record"
        report.add("errors", text, doubt=text)
    return report


def spectrum(task: Task) -> None:
    """``nonsmooth spectrum``."""
    system = task.system
    variables = names(task["variable"], "--variable") or [first_state(system)]
    known = [*system.states, *system.outputs]
    chosen(",".join(variables), known, "--variable", definitions=system.definitions)
    if len(variables) > 2 or len(set(variables)) < len(variables):
        raise OptionError(
            f"--variable: {task['variable']!r} is neither one variable nor two different ones"
        )
    options = task.options("simulate") | _record_length(system, task)
    run = _quietly(_run, system, **options)
    if run.attrs["status"] != "completed":
        raise RunError(f"{system.name}: {run.attrs['message']}")
    from nonsmooth.analysis.full_spectrum import full_spectrum
    from nonsmooth.analysis.power_spectrum import power_spectrum

    analyse: Any = full_spectrum if len(variables) == 2 else power_spectrum
    parts = task.options("power_spectrum")
    result = analyse(run, *variables, transient=task["transient"], **parts)

    task.picture("spectrum", result)
    drifting = [name for name in variables if name in system.drift_states]
    task.finish(result, _spectrum_report(result, drifting))


def _record_length(system: System, task: Task) -> dict[str, Any]:
    """Length of a run with its transient, in periods, or in times of its samples."""
    import numpy as np

    transient, record, samples = task["transient"], task["record"], task["samples_per_period"]
    if not transient >= 0.0:
        raise OptionError(f"--transient = {transient:g} must not be negative")
    if not record > 0.0:
        raise OptionError(f"--record = {record:g} must be positive")
    if samples < 2:
        raise OptionError(f"--samples-per-period = {samples} must be 2 or more")
    if system.period is not None:
        length = {"periods": transient + record, "samples_per_period": samples}
        return {**length, "events": False}
    times = np.arange(int((transient + record) * samples) + 1) / samples
    return {"times": times, "events": False}


def _spectrum_report(result: xr.Dataset, drifting: Sequence[str]) -> Report:
    """The largest amplitudes, by frequency and harmonic; of drifting states what was taken off."""
    import numpy as np

    attrs, frequency = result.attrs, result["frequency"].values
    report = Report(str(attrs["system_name"]))
    report.add("variable", str(attrs["variable"]))
    record = {name: attrs[name] for name in ("segments", "n_samples", "window")}
    text = f"{attrs['segments']} x {attrs['n_samples']} samples, window {attrs['window']}"
    report.add("record", text, record=record)
    if drifting:  # its mean is that of the place where the record begins
        report.add("drift", f"the mean progression of {' and '.join(drifting)} is taken off")
    elif "second_mean" in attrs:
        for name, key in (("variable", "mean"), ("second_variable", "second_mean")):
            report.add(f"mean of {attrs[name]}", f"{attrs[key]:.6g}", **{key: attrs[key]})
    else:
        report.number("mean", attrs["mean"], ".6g")
    amplitude = np.where(frequency == 0.0, 0.0, result["amplitude"].values)
    rising = np.concatenate([[False], amplitude[1:] > amplitude[:-1]])
    falling = np.concatenate([amplitude[:-1] >= amplitude[1:], [True]])
    peaks = np.flatnonzero(rising & falling & (amplitude > 1e-9 * amplitude.max()))
    largest = peaks[np.argsort(-amplitude[peaks], kind="stable")][:_SHOWN]
    found: list[dict[str, Any]] = []
    for k in sorted(largest):
        found.append({"frequency": frequency[k], "amplitude": amplitude[k]})
        text = f"amplitude {amplitude[k]:.6g}"
        if "harmonic" in result.coords:
            found[-1]["harmonic"] = result["harmonic"].values[k]
            text += f", harmonic {float(found[-1]['harmonic']):.6g}"
        report.add(f"frequency {float(frequency[k]):.6g}", text, peaks=found)
    return report


def zero_one(task: Task) -> None:
    """``nonsmooth zero-one``."""
    from nonsmooth.analysis.zero_one_test import zero_one_test
    from nonsmooth.runs.strobe_times import require_repeats
    from nonsmooth.runs.stroboscopic_map import StroboscopicMap

    system = task.system
    require_repeats(system, "zero-one")
    if task["period"] is not None:
        StroboscopicMap(system, period=task["period"]).check_whole_periods()
    known = [*system.states, *system.outputs]
    tested = task["variable"] or first_state(system)
    if tested not in known:
        raise OptionError(f"--variable: {unknown_name('variable', tested, known)}")
    points = _strobes(task)
    if points.attrs["status"] != "completed":
        raise RunError(f"{system.name}: {points.attrs['message']}")
    with warnings.catch_warnings(record=True) as raised:
        warnings.simplefilter("always", ResultWarning)
        result = zero_one_test(points, tested, **task.options("zero_one_test"))
    attrs = result.attrs
    report = Report(str(attrs["system_name"]))
    text = f"{attrs['variable']}, {attrs['n_points']} strobes"
    report.add("variable", text, variable=attrs["variable"], n_points=attrs["n_points"])
    report.number("K", float(result["K"]), ".4g")
    low, high = float(result["K_low"]), float(result["K_high"])
    report.add("nine of ten", f"{low:.4g} to {high:.4g}", K_low=low, K_high=high)
    doubts = [str(one.message) for one in raised if issubclass(one.category, ResultWarning)]
    for doubt in doubts:
        report.add("doubt", doubt, doubts=doubts)

    task.picture("translation", result)
    task.finish(result, report)
