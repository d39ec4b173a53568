"""What a shape stands for says how it looks, in every drawing and for everyone who draws it."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["ROLES", "Role"]


@dataclass(frozen=True, slots=True)
class Role:
    """Colours of a shape, None for nothing, and width of its lines in points."""

    fill: str | None
    edge: str | None
    width: float = 0.8
    dashed: bool = False


_INK, _STEEL = "#222222", "#5A6570"

ROLES = {
    # bodies
    "mass": Role("#9DB7CC", _INK),
    "body": Role("#D9DEE3", _STEEL),
    "casing": Role("#EEF1F4", _STEEL),
    "fixed": Role("#BFC4C9", _STEEL),
    "pin": Role(_INK, _INK),
    # joints
    "spring": Role(None, _INK, 0.9),
    "damper": Role(None, _STEEL, 0.9),
    "rod": Role(None, _STEEL, 1.3),
    # surroundings
    "ground": Role(None, _STEEL, 0.8),
    "soil": Role("#D8C3A0", None),
    "stone": Role("#B59A6F", None),
    "grass": Role(None, "#4F7F3A", 1.6),
    "void": Role("#FFFFFF", None),
    # what changes
    "contact": Role("#D55E00", "#D55E00", 1.8),
    "force": Role("#7A2060", "#7A2060", 1.3),
    "crack": Role("#FFFFFF", "#D55E00", 1.2),
    "mark": Role("#0072B2", "#0072B2", 1.0),
    "guide": Role(None, "#8A8F94", 0.7, dashed=True),
    "label": Role(None, _INK),
}
