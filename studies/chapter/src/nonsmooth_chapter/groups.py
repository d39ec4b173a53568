"""Which figures and claims are computed one after the other, as they share what they need."""

from __future__ import annotations

from collections.abc import Sequence

from nonsmooth_chapter.claim_modules import CLAIM_MODULES
from nonsmooth_chapter.items import Item
from nonsmooth_chapter.registry import figure_place, figure_summary

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

    Short figures and short claims come first, so that there is soon something to see. Long figures
    follow, and long groups with claims, the longest first: what is left for the end is shorter, and
    no process waits long for the last one.

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
    [['fig1'], ['M03'], ['fig8', 'M13']]
    """
    wanted = {name: _figure(name) for name in figures} | {name: _claim(name) for name in claims}
    listed = {part for group in TOGETHER for part in group}
    alone = [(part,) for part in (*figures, *CLAIM_MODULES) if part not in listed]

    def items(group: tuple[str, ...]) -> list[Item]:
        names = [name for part in group for name in _names(part)]
        return sorted((wanted[name] for name in names if name in wanted), key=_is_claim)

    short, long = ([items(group) for group in parts] for parts in (alone, TOGETHER))
    judged = [group for group in long if any(map(_is_claim, group))]
    drawn = [group for group in long if group and group not in judged]
    return [*filter(None, short), *reversed(drawn), *judged]


def _is_claim(item: Item) -> bool:
    return item.kind == "claim"


def _names(part: str) -> list[str]:
    """Claims of a module, or a figure."""
    return CLAIM_MODULES.get(part, part).split()


def _figure(name: str) -> Item:
    return Item("figure", name, *figure_place(name), figure_summary(name))


def _claim(name: str) -> Item:
    return Item("claim", name, "nonsmooth_chapter.claims", "check_of")
