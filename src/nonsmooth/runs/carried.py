"""Parameters that a point of a result belongs to, beside those of the system that starts there."""

from __future__ import annotations

from typing import Any

from nonsmooth.errors import OptionError
from nonsmooth.runs.labels import labels_of
from nonsmooth.system.system import System

__all__ = ["refuse_other_parameters"]

_TIMES = {"time", "phase", "period_number"}  # coordinates of any result


def refuse_other_parameters(system: System, data: Any, what: str) -> None:
    """Refuse a point, or a run, that belongs to other parameters than those of the system."""
    known = system.parameter_values
    other = {name: value for name, value in _carried(system, data).items() if value != known[name]}
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
