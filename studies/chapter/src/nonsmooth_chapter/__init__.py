"""Figures and claims of a chapter on non-smooth dynamics, computed anew with `nonsmooth`.

Names are imported when first used, so that the help of the command comes at once.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from nonsmooth_chapter.claims import claim_ids
    from nonsmooth_chapter.demo import run_demo
    from nonsmooth_chapter.figures import draw_figure, figure_ids, figure_summary, run_figures
    from nonsmooth_chapter.whole_chapter import evaluate_claims, run_chapter

__all__ = [
    "claim_ids",
    "draw_figure",
    "evaluate_claims",
    "figure_ids",
    "figure_summary",
    "run_chapter",
    "run_demo",
    "run_figures",
]

_HOME = {
    "claim_ids": "claims",
    "draw_figure": "figures",
    "evaluate_claims": "whole_chapter",
    "figure_ids": "figures",
    "figure_summary": "figures",
    "run_chapter": "whole_chapter",
    "run_demo": "demo",
    "run_figures": "figures",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'nonsmooth_chapter' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"nonsmooth_chapter.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
