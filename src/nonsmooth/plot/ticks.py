"""Numbers along the axes that do not touch each other, and powers of ten in the labels.

matplotlib is imported with this module: import it where something is drawn.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from matplotlib.ticker import AutoLocator, MaxNLocator, ScalarFormatter

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

__all__ = ["set_numbers"]

_POWERS = (-3, 6)  # from these on numbers are written with a power of ten
_LETTER, _GAP = 0.64, 0.7  # width of a digit and least distance of numbers, in letters
_STEPS = (1, 2, 2.5, 5, 10)


def set_numbers(ax: Axes) -> None:
    """Let the numbers along both axes be legible at any size and in any units."""
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter(_PowerInLabel())
    ax.xaxis.set_major_locator(_FittingLocator())


class _PowerInLabel(ScalarFormatter):
    """Numbers whose power of ten stands in the label of the axis: ``displacement [10⁻⁶ m]``.

    At the end of the axis, where matplotlib has it, it would meet the label or the legend. Axes of
    equal scales have one power, that of the larger numbers: lengths along both are compared.
    """

    def __init__(self) -> None:
        super().__init__(useOffset=False)
        self.set_powerlimits(_POWERS)
        self._written: dict[Axis, tuple[str, str]] = {}  # labels without the power and with it

    def set_locs(self, locs: Any) -> None:
        """Choose the power for some numbers, and write it into the labels of the axis."""
        power = self._common_power()
        self.set_scientific(power != 0)  # powers from 0 to 0 would let each axis choose its own
        self.set_powerlimits(_POWERS if power is None else (power, power))
        super().set_locs(locs)
        for axis in self._labelled():
            text = axis.label.get_text()
            bare, written = self._written.get(axis, ("", None))
            bare = bare if text == written else text
            self._written[axis] = bare, _with_power(bare, super().get_offset())
            axis.label.set_text(self._written[axis][1])

    def get_offset(self) -> str:
        """What stands at the end of the axis: the power, where there is no label to hold it."""
        return "" if self._labelled() else super().get_offset()

    def _common_power(self) -> int | None:
        """Power of ten for both axes, where their scales are equal."""
        axes = getattr(self.axis, "axes", None)
        if axes is None or axes.get_aspect() != 1.0:
            return None
        largest = float(np.abs([axes.get_xlim(), axes.get_ylim()]).max())
        power = math.floor(math.log10(largest)) if 0.0 < largest < math.inf else 0
        return power if power <= _POWERS[0] or power >= _POWERS[1] else 0

    def _labelled(self) -> list[Axis]:
        """Axes with these numbers that have a label."""
        own: Any = self.axis
        name = getattr(own, "axis_name", "")
        if name not in ("x", "y"):
            return []
        shared = getattr(own.axes, f"get_shared_{name}_axes")().get_siblings(own.axes)
        found = [getattr(each, f"{name}axis") for each in shared]
        return [axis for axis in found if axis.major is own.major and axis.label.get_text()]


def _with_power(label: str, offset: str) -> str:
    """Label with the power of ten of an axis, such as ``1e-6``, before its units."""
    if not offset:
        return label
    power = offset.replace("\N{MINUS SIGN}", "-").partition("e")[2]
    factor = f"$10^{{{int(power)}}}$"
    if label.endswith("]") and "[" in label:
        start, _, units = label.rpartition("[")
        return f"{start}[{factor} {units}"
    return f"{label} [{factor}]"


class _FittingLocator(AutoLocator):
    """Round numbers along an axis, so few that they do not touch."""

    def tick_values(self, vmin: float, vmax: float) -> Sequence[float]:
        """Numbers from the one end of an axis to the other."""
        ticks = super().tick_values(vmin, vmax)
        for bins in range(min(len(ticks), 10) - 1, 0, -1):
            if self._fit(np.asarray(ticks), vmin, vmax):
                return ticks
            ticks = MaxNLocator(bins, steps=_STEPS).tick_values(vmin, vmax)
        # matplotlib gives two or three numbers at least, for which a small axis may have no room
        shown = np.asarray([each for each in ticks if vmin <= each <= vmax])
        for some in (shown, shown[:: max(shown.size - 1, 1)], shown[shown.size // 2 :][:1]):
            if self._fit(some, vmin, vmax):
                return list(some)
        return ticks

    def _fit(self, ticks: npt.NDArray[np.float64], vmin: float, vmax: float) -> bool:
        axis: Any = self.axis
        formatter = axis.get_major_formatter() if hasattr(axis, "get_major_formatter") else None
        shown = ticks[(ticks >= vmin) & (ticks <= vmax)]
        if not isinstance(formatter, ScalarFormatter) or shown.size < 2 or vmax == vmin:
            return True
        size = float(axis.get_tick_params().get("labelsize", axis.label.get_fontsize()))
        texts = [
            re.sub(r"[^\d.,\N{MINUS SIGN}-]", "", t) for t in formatter.format_ticks(shown.tolist())
        ]
        widths = size * _LETTER * np.array([len(text) for text in texts])
        figure = axis.get_figure(root=True)
        length = axis.axes.get_window_extent().width / figure.dpi * 72.0
        distance = np.diff(shown) / abs(vmax - vmin) * length
        return bool(np.all(0.5 * (widths[1:] + widths[:-1]) + _GAP * size <= distance))
