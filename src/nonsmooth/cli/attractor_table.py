"""The attractors of a result as a table."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from nonsmooth.cli.console import ENDED_EARLY, INTERRUPTED, print_table

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["exit_code", "print_attractors"]

_HEADS = ("", "kind", "period", "share", "multiplier", "exponent", "word")
_MOST = 40  # attractors that are printed
_LONGEST = 36  # letters of a word; those of long cycles are in the file


def print_attractors(result: xr.Dataset) -> None:
    """Print one line for each attractor; nothing where there is none."""
    import numpy as np

    count = result.sizes["attractor"]
    rows = []
    for i in range(min(count, _MOST)):
        one = result.isel(attractor=i)
        sizes = np.hypot(one["multiplier_real"].values, one["multiplier_imag"].values)
        cycle = int(one["period"]) > 0
        rows.append(
            (
                str(int(one["attractor"])),
                str(one["kind"].item()),
                str(int(one["period"])) if cycle else "",
                with_error(float(one["fraction"]), float(one["fraction_error"])),
                f"{sizes.max(initial=0.0):.4g}" if cycle else "",
                "" if cycle else with_error(float(one["exponent"]), float(one["exponent_error"])),
                _short(str(one["word"].item())),
            )
        )
    if rows:
        print_table(_HEADS, rows)
    if count > _MOST:
        print_table(("",), [(f"and {count - _MOST} more",)])


def with_error(value: float, error: float) -> str:
    """A number with its standard error where it has one."""
    return f"{value:.4g} +- {error:.1g}" if 0.0 < error < math.inf else f"{value:.4g}"


def _short(word: str) -> str:
    from nonsmooth.system.columns import harmless  # names come from files

    word = harmless(word)
    return word if len(word) <= _LONGEST else word[: _LONGEST - 4] + " ..."


def exit_code(result: xr.Dataset) -> int:
    """Code of a search that was interrupted, or left starts unsettled; files are written then."""
    if result.attrs["status"] == "interrupted":
        return INTERRUPTED
    return 0 if result.attrs["message"] == "completed" else ENDED_EARLY
