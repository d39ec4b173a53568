"""The chapter's figures and claims, recomputed with public functions only.

Whatever is heavy is imported when a figure or a claim is asked for.
"""

from __future__ import annotations

from nonsmooth.chapter.claims import claim_ids, evaluate_claims
from nonsmooth.chapter.demo import run_demo
from nonsmooth.chapter.registry import draw_figure, figure_ids, figure_summary, run_figures
from nonsmooth.chapter.run_chapter import run_chapter

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
