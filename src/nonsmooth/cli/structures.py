"""The command for shafts and frames that are given by their matrices."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from nonsmooth.cli.arguments import value_range
from nonsmooth.cli.command import Task
from nonsmooth.cli.report import Report
from nonsmooth.errors import OptionError

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

__all__ = ["campbell", "speed_range"]

_MOST_TOLD = 30  # critical speeds
_ROUNDING = 1e-9  # of an eigenvalue: growth that is none
_RPM = 30.0 / math.pi


def campbell(task: Task) -> None:
    """``nonsmooth campbell``."""
    from nonsmooth import structures

    structure = structures.Structure.from_files(task["shaft"], units=task["units"])
    scale = 1.0 / _RPM if task["rpm"] else 1.0
    result = structures.campbell(
        structure, task["speeds"] * scale, **task.options("structures.campbell")
    )
    task.picture("campbell", result, units="rpm" if task["rpm"] else "rad/s")
    report = Report(task["shaft"])
    report.add("coordinates", f"{structure.size}", coordinates=structure.size)
    report.add("modes", f"{result.sizes['mode']}", modes=result.sizes["mode"])
    unstable = _unstable_from(result)
    if unstable is not None:
        unit = "rpm" if task["rpm"] else "rad/s"
        report.add(
            "unstable", f"a mode grows, first at {unstable / scale:.6g} {unit}", unstable=unstable
        )
    _add_critical_speeds(report, result)
    task.finish(result, report)


def _unstable_from(result: xr.Dataset) -> float | None:
    """The least speed of the grid at which a mode grows by more than rounding."""
    values = result["eigenvalue"].values
    grows = (values.real > _ROUNDING * abs(values)).any(axis=1)
    return float(result["speed"].values[grows.argmax()]) if grows.any() else None


def _add_critical_speeds(report: Report, result: xr.Dataset) -> None:
    columns: list[Any] = [
        ("rad/s", "speed", "{:.8g}".format),
        ("rpm", "rpm", "{:.8g}".format),
        ("order", "harmonic", "{:g}".format),
        ("mode", "mode", str),
        ("damping ratio", "damping_ratio", "{:.3g}".format),
        ("amplification", "amplification", "{:.3g}".format),
        ("whirl", "direction", str),
    ]
    names = ("speed", "harmonic", "mode", "damping_ratio", "amplification", "direction")
    found = zip(*(result[f"critical_{name}"].values.tolist() for name in names), strict=True)
    rows = [(speed, speed * _RPM, *others) for speed, *others in found]
    report.table("critical speeds", columns, rows, _MOST_TOLD)


def speed_range(text: str, option: str) -> np.ndarray:
    """Speeds of ``first:last:count``."""
    try:
        return value_range(f"speed={text}")[1]
    except OptionError as error:
        said = str(error).replace("--over", option).replace("'speed=", "'").replace("name=", "")
        raise OptionError(said) from None
