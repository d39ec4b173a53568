"""Commands that tell what motions settle to."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.cli.arguments import need_period, value_range
from nonsmooth.cli.command import Task
from nonsmooth.cli.report import Report
from nonsmooth.cli.runs import certified
from nonsmooth.cli.sweeps import certified_runs
from nonsmooth.errors import OptionError
from nonsmooth.system.columns import with_error

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

__all__ = ["need_strobes", "regime", "regimes", "two_parameters"]


def regime(task: Task) -> None:
    """``nonsmooth regime``."""
    from nonsmooth.analysis.regime import regime as judge

    need_strobes(task)
    found = judge(task.system, **task.options("regime"))
    task.finish(found, _regime_report(found))


def need_strobes(task: Task) -> None:
    """Refuse a system without a period, unless it is said when to look."""
    if task["period"] is None:
        need_period(task.system, "give the time between two looks at it by --period, such as 1")


def _regime_report(found: xr.Dataset) -> Report:
    """The label and what is known beside it."""
    report = Report(found.attrs["system_name"])
    message = str(found.attrs["message"])
    report.add("regime", message, regime=found["regime"].item(), message=message)
    period, length = found["period"].item(), found.attrs["strobe_period"]
    if period:
        report.add("period", f"{period} of {length:.7g}", period=period, strobe_period=length)
        report.add("word", found["word"].item())
    for name in ("events", "impacts"):
        if (value := found[name].item()) == value:
            report.add(name, f"{value:.6g} per period", **{f"{name}_per_period": value})
    for variable in map(str, found.data_vars):
        if variable.endswith("_per_period"):
            value, drift = found[variable].item(), variable.removesuffix("_per_period")
            report.add(f"drift of {drift}", f"{value:.7g} per period", **{variable: value})
    moduli = [value for value in found["multiplier_modulus"].values if value == value]
    if moduli:
        text = ", ".join(f"{value:.6g}" for value in moduli)
        report.add("multipliers", text, multiplier_modulus=moduli)
    exponent, error = found["exponent"].item(), found["exponent_error"].item()
    if exponent == exponent:
        text = with_error(exponent, error, 6, 2)
        report.add("exponent", f"{text} per unit time", exponent=exponent, exponent_error=error)
    if chaotic_for := found["chaotic_for"].item():  # the message tells it in words
        report.data["chaotic_for"] = chaotic_for
        report.data["escape_rate_below"] = found["escape_rate_below"].item()
    certified(report, found["n_uncertain"].item(), found["n_estimated"].item())
    used = found["transient_used"].item()
    report.add("transient", f"{used} periods", transient=used)
    return report


def regimes(task: Task) -> None:
    """``nonsmooth regimes``."""
    from nonsmooth.analysis.regime_map import regime_map

    need_strobes(task)
    over = two_parameters(task["over"])
    task.refuse_fixed(over, "--over")
    result = regime_map(task.system, over, **task.options("regime_map"))

    task.picture("regime_map", result)
    task.finish(result, _map_report(result), code=task.by_status(result))


def two_parameters(over: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Both parameters with their values."""
    pairs = [value_range(text) for text in over]
    if len(pairs) != 2 or pairs[0][0] == pairs[1][0]:
        given = ", ".join(name for name, _ in pairs)
        raise OptionError(
            f"--over: {given} given; give it twice, for two different parameters, such as --over"
            " omega=0.5:1:40 --over zeta=0.01:0.1:20"
        )
    return dict(pairs)


def _map_report(result: xr.Dataset) -> Report:
    """How large the map is, and how many points have each label."""
    import numpy as np

    sizes, (second, first) = result.sizes, map(str, result["regime"].dims)
    words = result["regime"].attrs["flag_meanings"].split()
    computed, points = int(result["computed"].sum()), result["regime"].size
    report = Report(result.attrs["system_name"])
    text = f"{sizes[first]} of {first} times {sizes[second]} of {second}"
    report.add("points", text, points={first: sizes[first], second: sizes[second]})
    report.add("computed", f"{computed} of {points}", computed=computed)
    codes, counts = np.unique(result["regime"].values, return_counts=True)
    labels = {words[code]: int(n) for code, n in zip(codes, counts, strict=True)}
    for word, n in labels.items():
        report.add(word, f"{n}", regimes=labels)
    certified_runs(report, result)
    return report
