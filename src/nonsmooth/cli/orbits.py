"""Commands that find a periodic orbit and follow it over a parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from nonsmooth.cli.arguments import names, value_limits
from nonsmooth.cli.command import Task
from nonsmooth.cli.console import ENDED_EARLY
from nonsmooth.cli.report import Column, Report, complex_text
from nonsmooth.cli.saved import saved_dataset
from nonsmooth.cli.variables import chosen, first_state, pair, single
from nonsmooth.errors import OptionError, unknown_name

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.system.system import System

__all__ = ["crossings", "follow", "manifold", "orbit"]

_MOST_LEGS = 40  # that are printed
_MOST_MODES = 12  # of a word
_MOST_BORDERS = 60  # that are printed
_MOST_SPECIAL = 60  # points that are printed
_NOT_FOLLOWED = {"singular", "smallest_step", "domain", "fault"}  # ends where a branch may go on


def orbit(task: Task) -> None:
    """``nonsmooth orbit``."""
    import nonsmooth as ns

    pictures = [name for name in ("draw", "history", "multipliers") if task[name]]
    if len(pictures) > 1:
        raise OptionError("give one of --draw, --history and --multipliers: it is one picture")
    system = task.system
    coordinates = pair(system, task["draw"])
    shown = chosen(task["history"] or "", [*system.states, *system.outputs], "--history")
    found = ns.find_orbit(system, **task.options("find_orbit"))

    if task.plot is not None and not _exists(found):
        click.echo("there is no orbit to draw", err=True)
    elif task["multipliers"]:
        task.picture("multipliers", found)
    elif task.plot is not None:
        samples, drift = ns.orbit_samples(found), not task["less_drift"]
        if shown or "time" in coordinates:
            task.picture("orbit_history", samples, shown or coordinates[1], drift=drift)
        else:
            task.picture("periodic_orbit", samples, *coordinates, drift=drift)
    task.finish(found, _orbit_report(found), code=task.by_status(found))


def _exists(found: xr.Dataset) -> bool:
    """Whether there is an orbit, be it inadmissible."""
    length = float(found["length"].item())
    return length == length


def _orbit_report(found: xr.Dataset) -> Report:
    """What is known of an orbit; of none only why."""
    attrs = found.attrs
    report = Report(attrs["system_name"])
    message = str(attrs["message"])
    report.add("status", message, status=attrs["status"], message=message)
    if not _exists(found):
        return report
    word = str(found["word"].item())
    report.add("word", _word_text(word), word=word)
    length = found["length"].item()
    text, data = f"{length:.9g}", {"length": length}
    if "period" in attrs:
        text, data = f"{text}, period {attrs['period']}", data | {"order": attrs["period"]}
    report.add("length", text, **data)
    states = {str(name): found[name].item() for name in found["state"].values}
    text = ", ".join(f"{name} = {value:.10g}" for name, value in states.items())
    report.add("section point", text, section_point=states)
    report.number("at time", found["time"].item(), ".7g")
    for name in found["drift_state"].values if "drift_state" in found else ():
        rates = {f"{name}_per_{u}": found[f"{name}_per_{u}"].item() for u in ("period", "time")}
        per = zip(rates.values(), ("period", "time"), strict=True)
        text = ", ".join(f"{rate:.9g} per {unit}" for rate, unit in per)
        report.add(f"drift of {name}", text, **rates)
    if found["multipliers"].size:
        multipliers = found["multipliers"].values
        text = ", ".join(complex_text(mu) for mu in multipliers)
        report.add("multipliers", text, multipliers=multipliers)
    _add_nature(report, found)
    report.number("residual", found["residual"].item(), ".2g")
    _add_legs(report, found)
    return report


def _add_nature(report: Report, found: xr.Dataset) -> None:
    """Add stability, symmetry, repetition and admissibility."""
    stable, admissible = bool(found["stable"]), bool(found["admissible"])
    report.add("stable", "yes" if stable else "no", stable=stable)
    if "symmetric" in found:
        symmetric = bool(found["symmetric"])
        text = "yes" if symmetric else "no, its mirror image is another"
        report.add("symmetric", text, symmetric=symmetric)
    parts = int(found["primitive_parts"])
    if parts > 1:
        report.add("repeats", f"a shorter orbit {parts} times", primitive_parts=parts)
    text = "yes" if admissible else "no, no motion follows it"
    report.add("admissible", text, admissible=admissible)


def _word_text(word: str) -> str:
    """A word as it is read; of a long one the first modes and the number of legs."""
    modes = word.split()
    if len(modes) <= _MOST_MODES:
        return word
    return f"{' '.join(modes[:_MOST_MODES])} ... ({len(modes)} legs)"


def _add_legs(report: Report, found: xr.Dataset) -> None:
    """Add one line for each leg: its mode, when it begins, how long it takes, what ends it."""
    modes = found["leg_mode"].attrs.get("flag_meanings", "").split()
    columns: list[Column] = [
        ("leg", "leg", str),
        ("mode", "mode", str),
        ("from", "from", "{:.9g}".format),
        ("duration", "duration", "{:.9g}".format),
        ("until", "until", str),
    ]
    rows = []
    for k in range(found.sizes["leg"]):
        leg = found.isel(leg=k)
        code = int(leg["leg_mode"])
        times = float(leg["leg_time"]), float(leg["durations"])
        until = str(leg["leg_exit"].item()) or "section"
        rows.append((k, modes[code] if modes else str(code), *times, until))
    report.table("legs", columns, rows, _MOST_LEGS)


def follow(task: Task) -> None:
    """``nonsmooth continue``."""
    import nonsmooth as ns

    if task["multipliers"] and (task["draw"] or task["diagram"]):
        raise OptionError("--multipliers is a picture of its own: leave out --draw and --diagram")
    system = task.system
    parameter, between = _range(system, task["over"])
    drawn = _branch_variable(system, task["draw"])
    behind = _read_diagram(task, parameter, drawn)
    first = ns.find_orbit(system, **task.options("find_orbit"))
    if not _exists(first):
        report = _orbit_report(first)
        click.echo("there is no orbit to start from; see: nonsmooth orbit --help", err=True)
        task.save = task.plot = None
        task.finish(None, report, code=ENDED_EARLY)
    options = task.options("continue_orbit")
    branch = ns.continue_orbit(system, parameter, between, initial=first, **options)

    if task.plot is not None and not branch.sizes["point"]:
        click.echo("there is no branch to draw", err=True)
    elif task["multipliers"]:
        task.picture("multipliers", branch)
    else:
        task.picture("branch", branch, drawn, diagram=behind)
    report = _branch_report(branch)
    if task["criticality"]:
        _add_criticality(report, ns.criticality(branch), parameter)
    task.finish(branch, report, code=task.by_status(branch) or _code_of_ends(branch))


def _code_of_ends(branch: xr.Dataset) -> int:
    """Exit code of a branch: whether it has an orbit beside the first one, and ends of its own.

    Steps that are used up are as many as were asked for.
    """
    ends = {branch.attrs["end_first"], branch.attrs["end_last"]}
    return ENDED_EARLY if branch.sizes["point"] < 2 or ends & _NOT_FOLLOWED else 0


def _range(system: System, over: str) -> tuple[str, tuple[float, float]]:
    """Parameter and its ends; its own value lies between."""
    name, (low, high) = value_limits(over)
    if name not in system.parameters:
        raise OptionError(f"--over: {unknown_name('parameter', name, system.parameters)}")
    value_here = system.parameters[name]
    if isinstance(value_here, int | float) and not low <= value_here <= high:
        raise OptionError(
            f"--over: the orbit is found at {name} = {value_here:g}, which is not between {low:g}"
            f" and {high:g}; give another value of {name}, or another range"
        )
    return name, (low, high)


def _branch_variable(system: System, text: str | None) -> str:
    """What to draw: by default how fast the system drifts, or its first state."""
    drifts = [f"{name}_per_{unit}" for name in system.drift_states for unit in ("time", "period")]
    if text is None:
        return drifts[0] if drifts else first_state(system)
    if text in system.outputs:
        raise OptionError(
            f"--draw: {text!r} is an output, and the points of a branch hold states only; draw a"
            f" state, such as {system.states[0]}, or the output over a diagram: nonsmooth diagram"
            f" --draw {text}"
        )
    return single(text, [*system.states, *drifts, "length", "residual", "multipliers"])


def _read_diagram(task: Task, parameter: str, drawn: str) -> xr.Dataset | None:
    """The diagram to draw behind, which must fit the branch before the branch is followed."""
    text = task["diagram"]
    if text is None:
        return None
    from nonsmooth.plot.diagram_behind import check_diagram, check_origin

    found = saved_dataset(text, "--diagram", "nonsmooth diagram --save makes one")
    try:
        check_diagram(found, parameter, drawn)
        expected = {"system": task.system.to_toml(), "phase_of_period": task["phase"]}
        check_origin(found, expected, drawn)
    except OptionError as fault:
        raise OptionError(
            f"--diagram: {text!r} does not go with {drawn} over {parameter}: {fault}; make"
            " another one with nonsmooth diagram --save"
        ) from None
    return found


def _branch_report(branch: xr.Dataset) -> Report:
    """How far the branch goes, why no further, and of what kind its orbits are."""
    import numpy as np

    attrs = branch.attrs
    report = Report(attrs["system_name"])
    message, parameter = str(attrs["message"]), str(attrs["parameter"])
    report.add("status", message, status=attrs["status"], message=message)
    values = branch[parameter].values
    report.number("points", values.size)
    if not values.size:
        return report
    ends = [values.min(), values.max()]
    report.add(parameter, f"{ends[0]:.10g} to {ends[1]:.10g}", parameter=parameter, range=ends)
    for end, label, place in (("end_first", "first end", 0), ("end_last", "last end", -1)):
        text = f"{attrs[end]}, at {parameter} = {values[place]:.10g}"
        report.add(label, text, **{end: {"kind": attrs[end], "at": values[place]}})
    stable, admissible = (branch[name].values.astype(bool) for name in ("stable", "admissible"))
    kinds = {
        "stable": int(np.count_nonzero(stable & admissible)),
        "unstable": int(np.count_nonzero(~stable & admissible)),
        "inadmissible": int(np.count_nonzero(~admissible)),
    }
    report.add("orbits", ", ".join(f"{n} {kind}" for kind, n in kinds.items() if n), orbits=kinds)
    _add_special_points(report, branch, parameter)
    return report


def _add_special_points(report: Report, branch: xr.Dataset, parameter: str) -> None:
    """Add one line for each special point, in order along the branch."""
    columns: list[Column] = [
        ("special point", "kind", str),
        (parameter, "value", "{:.12g}".format),
        ("multiplier", "multiplier", complex_text),
        ("", "detail", str),
    ]
    rows = []
    for k in range(int(branch.sizes.get("special", 0))):
        one = branch.isel(special=k)
        kind = str(one["special_kind"].item()).replace("_", " ")
        multiplier = complex(one["special_multiplier"].item())
        detail = str(one["special_detail"].item())
        rows.append((kind, float(one["special_value"]), multiplier, detail))
    report.table("special points", columns, rows, _MOST_SPECIAL)


def _add_criticality(report: Report, found: xr.Dataset, parameter: str) -> None:
    """Add one line for each special point whose normal form is known."""
    columns: list[Column] = [
        ("normal form", "kind", str),
        (parameter, "value", "{:.12g}".format),
        ("criticality", "criticality", str),
        ("coefficient", "coefficient", "{:.6g}".format),
        ("error", "coefficient_error", "{:.1e}".format),
        ("", "detail", str),
    ]
    rows = []
    for k in range(found.sizes["special"]):
        one = found.isel(special=k)
        kind = str(one["special_kind"].item()).replace("_", " ")
        numbers = float(one["coefficient"]), float(one["coefficient_error"])
        told = str(one["criticality"].item()), *numbers, str(one["criticality_detail"].item())
        rows.append((kind, float(one["special_value"]), *told))
    report.table("normal forms", columns, rows, _MOST_SPECIAL)


def manifold(task: Task) -> None:
    """``nonsmooth manifold``."""
    import nonsmooth as ns

    system = task.system
    if task["draw"] and len(names(task["draw"], "--draw")) != 2:
        raise OptionError(f"--draw: {task['draw']!r} is not two states, such as x,v")
    drawn = chosen(task["draw"] or "", system.states, "--draw", kind="state")
    saddle = ns.find_orbit(system, **task.options("find_orbit"))
    if not _exists(saddle):
        raise OptionError(f"there is no orbit to begin with: {saddle.attrs['message']}")
    strobe = ns.StroboscopicMap(system, phase=task["phase"])
    options = task.options("manifold", "tolerance")
    found = ns.manifold(strobe, saddle, **options, tolerance=task["tolerance"])

    task.picture("manifold", found, *drawn)
    task.finish(found, _manifold_report(found), code=task.by_status(found))


def _manifold_report(found: xr.Dataset) -> Report:
    """What is known of the curves."""
    attrs = found.attrs
    report = Report(attrs["system_name"])
    report.add("status", attrs["message"], status=attrs["status"], message=attrs["message"])
    multipliers = found["multipliers"].values
    report.add("multipliers", ", ".join(map(complex_text, multipliers)), multipliers=multipliers)
    numbers = found["curve_of_point"].values
    rows = []
    for i in range(found.sizes["curve"]):
        one = found.isel(curve=i)
        here = numbers == i
        length = float(found["arclength"].values[here].max(initial=0.0))
        rows.append(
            (
                i, int(one["curve_orbit_point"]), int(one["curve_side"]), int(here.sum()), length,
                str(one["curve_end"].item()), float(one["first_deviation"]),
            )
        )  # fmt: skip
    columns: list[Column] = [
        ("", "curve", str),
        ("orbit point", "orbit_point", str),
        ("side", "side", "{:+d}".format),
        ("points", "points", str),
        ("length", "length", "{:.6g}".format),
        ("end", "end", str),
        ("deviation", "first_deviation", "{:.1e}".format),
    ]
    report.table("curves", columns, rows, len(rows))
    _add_borders(report, found)
    return report


def _add_borders(report: Report, found: xr.Dataset) -> None:
    """Add one line for each border of the curves."""
    names_of_states = [str(name) for name in found["state"].values]
    rows = []
    for i in range(found.sizes["at_border"]):
        point = found.isel(point=int(found["border_point"][i]))
        state = {name: float(point[name]) for name in names_of_states}
        kind, turn = str(found["border_kind"][i].item()), float(found["border_turn"][i])
        rows.append((int(point["curve_of_point"]), kind, state, turn))
    columns: list[Column] = [
        ("curve", "curve", str),
        ("border", "border", str),
        (
            f"at ({', '.join(names_of_states)})",
            "at",
            lambda state: ", ".join(f"{value:.9g}" for value in state.values()),
        ),
        ("turn", "turn", lambda turn: "" if turn != turn else f"{turn:.4g}"),
    ]
    if rows:
        report.table("borders", columns, rows, _MOST_BORDERS)


def crossings(task: Task) -> None:
    """``nonsmooth homoclinic``."""
    import nonsmooth as ns

    system = task.system
    saddle = ns.find_orbit(system, **task.options("find_orbit"))
    if not _exists(saddle):
        raise OptionError(f"there is no orbit to begin with: {saddle.attrs['message']}")
    other = None if task["to"] is None else ns.find_orbit(system, task["to"])
    if other is not None and not _exists(other):
        raise OptionError(f"--to: there is no orbit: {other.attrs['message']}")
    strobe = ns.StroboscopicMap(system, phase=task["phase"])
    options = task.options("homoclinic_points", "tolerance") | {"tolerance": task["tolerance"]}
    states = [name for name in system.states if name not in system.drift_states]
    report = Report(system.name)
    if task["over"] is None:
        found = ns.homoclinic_points(strobe, saddle, other, **options)
        task.picture("homoclinic_points", found)
        report.add("status", found.attrs["message"], status=found.attrs["status"])
        report.number("orbits", int(found.attrs["n_orbits"]))
        _add_points(report, found, states, "crossing", "crossing_angle", "angle")
    else:
        if task.plot is not None:
            raise OptionError("--plot draws crossings at one value: leave out --over")
        parameter, between = _range(system, task["over"])
        found = ns.homoclinic_tangency(strobe, parameter, between, saddle, other, **options)
        report.add("status", found.attrs["message"], status=found.attrs["status"])
        report.add("crossings", found.attrs["crossings"], crossings=found.attrs["crossings"])
        _add_points(report, found, states, "tangency", parameter, parameter)
    any_found = found.sizes["crossing" if task["over"] is None else "tangency"] > 0
    task.finish(found, report, code=task.by_status(found) or (0 if any_found else ENDED_EARLY))


def _add_points(
    report: Report, found: xr.Dataset, states: list[str], dim: str, value: str, label: str
) -> None:
    """Add one line for each point in which manifolds cross or touch."""
    rows = []
    for k in range(found.sizes[dim]):
        one = found.isel({dim: k})
        point = {name: float(one[name]) for name in states}
        rows.append((float(one[value]), point, int(one["images"]), int(one["ahead"])))
    columns: list[Column] = [
        (label, value, "{:.12g}".format),
        (
            f"({', '.join(states)})",
            "point",
            lambda point: ", ".join(f"{each:.10g}" for each in point.values()),
        ),
        ("images", "images", str),
        ("ahead", "ahead", str),
    ]
    report.table("points", columns, rows, _MOST_BORDERS)
