"""Which parameters of a run vary slowly."""

from __future__ import annotations

import xarray as xr

__all__ = ["slow_names"]


def slow_names(run: xr.Dataset) -> list[str]:
    """Names of the slow parameters of a run."""
    texts = str(run.attrs.get("slow_values", "")).split()
    return [name for name in (text.partition("=")[0] for text in texts) if name in run]
