"""Which figures and claims are computed one after the other, as they share what they need."""

from __future__ import annotations

from collections.abc import Sequence

from nonsmooth.chapter.claim_modules import CLAIM_MODULES
from nonsmooth.chapter.items import Item
from nonsmooth.chapter.registry import figure_place, figure_summary

__all__ = ["TOGETHER", "groups_of"]

# Modules of claims and names of figures, those that take longest first; all others are short.
TOGETHER = (
    ("mole.basin_claims",),
    ("fig12",),
    ("rotor.bifurcation_claims", "fig36"),
    ("rotor.rig_diagram_claims", "rotor.rig_regime_claims", "fig40", "fig41"),
    ("rotor.preload_claims",),
    ("mole.window_claims", "mole.cascade_claims", "mole.progression_claims", "fig8"),
    (
        "mole.orbit_claims",
        "mole.branch_claims",
        "mole.best_ratio_claims",
        "mole.frequency_claims",
        "fig10",
    ),
    (
        "fatigue.growing_claims",
        "fatigue.growth_claims",
        "fatigue.regime_claims",
        "fatigue.frozen_claims",
        "fatigue.monitoring_claims",
        "fig30",
    ),
    ("fatigue.chaos_claims", "fig21", "fig22"),
    ("fatigue.portrait_claims", "fig28"),
    ("rotor.section_claims",),
)


def groups_of(figures: Sequence[str], claims: Sequence[str]) -> list[list[Item]]:
    """Items of some figures and claims in groups, in the order in which they begin.

    Figures come first, the shortest ones at once, so that there is soon something to see. Groups
    with claims follow, the longest first: what is left for the end is short, and no process waits
    long for the last one.

    Parameters
    ----------
    figures, claims : sequence of str
        Names.

    Returns
    -------
    list of list of Item

    Examples
    --------
    >>> [[item.name for item in group] for group in groups_of(["fig8", "fig1"], ["M13", "M03"])]
    [['fig1'], ['fig8', 'M13'], ['M03']]
    """
    wanted = {name: _figure(name) for name in figures} | {name: _claim(name) for name in claims}
    listed = {part for group in TOGETHER for part in group}
    alone = [(part,) for part in (*CLAIM_MODULES, *figures) if part not in listed]
    groups = [
        [wanted[name] for part in group for name in _names(part) if name in wanted]
        for group in (*TOGETHER, *alone)
    ]
    drawn = [group for group in groups if group and all(each.kind == "figure" for each in group)]
    short = [group for group in drawn if group[0].name not in listed]
    long = [group for group in drawn if group[0].name in listed]
    judged = [group for group in groups if any(each.kind == "claim" for each in group)]
    return [*short, *reversed(long), *(sorted(group, key=_is_claim) for group in judged)]


def _is_claim(item: Item) -> bool:
    return item.kind == "claim"


def _names(part: str) -> list[str]:
    """Claims of a module, or a figure."""
    return CLAIM_MODULES.get(part, part).split()


def _figure(name: str) -> Item:
    return Item("figure", name, *figure_place(name), figure_summary(name))


def _claim(name: str) -> Item:
    return Item("claim", name, "nonsmooth.chapter.claims", "check_of")
