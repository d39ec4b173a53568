"""A bifurcation diagram behind a branch: whether it belongs there, and its dots."""

from __future__ import annotations

import math
import tomllib
import warnings
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import OptionError, ResultWarning, unknown_name
from nonsmooth.plot.trace import DENSE

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes


__all__ = ["check_diagram", "check_origin", "draw_diagram", "warn_of_other_parameters"]

_DOTS, _LABEL = "0.6", "brute force"  # the grey of the dots, and their name in the legend
_MANY = 3_000  # dots that are drawn small
_WORDS = ("name", "describe", "parameters")  # keys of a system that say nothing of its equations
_SAME_PHASE = 1e-9  # of a period
_MOST_NAMED = 5  # parameters that differ


def check_diagram(diagram: xr.Dataset, parameter: str, y: str, x: str | None = None) -> None:
    """Refuse what cannot be drawn behind y of a branch over a parameter."""
    if "parameter" not in diagram.dims or "lane" not in diagram.dims:
        raise OptionError(
            "diagram: the dataset has no dimensions 'parameter' and 'lane'; give a result of"
            " bifurcation_diagram"
        )
    over = str(diagram.attrs.get("parameter", parameter))
    if over != parameter or x not in (None, parameter):
        raise OptionError(
            f"diagram: it is over {over!r} and the branch is drawn over {x or parameter!r}; draw"
            " both over the same parameter"
        )
    known = [str(name) for name, values in diagram.data_vars.items() if values.dtype.kind in "fi"]
    if y not in known:
        raise OptionError(f"diagram: {unknown_name('variable', y, known)}")


def check_origin(diagram: xr.Dataset, branch: Mapping[str, Any], y: str) -> None:
    """Refuse a diagram of another system than the branch, or with other points.

    branch: attributes of the branch. What either does not tell, as a diagram of measured motions,
    is not compared.
    """
    ours, theirs = (_system(attrs) for attrs in (branch, diagram.attrs))
    if not ours or not theirs:
        return
    if _equations(ours) != _equations(theirs):
        name, other = ours.get("name", ""), theirs.get("name", "")
        raise OptionError(
            f"diagram: it is of {other!r} and the branch of {name!r}, which are systems with"
            " different equations; give a diagram of the system of the branch"
        )
    phase = branch.get("phase_of_period")
    # without forcing an orbit begins at one of its events, wherever the points of a section lie
    if phase is None or "period" not in ours or "point" not in diagram[y].dims:
        return
    seen = _points(diagram.attrs)
    if seen is None:
        return
    where, of_diagram = seen
    apart = None if of_diagram is None else abs(of_diagram - phase)
    # a phase just below 1 is one just below 0
    if apart is None or min(apart, 1.0 - apart) > _SAME_PHASE:
        raise OptionError(
            f"diagram: its points are {where}, and those of the branch are strobes at the phase"
            f" {phase:g}; give a diagram of such strobes, or draw a variable that is the same at"
            " all points, such as a drift"
        )


def _system(attrs: Mapping[str, Any]) -> dict[str, Any]:
    text = attrs.get("system")
    return tomllib.loads(text) if isinstance(text, str) else {}


def _equations(system: Mapping[str, Any]) -> dict[str, Any]:
    """What a system is but for the values of its parameters and for words."""
    found = {key: value for key, value in system.items() if key not in _WORDS}
    return found | {"parameters": sorted(system.get("parameters", ()))}


def _points(attrs: Mapping[str, Any]) -> tuple[str, float | None] | None:
    """Where points of a diagram are taken, and their phase where they are strobes."""
    if "section" in attrs:
        return f"on the section {attrs['section']!r}", None
    if attrs.get("at", "strobe") != "strobe":
        return f"states at {attrs['at']!r}", None
    if "phase_of_period" not in attrs:
        return None
    phase = float(attrs["phase_of_period"])
    return f"strobes at the phase {phase:g}", phase


def warn_of_other_parameters(diagram: xr.Dataset, branches: Iterable[xr.Dataset]) -> None:
    """Warn where a diagram is of other values of parameters than a branch, over neither."""
    theirs = _system(diagram.attrs).get("parameters", {})
    told: dict[str, str] = {}
    for branch in branches:
        ours = _system(branch.attrs).get("parameters", {})
        for name in ours.keys() & theirs.keys() - {branch.attrs.get("parameter")}:
            if not _same(ours[name], theirs[name]):
                told.setdefault(name, f"{name} = {theirs[name]} and {ours[name]}")
    if not told:
        return
    named = [told[name] for name in sorted(told)]
    more = f" and {len(named) - _MOST_NAMED} more" if len(named) > _MOST_NAMED else ""
    warnings.warn(
        "diagram: values of parameters differ from those of the branch, so that its motions need"
        f" not be those of the branch: {', '.join(named[:_MOST_NAMED])}{more} (the diagram first)",
        ResultWarning,
        stacklevel=4,
    )


def _same(one: Any, other: Any) -> bool:
    """Whether two values are equal; numbers to rounding."""
    if isinstance(one, int | float) and isinstance(other, int | float):
        return math.isclose(one, other, rel_tol=1e-12)
    return bool(one == other)


def draw_diagram(diagram: xr.Dataset, y: str, ax: Axes) -> None:
    """Points of a diagram as grey dots behind all else."""
    values = diagram[y].transpose("parameter", ...).values
    values = values.reshape(len(values), -1).astype(float)
    here = np.broadcast_to(diagram["parameter"].values[:, None], values.shape)
    shown = np.isfinite(values)
    few = np.count_nonzero(shown) <= _MANY
    ax.plot(
        here[shown], values[shown], linestyle="none", marker=".", color=_DOTS,
        markersize=3.0 if few else 1.5, markeredgewidth=0.0, zorder=1,
        rasterized=np.count_nonzero(shown) > DENSE, label=_LABEL, gid="diagram",
    )  # fmt: skip
