"""What a view asks of the library: calls of public verbs, which run here and print as scripts.

A page, a script and a command made from one view therefore give the same digits.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nonsmooth.errors import RunWarning
from nonsmooth.explorer.view import View

__all__ = [
    "EvenValues",
    "Result",
    "VerbCall",
    "basins",
    "branch",
    "computed",
    "diagram",
    "map_of",
    "motion",
    "orbit",
    "points",
]

_SAMPLES = 200  # of a shown motion in a period, where that makes no more than
_MOST_SAMPLES = 2_400  # of a motion: a pane is some hundred pixels wide
_POINTS = 2_000  # of a section
_STARTS, _LONGEST, _RECORD = 200, 1_000, 2_000  # of basins: less than the defaults, and quick
_STEPS = 300  # of a branch
_NEAR = 0.02  # of a value: how far a branch reaches at least


@dataclass(frozen=True)
class EvenValues:
    """Equidistant values, as `numpy.linspace` makes them."""

    first: float
    last: float
    count: int

    def values(self) -> np.ndarray:
        """The numbers."""
        return np.linspace(self.first, self.last, self.count)


@dataclass(frozen=True)
class Result:
    """Result of an earlier call, by its name."""

    name: str


@dataclass(frozen=True)
class VerbCall:
    """A verb of the library with its arguments; ``name`` is what a script calls the result."""

    name: str
    verb: str
    arguments: tuple[Any, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)

    def run(self, results: Mapping[str, Any], **changed: Any) -> Any:
        """Result of the verb; some options may be changed."""
        import nonsmooth

        given = [_meant(value, results) for value in self.arguments]
        options = {key: _meant(value, results) for key, value in self.options.items()}
        return getattr(nonsmooth, self.verb)(*given, **options | changed)


def computed(made: list[VerbCall], known: Mapping[str, Any], **changed: Any) -> dict[str, Any]:
    """Results of some calls beside known ones; a run that ends early says so in its message."""
    results = dict(known)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)
        for call in made:
            more = changed if call.verb == "simulate" else {}
            results[call.name] = call.run(results, **more)
    return results


def _meant(value: Any, results: Mapping[str, Any]) -> Any:
    if isinstance(value, EvenValues):
        return value.values()
    if isinstance(value, Result):
        return results[value.name]
    if isinstance(value, dict):
        return {key: _meant(item, results) for key, item in value.items()}
    return value


def _start(view: View) -> tuple[Any, ...]:
    return (Result("system"), *([dict(view.initial)] if view.initial else []))


def motion(view: View) -> list[VerbCall]:
    """The motion shown, and before it the part that is left out."""
    periodic = view.system.period is not None
    calls = []
    if view.leave_out:
        length = {"periods": view.leave_out} if periodic else {"t_end": view.leave_out}
        options = {**length, "samples_per_period": 2, "events": False}
        calls.append(VerbCall("settled", "simulate", _start(view), options))
    start = (Result("system"), Result("settled")) if view.leave_out else _start(view)
    if periodic:
        fitting = int(min(_SAMPLES, max(20, _MOST_SAMPLES / view.length)))
        options = {"periods": view.length, "samples_per_period": fitting}
    else:
        options = {"t_end": view.leave_out + view.length}
    calls.append(VerbCall("run", "simulate", start, options))
    return calls


def map_of(view: View) -> list[VerbCall]:
    """The map whose iterates are counted, where it is not that of the strobes."""
    if not view.section:
        return []
    return [VerbCall("section", "PoincareMap", (Result("system"), view.section))]


def _mapped(view: View) -> Result:
    return Result("section" if view.section else "system")


def diagram(view: View, columns: int | None = None) -> list[VerbCall]:
    """The bifurcation diagram."""
    first, last = view.between
    values = EvenValues(first, last, columns or view.columns)
    options: dict[str, Any] = {} if view.start == "restart" else {"start": view.start}
    options |= {"initial": dict(view.initial)} if view.initial else {}
    options |= {"transient": view.transient, "record": view.record}
    call = VerbCall("diagram", "bifurcation_diagram", (_mapped(view), view.over, values), options)
    return [*map_of(view), call]


def basins(view: View, cells: int | None = None) -> list[VerbCall]:
    """The basins on the region of a view."""
    left, right, low, high = view.region
    count = cells or view.cells
    region = {
        view.plane[0]: EvenValues(left, right, count),
        view.plane[1]: EvenValues(low, high, count),
    }
    options = {"samples": _STARTS, "longest": _LONGEST, "record": _RECORD}
    return [
        *map_of(view),
        VerbCall("basins", "basins_of_attraction", (_mapped(view), region), options),
    ]


def points(view: View) -> list[VerbCall]:
    """Points of the motion on the section."""
    options: dict[str, Any] = {"transient": view.transient, "record": _POINTS}
    if not view.section:
        return [VerbCall("points", "stroboscopic_map", _start(view), options)]
    options["section"] = view.section
    return [VerbCall("points", "poincare_section", _start(view), options)]


def orbit(view: View) -> list[VerbCall]:
    """The periodic orbit near the end of the motion shown."""
    return [
        VerbCall("orbit", "find_orbit", (Result("system"), Result("run")), {"period": view.turn})
    ]


def branch(view: View) -> list[VerbCall]:
    """The branch of that orbit over the parameter of the diagram."""
    value = view.system.parameter_values[view.over]
    first, last = sorted(view.between)  # a diagram may go downwards
    reach = _NEAR * (last - first)
    between = (min(first, value - reach), max(last, value + reach))
    options = {"initial": Result("orbit"), "steps": _STEPS}
    return [VerbCall("branch", "continue_orbit", (Result("system"), view.over, between), options)]
