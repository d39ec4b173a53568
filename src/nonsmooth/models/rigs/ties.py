"""Whether a system is that of a rig, and the units of parameters that were tied."""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.models.rigs.units import Unit
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import evaluate
from nonsmooth.system.text.expressions import names_in
from nonsmooth.system.text.grammar import parse

__all__ = ["Ties", "check_system", "units_of_ties", "with_likes"]

# what says the same of tied parameters in other words, and what follows from the equations
_TEXTS = ("describe", "require", "symmetry")


@dataclass(frozen=True)
class Ties:
    """How a system differs from that of the rig it is of."""

    tied: dict[str, str]  # parameters of the model that follow others, with their texts
    new: tuple[str, ...]  # those others
    values: dict[str, float]  # parameters of the model that have a value of their own


def check_system(
    text: str,
    own: System,
    changed: Mapping[str, float],
    names: Collection[str],
    free: Collection[str],
) -> Ties:
    """Compare a system, as text, with that of a rig with parameters of these names.

    None but free parameters such as its speed, ties, and what a verb was told to change may differ.
    """
    theirs, mine = tomllib.loads(text), tomllib.loads(own.to_toml())
    system = System.from_toml(text)
    given, definitions = theirs["parameters"], theirs.get("definitions", {})
    tied = {name: str(definitions.pop(name)) for name in names if name in definitions}
    slow = theirs.pop("slow", {})
    for part in (theirs, mine):
        part["parameters"] = {
            name: value
            for name, value in part["parameters"].items()
            if name in names and name not in (*free, *tied, *slow, *changed)
        }
        for name in _TEXTS:
            part.pop(name, None)
    if theirs != mine:
        raise OptionError(
            "the dataset was not made with the system of this rig; use rig.system(), and for other"
            " values dataclasses.replace(rig, ...) or parameters= of a verb"
        )
    known = system.parameter_values
    values = {name: known[name] for name in names if name in given and name not in slow}
    return Ties(tied, tuple(n for n in given if n not in names), values)


def with_likes(
    parameters: Mapping[str, Unit], labels: Mapping[str, str], like: Any
) -> tuple[dict[str, Unit], dict[str, str]]:
    """Units and labels with those of new parameters that are said to be like known ones."""
    if not isinstance(like, Mapping):
        raise OptionError(
            f"like = {like!r:.60}: give a mapping, such as {{'new': {next(iter(parameters))!r}}}"
        )
    units, words = dict(parameters), dict(labels)
    for name, model in like.items():
        if name in parameters:
            raise OptionError(f"like: {name!r} is a parameter of the rig, whose unit is known")
        if model is not None and model not in parameters:
            raise OptionError(f"like: {unknown_name('parameter', str(model), parameters)}")
        units[name] = Unit() if model is None else parameters[model]
        words[name] = str(name)
    return units, words


def units_of_ties(
    ties: Ties, parameters: Mapping[str, Unit], labels: Mapping[str, str], like: Mapping[str, Any]
) -> tuple[dict[str, Unit], dict[str, str]]:
    """Units and labels of all parameters, the new ones included.

    A parameter that others follow by a number times it, plus a number, has their unit.
    """
    for name in like:
        if name not in ties.new:
            raise OptionError(f"like: {unknown_name('new parameter', str(name), ties.new)}")
    units, words = with_likes(parameters, labels, like)
    for name in ties.new:
        followers = {tied: text for tied, text in ties.tied.items() if _uses(text, name)}
        if name not in units:
            found = {units[tied] for tied, text in followers.items() if _is_linear(text, name)}
            plain = all(_is_linear(text, name) for text in followers.values())
            if len(found) != 1 or not plain:
                example = next(iter(followers), next(iter(parameters)))
                how = "; ".join(f"{tied} = {text!r}" for tied, text in followers.items())
                raise OptionError(
                    f"the unit of {name!r} does not follow from {how or 'any tie'}; say like which"
                    f" parameter it is, as in like={{{name!r}: {example!r}}}, or None for a number"
                )
            units[name] = found.pop()
        if units[name].name:  # a ratio is not what follows it
            words[name] = _common([labels[tied] for tied in followers]) or name
        else:
            words[name] = name
    return units, words


def _uses(text: str, name: str) -> bool:
    return name in {each.name for each in names_in(parse(text, where="tie"))}


def _is_linear(text: str, name: str) -> bool:
    """Whether an expression is a number times a parameter, plus a number."""
    rule = parse(text, where="tie")
    if {each.name for each in names_in(rule)} - {name, "pi"}:
        return False
    places = np.array([0.0, 0.3, 1.0, 1.7, 4.0])
    with np.errstate(all="ignore"):
        values = np.broadcast_to(np.asarray(evaluate(rule, {name: places}), float), places.shape)
    steps = np.diff(values) / np.diff(places)
    return bool(np.all(np.abs(steps - steps[0]) <= 1e-9 * np.abs(values).max()))


def _common(labels: list[str]) -> str:
    """The words that labels begin with in common: "preload" of "preload in x" and "in y"."""
    words = [label.split() for label in labels]
    count = 0
    while words and all(len(w) > count and w[count] == words[0][count] for w in words):
        count += 1
    found = words[0][:count] if words else []
    while found and found[-1] in ("in", "of", "the"):
        found.pop()
    return " ".join(found)
