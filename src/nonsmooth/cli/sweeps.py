"""Commands that run a system for many values of parameters or many initial states."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth.cli.arguments import names, need_period, settings, value_limits, value_range
from nonsmooth.cli.basins import or_blank
from nonsmooth.cli.command import Task
from nonsmooth.cli.report import Column, Report
from nonsmooth.cli.variables import first_state, single
from nonsmooth.errors import ModelError, OptionError, unknown_name

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from nonsmooth.system.system import System

__all__ = ["certified_runs", "contacts", "diagram", "ensemble", "picture", "waterfall"]

_FORCED = "this command looks at a forced system, once per period of its forcing"
_SHOWN = 8  # harmonics, or periods, in a summary
_MOST = 40  # attractors and branches of a picture, in a summary


def certified_runs(report: Report, result: xr.Dataset) -> None:
    """Add whether all runs of a result are certified, or how many are not."""
    uncertain, estimated = (
        int((result[name].values > 0).sum()) for name in ("n_uncertain", "n_estimated")
    )
    against = []
    if uncertain:
        against.append(f"{uncertain} within rounding of a tangency")
    if estimated:
        against.append(f"{estimated} with estimated errors of steps")
    text = "all runs but " + ", ".join(against) if against else "yes"
    counts = {"uncertain_runs": uncertain, "estimated_runs": estimated}
    report.add("certified", text, certified=not against, **counts)


def _parameter_range(task: Task) -> tuple[str, np.ndarray]:
    """A parameter of the system and its values."""
    name, values = value_range(task["over"])
    if name not in task.system.parameters:
        raise OptionError(f"--over: {unknown_name('parameter', name, task.system.parameters)}")
    task.refuse_fixed([name], "--over")
    return name, values


def diagram(task: Task) -> None:
    """``nonsmooth diagram``."""
    from nonsmooth.analysis.bifurcation_diagram import bifurcation_diagram
    from nonsmooth.runs.poincare_map import PoincareMap

    system = task.system
    parameter, values = _parameter_range(task)
    drawn = _diagram_variable(system, task["draw"])
    options = task.options("bifurcation_diagram", "initial")
    target: Any = system
    if task["section"] is not None:
        where = {name: task[name] for name in ("direction", "side")}
        target = PoincareMap(system, task["section"], **where)
        options["side"] = "before"
    elif task["direction"] is not None:
        raise OptionError("--direction is that of a section: name it with --section")
    else:
        need_period(
            system,
            f"take points on a section in place of strobes, such as --section {system.states[-1]}",
        )
    starts = list(task["initial"]) or None
    result = bifurcation_diagram(target, parameter, values, initial=starts, **options)

    task.picture("bifurcation", result, drawn, colour=task["colour"])
    complete = result.attrs["message"].startswith("completed")
    report = _diagram_report(result)
    _add_refusal(report, system, result)
    task.finish(result, report, code=task.by_message(result, complete))


def _add_refusal(report: Report, system: System, result: xr.Dataset) -> None:
    """Say why the system refuses a value, where it refuses some."""
    refused = (result["status"] == "refused").any("lane").values
    parameter = result.attrs["parameter"]
    for value in result["parameter"].values[refused][:1]:
        try:
            system.with_parameters(**{parameter: float(value)})
        except ModelError as error:
            reason = str(error).splitlines()[0]
            report.add("refused", f"such as {parameter} = {value:g}: {reason}", refusal=reason)


def _diagram_variable(system: System, text: str | None) -> str:
    """What to draw: a state, an output, a count, or how fast the system drifts."""
    if text is None:
        return first_state(system)
    counts = ("period", "events", "impacts")
    drifts = [f"{name}_per_{unit}" for name in system.drift_states for unit in ("period", "time")]
    return single(text, [*system.states, *system.outputs, *counts, *drifts])


def _diagram_report(result: xr.Dataset) -> Report:
    """How many columns there are, and of which period."""
    import numpy as np

    attrs, sizes = result.attrs, result.sizes
    status, period = result["status"].values.ravel(), result["period"].values.ravel()
    counts = {str(word): int(np.count_nonzero(status == word)) for word in sorted(set(status))}
    report = Report(
        attrs["system_name"],
        f"{sizes['parameter']} values of {attrs['parameter']}, {sizes['lane']} initial state(s)",
    )
    report.data |= {"parameter": attrs["parameter"], "values": sizes["parameter"]}
    report.data["initial_states"] = sizes["lane"]
    report.add("status", ", ".join(f"{n} {word}" for word, n in counts.items()), status=counts)
    settled = period[status == "completed"]
    of_period = {
        int(p): int(np.count_nonzero(settled == p)) for p in sorted(set(settled[settled > 0]))
    }
    shown = list(of_period.items())[:_SHOWN]
    texts = [f"{n} of period {p}" for p, n in shown]
    others = settled.size - sum(n for _, n in shown)
    if others:
        texts.append(f"{others} of longer period or none")
    unsettled = settled.size - sum(of_period.values())
    motions = {"of_period": of_period, "of_no_period": unsettled}
    report.add("motions", ", ".join(texts or ["none settled"]), **motions)
    certified_runs(report, result)
    if others:
        _say_restless(report, result)
    return report


def picture(task: Task) -> None:
    """``nonsmooth picture``."""
    from nonsmooth.analysis.bifurcation_picture import bifurcation_picture
    from nonsmooth.runs.stroboscopic_map import StroboscopicMap

    system = task.system
    need_period(system, _FORCED)
    parameter, between, region = _picture_ranges(task)
    drawn = first_state(system) if task["draw"] is None else single(task["draw"], system.states)
    options = task.options("bifurcation_picture", "completion")
    options["completion"] = dict(settings(task["complete"], "--complete", "q=max(0,p-g)"))
    chosen = StroboscopicMap(system, **task.options("StroboscopicMap"))
    result = bifurcation_picture(chosen, parameter, between, region, **options)

    task.picture("bifurcation_picture", result, drawn)
    complete = result.attrs["status"] == "completed"
    task.finish(result, _picture_report(result), code=task.by_message(result, complete))


def _picture_ranges(
    task: Task,
) -> tuple[str, tuple[float, float], dict[str, tuple[float, float]]]:
    """The parameter with its ends, and the ranges of states, from one option."""
    settings(task["over"], "--over")  # refuses a name that is given twice
    ranges = dict(map(value_limits, task["over"]))
    known = {*task.system.parameters, *task.system.states}
    for name in ranges:
        if name not in known:
            raise OptionError(f"--over: {unknown_name('parameter or state', name, sorted(known))}")
    varied = [name for name in ranges if name in task.system.parameters]
    region = {name: ends for name, ends in ranges.items() if name not in varied}
    if len(varied) != 1 or not region:
        raise OptionError(
            "--over: give the range of one parameter, such as --over omega=0.6:0.9, and of one"
            f" state or more, such as --over {task.system.states[0]}=-1:1"
        )
    task.refuse_fixed(varied, "--over")
    return varied[0], ranges[varied[0]], region


def _picture_report(result: xr.Dataset) -> Report:
    """How many attractors there are where, and which branches."""
    import numpy as np

    attrs = result.attrs
    low, high = result["parameter"].values[[0, -1]].tolist()
    report = Report(attrs["system_name"], f"{attrs['parameter']} from {low:g} to {high:g}")
    report.data |= {"parameter": attrs["parameter"], "between": [low, high]}
    report.add("status", attrs["message"], status=attrs["status"], message=attrs["message"])
    number = "{:.6g}".format
    columns: list[Column] = [
        ("", "attractor", str), ("from", "from", number), ("to", "to", number),
        ("kinds", "kinds", ", ".join), ("periods", "periods", _first_periods),
        ("largest share", "largest_share", "{:.1%}".format),
        ("chaotic for", "chaotic_for", or_blank(str)),
    ]  # fmt: skip
    report.table("attractors", columns, _attractor_rows(result), _MOST)
    ends = [
        result[name].values.tolist() if name in result else []
        for name in ("branch_period", "branch_end_first", "branch_end_last")
    ]
    sizes = np.bincount(result.get("branch_of_point", np.zeros(0, np.int64)))
    columns = [
        ("", "branch", str), ("period", "period", str), ("points", "points", str),
        ("first end", "first_end", str), ("last end", "last_end", str),
    ]  # fmt: skip
    rows = [
        (k, period, int(size), first, last)
        for k, (size, period, first, last) in enumerate(zip(sizes, *ends, strict=True), start=1)
    ]
    report.table("branches", columns, rows, _MOST)
    return report


def _attractor_rows(result: xr.Dataset) -> Iterator[tuple[Any, ...]]:
    """Where each attractor was found, and as what."""
    kind = result["kind"].values
    for k, number in enumerate(result["attractor"].values.tolist()):
        there = kind[:, k] != ""
        values = result["parameter"].values[there]
        yield (
            number, float(values[0]), float(values[-1]), sorted(set(kind[there, k].tolist())),
            sorted(set(result["period"].values[there, k].tolist()) - {0}),
            float(result["fraction"].values[there, k].max()),
            min(filter(None, result["chaotic_for"].values[:, k].tolist()), default=None),
        )  # fmt: skip


def _first_periods(periods: list[int]) -> str:
    more = ", ..." if len(periods) > _SHOWN else ""
    return ", ".join(map(str, periods[:_SHOWN])) + more


def waterfall(task: Task) -> None:
    """``nonsmooth waterfall``."""
    from nonsmooth.analysis.waterfall import waterfall as compute

    system = task.system
    need_period(system, _FORCED)
    parameter, values = _parameter_range(task)
    variables = names(task["variable"], "--variable") or first_state(system)
    options = task.options("waterfall", "variable")
    result = compute(system, parameter, values, variables, **options)

    task.picture("waterfall", result, kind=task["picture"], over=task["axis"])
    report = _waterfall_report(result)
    _say_restless(report, result)
    complete = result.attrs["message"].startswith("completed")
    task.finish(result, report, code=task.by_message(result, complete))


def _say_restless(report: Report, result: xr.Dataset) -> None:
    """Add how many motions have not settled, where there are some."""
    _, _, doubt = result.attrs["message"].partition("; ")
    # of an interrupted sweep the whole message is told at the end
    if doubt and result.attrs["status"] != "interrupted":
        report.add("message", doubt)


def _waterfall_report(result: xr.Dataset) -> Report:
    """The harmonics that are largest anywhere, and where that is."""
    import numpy as np

    attrs, report = result.attrs, Report(str(result.attrs["system_name"]))
    amplitude = result["amplitude"].where(result["harmonic"] != 0.0, 0.0).fillna(0.0)
    largest = amplitude.max("parameter").values
    place = result["parameter"].values[amplitude.argmax("parameter").values]
    neighbours = np.pad(largest, 1)
    peaks = np.flatnonzero((largest > neighbours[:-2]) & (largest >= neighbours[2:]))
    of = [name for name in (attrs["variable"], attrs["second_variable"]) if name]
    spectra, parameter = result.sizes["parameter"], attrs["parameter"]
    text = f"{spectra} over {parameter}, of {', '.join(of)}"
    report.add("spectra", text, spectra=spectra, parameter=parameter, variables=of)
    found = []
    for k in sorted(peaks[np.argsort(-largest[peaks], kind="stable")][:_SHOWN]):
        harmonic = float(result["harmonic"][k])
        found.append({"harmonic": harmonic, "amplitude": largest[k], "at": place[k]})
        text = f"amplitude up to {largest[k]:.6g}, at {parameter} = {place[k]:.6g}"
        report.add(f"harmonic {harmonic:.6g}", text, peaks=found)
    return report


def contacts(task: Task) -> None:
    """``nonsmooth contacts``."""
    from nonsmooth.analysis.contact_statistics import contact_statistics

    if task.plot is not None and task["over"] is None:
        raise OptionError(
            "--plot draws over a parameter: give its range, such as --over eta=2:3:40"
        )
    system = task.system
    over: tuple[Any, Any] = (None, None)
    need_period(system, _FORCED)
    if task["over"] is not None:
        over = _parameter_range(task)
    modes = {*system.modes, *system.mode_names}
    if not task.is_given("contact") and "contact" not in modes:
        known = ", ".join(sorted(modes))
        raise OptionError(
            f"{system.name} has no mode 'contact'; name the modes that count by --contact (known:"
            f" {known})"
        )
    options = task.options("contact_statistics")
    result = contact_statistics(system, *over, **options)
    drawn = task["draw"] or next(iter(options["of"]), "contacts")
    if task.plot is not None:
        single(drawn, [*options["of"], *map(str, result.data_vars)])

    task.picture("statistics", result, drawn)
    report = _contacts_report(result)
    _say_restless(report, result)
    complete = result.attrs["message"].startswith("completed")
    task.finish(result, report, code=task.by_message(result, complete))


def _contacts_report(result: xr.Dataset) -> Report:
    """Every number, or its range over the parameter."""
    import numpy as np

    report = Report(str(result.attrs["system_name"]))
    for label, values in result.data_vars.items():
        if values.dtype.kind != "f" or "percentile" in values.dims:
            continue
        name, finite = str(label), values.values[np.isfinite(values.values)]
        if finite.size == 0:
            report.add(name, "none", **{name: None})
        elif values.ndim == 0:
            report.number(name, float(values), ".6g")
        else:
            ends = finite.min(), finite.max()
            report.add(name, f"{ends[0]:.6g} to {ends[1]:.6g}", **{name: ends})
    return report


def ensemble(task: Task) -> None:
    """``nonsmooth ensemble``."""
    from nonsmooth.analysis.ensemble import ensemble as run

    store = task["store"]
    if task.save is not None and store is not None:
        raise OptionError(f"--save: the result is in {Path(store) / 'result.nc'}; leave out --save")
    need_period(task.system, _FORCED)
    initial, several = _lists(task.system, task["over"])
    task.refuse_fixed(several, "--over")
    for name, value in (task["initial"] or {}).items():
        if name in initial:
            raise OptionError(f"--initial: {name} is given by --over already")
        initial[name] = value
    result = run(task.system, initial, parameters=several, **task.options("ensemble", "initial"))
    report, sizes = Report(result.attrs["system_name"]), result.sizes
    import numpy as np

    words, counts = np.unique(result["status"].values.astype(str), return_counts=True)
    ended = {str(word): int(n) for word, n in zip(words, counts, strict=True)}
    report.number("runs", sizes["lane"])
    report.add("status", ", ".join(f"{n} {word}" for word, n in ended.items()), status=ended)
    report.add("strobes", f"{sizes['point']} of each", strobes=sizes["point"])
    certified_runs(report, result)
    kept = None if store is None else f"{Path(store) / 'result.nc'}"
    task.finish(result, report, kept=kept, code=task.by_message(result))


def _lists(system: System, over: tuple[str, ...]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Initial states in every combination, and values of parameters."""
    import numpy as np

    states: dict[str, np.ndarray] = {}
    several: dict[str, np.ndarray] = {}
    for text in over:
        name, values = value_range(text)
        if name in states or name in several:
            raise OptionError(f"--over: {name!r} is given twice")
        if name not in system.states and name not in system.parameters:
            known = [*system.states, *system.parameters]
            raise OptionError(f"--over: {unknown_name('state or parameter', name, known)}")
        (states if name in system.states else several)[name] = values
    grids = np.meshgrid(*states.values(), indexing="ij") if states else []
    return dict(zip(states, (grid.ravel() for grid in grids), strict=True)), several
