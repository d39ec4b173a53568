"""Gestures: what a visitor does, as a new view of the old one. Nothing here knows a browser."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from typing import Any

from nonsmooth.errors import NonsmoothError, OptionError, is_known, unknown_name
from nonsmooth.explorer.links import read_field, read_number
from nonsmooth.explorer.openings import opening, opening_range, presets, view_of_link
from nonsmooth.explorer.view import View

__all__ = ["Gesture", "after"]

Gesture = Mapping[str, Any]

_FIELDS = {item.name for item in fields(View)}
_LEAST_BOX = 1e-12  # of the values in it; a smaller one would be lost in rounding


def after(view: View, gesture: Gesture) -> View:
    """View after a gesture; what cannot be shown is an error, and the old view stays."""
    do = gesture.get("do", "")
    if not is_known(do, _GESTURES):
        raise OptionError(unknown_name("gesture", do, _GESTURES))
    try:
        found = _GESTURES[do](view, gesture)
    except ValueError as fault:
        if isinstance(fault, NonsmoothError):
            raise
        raise OptionError(f"gesture {do}: {fault}") from None
    except (KeyError, TypeError, IndexError, AttributeError):
        raise OptionError(f"gesture {do}: a word is missing or of a wrong kind") from None
    found.check()
    return found


def _preset(view: View, gesture: Gesture) -> View:
    return presets()[int(gesture["number"])].view


def _link(view: View, gesture: Gesture) -> View:
    return view_of_link(str(gesture["link"]))


def _text(view: View, gesture: Gesture) -> View:
    """A typed system: what was shown of the one before is kept as far as it still has a meaning."""
    text = str(gesture["text"])
    if not text.strip():
        raise OptionError("there is no system: type its states and equations, or press Revert")
    found = opening(text=text)
    kept = {
        name: getattr(view, name)
        for name in ("length", "leave_out", "transient", "record", "cells")
    }
    new, old = found.system, view.system
    if new.states == old.states and set(old.outputs) <= set(new.outputs):
        for name in ("drawn", "portrait", "shown", "plane", "region", "section", "picture"):
            kept[name] = getattr(view, name)
        kept["initial"] = view.initial
    if view.over in new.parameters:
        value = new.parameter_values[view.over]
        if view.between and view.between[0] <= value <= view.between[1]:
            kept |= {"over": view.over, "between": view.between}
    view = replace(found, **kept)
    try:
        view.check_section()
    except OptionError:  # of an event that the system has no more
        return replace(view, section=found.section)
    return view


def _value(view: View, gesture: Gesture) -> View:
    """A parameter moved or typed."""
    name, text = str(gesture["name"]), str(gesture["value"]).strip()
    values = dict(view.values) | {name: text}
    return replace(view, values=tuple(values.items()), turn=0, branch=False, event=-1)


def _set(view: View, gesture: Gesture) -> View:
    """Fields as texts, in the words of a link."""
    given: dict[str, Any] = {}
    for name, text in gesture["fields"].items():
        if name not in _FIELDS or name in ("model", "text", "values"):
            raise OptionError(unknown_name("field", name, _FIELDS - {"model", "text", "values"}))
        given[name] = read_field(name, str(text))
    if "over" in given and given["over"] != view.over:
        given = {"between": opening_range(view, given["over"]), "height": ()} | given
    if "shown" in given:
        given = {"height": ()} | given
    if len(set(given.get("plane", ()))) == 1 and len(view.plane) == 2:  # one state for both axes
        given["plane"] = view.plane[::-1]
    if "plane" in given or ("picture" in given and given["picture"] != view.picture):
        given = {"region": ()} | given if "plane" in given else given
    return replace(view, **given)


def _start(view: View, gesture: Gesture) -> View:
    """States typed as a start; those at rest are left out."""
    given = {
        str(name): read_number(str(name), str(value)) for name, value in gesture["states"].items()
    }
    return _started(view, given)


def _started(view: View, given: Mapping[str, float]) -> View:
    rest = view.system.rest_state
    kept = {name: value for name, value in given.items() if value != rest.get(name)}
    return replace(view, initial=tuple(kept.items()), turn=0, branch=False, event=-1)


def _click(view: View, gesture: Gesture) -> View:
    """A place of a pane: run there, or start there."""
    x, y = float(gesture["x"]), float(gesture["y"])
    pane = gesture["pane"]
    if pane == "diagram":
        return _value(view, {"name": view.over, "value": _short(x, *view.between)})
    names = view.plane if pane == "plane" else view.portrait
    for name in names:
        if name not in view.system.states:
            raise OptionError(
                f"{name} is an output, so it does not say where a motion starts; choose two states"
            )
    return replace(_started(view, dict(view.initial) | {names[0]: x, names[1]: y}), leave_out=0.0)


def _short(value: float, first: float, last: float) -> str:
    """A number with no more digits than a place in a picture has."""
    width = abs(last - first) / 2000.0 or 1.0
    digits = max(0, 1 - int(f"{width:e}".partition("e")[2]))
    return repr(round(value, digits))


def _box(view: View, gesture: Gesture) -> View:
    """A box of a pane: compute it finer."""
    left, right = sorted((float(gesture["x0"]), float(gesture["x1"])))
    low, high = sorted((float(gesture["y0"]), float(gesture["y1"])))
    for first, last in ((left, right), (low, high)):
        if not last - first > _LEAST_BOX * max(abs(first), abs(last)):
            raise OptionError("the box is too small for numbers to tell its sides apart")
    left, right = (float(_short(value, left, right)) for value in (left, right))
    low, high = (float(_short(value, low, high)) for value in (low, high))
    if gesture["pane"] == "diagram":
        return replace(view, between=(left, right), height=(low, high))
    return replace(view, region=(left, right, low, high))


def _orbit(view: View, gesture: Gesture) -> View:
    """The periodic orbit nearby with its branch; once more to put them away."""
    return replace(view, turn=0 if view.turn else -1, branch=not view.turn and bool(view.over))


_GESTURES: dict[str, Callable[[View, Gesture], View]] = {
    "preset": _preset,
    "link": _link,
    "text": _text,
    "value": _value,
    "set": _set,
    "start": _start,
    "click": _click,
    "box": _box,
    "orbit": _orbit,
}
