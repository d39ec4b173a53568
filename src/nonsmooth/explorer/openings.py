"""What a page shows first: of a ready-made system its preset, of any other a guess."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from importlib.resources import files
from typing import Any

from nonsmooth.errors import OptionError
from nonsmooth.explorer.limits import sliders
from nonsmooth.explorer.links import from_link
from nonsmooth.explorer.view import View, system_of
from nonsmooth.models.ready_made import ready_made
from nonsmooth.system.system import System
from nonsmooth.system.text.expressions import name_set
from nonsmooth.system.text.grammar import parse

__all__ = ["Preset", "opening", "opening_range", "presets", "view_of", "view_of_link"]

_WIDE = 50  # as many units of time are shown where there is no period


@dataclass(frozen=True)
class Preset:
    """A view with a title, in a group of the list; it is made when it is asked for."""

    group: str
    title: str
    model: str
    words: Mapping[str, Any]

    @property
    def view(self) -> View:
        """What it shows."""
        view = opening(self.model)
        values = tuple((name, str(value)) for name, value in self.words.get("values", {}).items())
        return replace(view, values=values, **_fields(self.words.get("view", {})))


@lru_cache(maxsize=1)
def _table() -> dict[str, Any]:
    text = files("nonsmooth.explorer").joinpath("presets.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


@lru_cache(maxsize=1)
def presets() -> tuple[Preset, ...]:
    """All entries of the list: every ready-made system, and figures of the chapter."""
    found = [Preset("Machines", name.replace("_", " "), name, {}) for name in ready_made()]
    found += [
        Preset("Figures of the chapter", words["title"], words["model"], words)
        for words in _table()["figures"]
    ]
    return tuple(found)


@lru_cache(maxsize=64)
def _of_model(name: str) -> View:
    words = _fields(_table()["models"].get(name, {}))
    return replace(_guess(system_of(name, ""), words), model=name, **words)


def _fields(words: dict[str, Any]) -> dict[str, Any]:
    """Fields of a view as TOML has them: lists are tuples there, tables are pairs."""
    found: dict[str, Any] = {}
    for key, value in words.items():
        if isinstance(value, dict):
            found[key] = tuple(value.items())
        elif isinstance(value, list):
            found[key] = tuple(float(v) if isinstance(v, int) else v for v in value)
        else:
            found[key] = float(value) if key in ("leave_out", "length") else value
    return found


def opening(model: str = "moling", text: str = "") -> View:
    """What is shown first of a ready-made system, or of a text."""
    return replace(_guess(system_of("", text), {}), text=text) if text else _of_model(model)


def view_of(system: System) -> View:
    """What is shown first of a system; a ready-made one is known by its name and its texts."""
    make = ready_made().get(system.name)
    if make is not None:
        base = make()
        changed = {
            name: value
            for name, value in system.parameters.items()
            if base.parameters.get(name) != value
        }
        if set(changed) <= set(base.parameters) and base.with_parameters(**changed) == system:
            values = tuple((name, str(value)) for name, value in changed.items())
            return _over_present_value(replace(_of_model(system.name), values=values))
    return opening(text=system.to_toml())


def view_of_link(link: str) -> View:
    """View of a link; what one that was typed by hand does not name is as its system opens.

    Links of a page name the variables that are drawn, and then nothing is added to them.
    """
    given = from_link(link)
    if given.drawn or given.portrait or not (given.model or given.text):
        return given
    named = {
        item.name: getattr(given, item.name)
        for item in fields(View)
        if getattr(given, item.name) != item.default
    }
    view = replace(opening(given.model, given.text), **named)
    if given.over and not given.between:
        return replace(view, between=opening_range(view, given.over))
    return _over_present_value(view) if not given.between else view


def opening_range(view: View, over: str) -> tuple[float, ...]:
    """Range of a parameter that a diagram begins with: its slider."""
    for slider in sliders(view.system):
        if slider.name == over:
            return slider.low, slider.high
    raise OptionError(f"parameter {over!r} cannot be varied")


def _over_present_value(view: View) -> View:
    """A diagram that reaches as far as the present value of its parameter."""
    value = view.system.parameter_values.get(view.over)
    if value is None or not view.between or view.between[0] <= value <= view.between[1]:
        return view
    return replace(view, between=(min(value, view.between[0]), max(value, view.between[1])))


def _guess(system: System, known: Mapping[str, Any]) -> View:
    """Variables, parameter and ranges that show something of most systems, but for known ones."""
    moving = [name for name in system.states if name not in system.drift_states]
    across, up = _position_and_rate(system, moving)
    over, between = ("", ()) if "between" in known else _parameter(system)
    return View(
        length=20.0 if system.period is not None else float(_WIDE),
        drawn=(across, *system.drift_states)[:2],
        portrait=(across, up),
        over=over,
        between=between,
        shown=up if system.period is not None else across,  # that of the section is 0 there
        section="" if system.period is not None else up,
        picture="basins" if len(moving) <= 4 and system.period is not None else "section",
        plane=(across, up) if across != up else (),
    )


def _position_and_rate(system: System, states: list[str]) -> tuple[str, str]:
    """Two states of which the second is the rate of the first, where there are such."""
    flow = next(iter(system.modes.values())).flow
    for name in states:
        rate = str(flow.get(name, "")).strip()
        if rate in states and rate != name:
            return name, rate
    return states[0], states[min(1, len(states) - 1)]


def _parameter(system: System) -> tuple[str, tuple[float, ...]]:
    """Parameter of the diagram: one of the period, or else the first; within its slider."""
    known = {slider.name: slider for slider in sliders(system)}
    if not known:
        return "", ()
    used = [] if system.period is None else sorted(_names(str(system.period)))
    over = next((name for name in used if name in known), next(iter(known)))
    slider, value = known[over], system.parameter_values[over]
    reach = 0.25 * abs(value) or 0.5
    return over, (max(slider.low, value - reach), min(slider.high, value + reach))


def _names(text: str) -> set[str]:
    return {str(name) for name in name_set(parse(text, where="period"))}
