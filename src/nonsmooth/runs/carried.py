"""Parameters that a point of a result belongs to, beside those of the system that starts there."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from nonsmooth.errors import OptionError
from nonsmooth.runs.labels import labels_of
from nonsmooth.system.system import System

__all__ = ["check_carried", "refuse_other_parameters"]

_TIMES = {"time", "phase", "period_number"}  # coordinates of any result


def check_carried(
    system: System,
    initial: Any,
    parameters: Mapping[str, Any] | None,
    swept: Collection[str] = (),
) -> None:
    """Refuse an initial point or run of other parameters, unless ``parameters`` were given anew.

    Those that are ``swept`` differ from run to run, whatever the start.
    """
    if parameters is None and hasattr(initial, "data_vars"):
        what = "run" if "time" in initial.dims else "point"
        refuse_other_parameters(system, initial, what, swept)


def refuse_other_parameters(
    system: System, data: Any, what: str, swept: Collection[str] = ()
) -> None:
    """Refuse a point, or a run, that belongs to other parameters than those of the system."""
    known = system.parameter_values
    other = {
        name: value
        for name, value in _carried(system, data).items()
        if name not in swept and value != known[name]
    }
    if not other:
        return
    raise OptionError(
        f"initial: the {what} belongs to parameters={other}, and the system has"
        f" {', '.join(f'{name} = {known[name]:.9g}' for name in other)}; repeat parameters=, or"
        " pass parameters={} for the system's own"
    )


def _carried(system: System, data: Any) -> dict[str, float]:
    """Parameters of the system that a result was made with, where it tells that they changed."""
    names = [name for name in system.parameters if name not in system.slow]
    found: dict[str, float] = {}
    text = data.attrs.get("system", "")
    if data.attrs.get("changed_parameters") and text and text != labels_of(system).system:
        values = System.from_toml(text).parameter_values
        found |= {name: values[name] for name in names if name in values}
    told = {name: data.coords[name] for name in names if name in set(data.coords) - _TIMES}
    swept = data.attrs.get("parameter")  # of a diagram or a branch
    if swept in names and (swept in data.variables or "parameter" in data.coords):
        told[swept] = data[swept if swept in data.variables else "parameter"]
    return found | {name: float(each) for name, each in told.items() if each.ndim == 0}
