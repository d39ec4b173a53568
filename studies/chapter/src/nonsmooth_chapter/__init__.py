"""The chapter's figures and claims, recomputed with public functions only.

Whatever is heavy is imported when a figure or a claim is asked for.
"""

from __future__ import annotations

from nonsmooth_chapter.claims import claim_ids, evaluate_claims
from nonsmooth_chapter.demo import run_demo
from nonsmooth_chapter.registry import draw_figure, figure_ids, figure_summary, run_figures
from nonsmooth_chapter.run_chapter import run_chapter

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
