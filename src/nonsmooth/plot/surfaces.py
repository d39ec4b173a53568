"""Where the guards of a system vanish, in the plane of two of its states."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError
from nonsmooth.system.algebra.linear import CONSTANT, LinearForm, State
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import evaluate
from nonsmooth.system.text.expressions import Expression, name_set

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["draw_surfaces"]

_POINTS = 201  # per side; a circle of this many pieces looks round
_SAME = 1e-9  # of two guards that differ by a factor

Plane = npt.NDArray[np.float64]


def draw_surfaces(run: xr.Dataset, x: str, y: str, ax: Axes) -> None:
    """Dashed lines, within the range drawn so far, where guards of x and y alone vanish."""
    if "system" not in run.attrs:
        raise OptionError(
            "surfaces=True: the run does not say of which system it is, as one in other units does"
            " not; draw the run as it came from simulate"
        )
    system = System.from_toml(run.attrs["system"])
    if not {x, y} <= set(system.states) or x == y:
        return
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    xs, ys = np.linspace(left, right, _POINTS), np.linspace(low, high, _POINTS)
    across, up = np.meshgrid(xs, ys)
    found: list[Plane] = []
    for guard in _guards(system, x, y, across, up):
        size = np.abs(guard).max()
        if not np.isfinite(size) or guard.min() * guard.max() >= 0.0:
            continue
        shape = guard / size
        # both modes beside a surface have a guard that vanishes there
        if not any(min(abs(shape - g).max(), abs(shape + g).max()) < _SAME for g in found):
            found.append(shape)
            ax.contour(
                xs,
                ys,
                shape,
                levels=[0.0],
                colors="0.45",
                linestyles="--",
                linewidths=0.7,
                zorder=1,
            )
    ax.set_xlim(left, right)
    ax.set_ylim(low, high)


def _guards(system: System, x: str, y: str, across: Plane, up: Plane) -> Iterator[Plane]:
    """Values of the guards that depend on these two states and on parameters."""
    values: dict[str, float | Plane] = {**system.parameter_values, x: across, y: up}
    for mode in system.structure.running:
        forms = mode.taylor or mode.linear
        assert forms is not None
        for way in forms.exits:
            names = _names(way.guard)
            if names <= set(values) | {"pi"} and names & {x, y}:
                yield np.broadcast_to(_value(way.guard, values), across.shape)


def _names(guard: LinearForm | Expression) -> set[str]:
    """Names in a guard, ``t`` for whatever depends on time."""
    if not isinstance(guard, LinearForm):
        return name_set(guard)
    names: set[str] = set()
    for basis, coefficient in guard.terms.items():
        names |= name_set(coefficient)
        if isinstance(basis, State):
            names.add(basis.name)
        elif basis != CONSTANT:
            names.add("t")
    return names


def _value(guard: LinearForm | Expression, values: dict[str, float | Plane]) -> Plane:
    if not isinstance(guard, LinearForm):
        return np.asarray(evaluate(guard, values), dtype=float)
    total = np.zeros(())
    for basis, coefficient in guard.terms.items():
        factor = values[basis.name] if isinstance(basis, State) else 1.0
        total = total + evaluate(coefficient, values) * factor
    return total
