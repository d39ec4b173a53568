"""Texts of the command line as names, numbers and systems.

Expressions go through the grammar of the library; nothing is handed to Python.
"""

from __future__ import annotations

import inspect
import math
import os
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from nonsmooth.errors import ModelError, OptionError, unknown_name

if TYPE_CHECKING:
    import numpy as np

    from nonsmooth.system.system import System

__all__ = [
    "build_system",
    "by_column",
    "constants",
    "initial_state",
    "is_file",
    "names",
    "need_period",
    "number",
    "number_list",
    "number_or_limits",
    "numbers_by_column",
    "refuse_fixed",
    "settings",
    "time_range",
    "value_limits",
    "value_range",
    "whole",
    "whole_names",
    "widths",
]

_MOST_VALUES = 1_000_000  # in a range
_SECOND = re.compile(r"(?<![<>=!])=(?!=)")
_WORDS = re.compile(r"Literal|\bstr\b")  # arguments of models that are no numbers
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


def is_file(model: str) -> bool:
    """Whether a MODEL means a file: it ends in ``.toml`` or names a folder."""
    return model.lower().endswith(".toml") or "/" in model or os.sep in model


def build_system(model: str, values: dict[str, str], initial: str = "") -> System:
    """System of a model or a file with some parameters given as text.

    initial: the option for initial states, where there is one
    """
    given = {name: _number_or_text(text) for name, text in values.items()}
    if is_file(model):
        from nonsmooth.system.system import System

        return _with_others(System.from_toml(Path(model)), model, given, (), initial)
    from nonsmooth.models.ready_made import ready_made

    known = ready_made()
    if model not in known:
        raise OptionError(_unknown_model(model, known))
    make = known[model]
    arguments = inspect.signature(make).parameters
    for name in given.keys() & arguments.keys():
        if not _WORDS.search(str(arguments[name].annotation)):
            _check_value(name, given[name])
    system = make(**{name: value for name, value in given.items() if name in arguments})
    others = {name: value for name, value in given.items() if name not in arguments}
    return _with_others(system, model, others, arguments, initial)


def _with_others(
    system: System,
    model: str,
    values: dict[str, float | str],
    arguments: Iterable[str],
    initial: str,
) -> System:
    """System with values of parameters that are not arguments of its function."""
    for name in values:
        if name in system.states:
            where = f"; where a run begins is said by {initial} {name}={_plain(values[name])}"
            told = f"{model}: {name!r} is a state and no parameter"
            raise OptionError(told + (where if initial else ""))
        if name not in system.parameters:
            known = {*arguments, *system.parameters}
            raise OptionError(f"{model}: {unknown_name('parameter', name, known)}")
        _check_value(name, values[name])
    return system.with_parameters(**values) if values else system


def _plain(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:g}"


def _check_value(name: str, value: float | str) -> None:
    """Refuse a text that is no number, in words of the command line."""
    if isinstance(value, str) and not math.isfinite(_constant(value, f"NAME=VALUE: {name}")):
        raise OptionError(f"NAME=VALUE: {name} = {value} is not a finite number")


def refuse_fixed(model: str, values: dict[str, str], changed: Iterable[str], option: str) -> None:
    """Refuse a value of a parameter that an option changes anyway, since it would be lost.

    It stays where the system refuses the other values without it.
    """
    for name in changed:
        if name not in values:
            continue
        try:
            build_system(model, {key: text for key, text in values.items() if key != name})
        except ModelError:
            continue
        raise OptionError(
            f"{name}={values[name]} counts for nothing, since {option} gives the values of {name};"
            " leave one of them out"
        )


def need_period(system: System, cure: str) -> None:
    """Refuse a system without a period, where a command looks at it once per period."""
    if system.period is None:
        raise OptionError(f"{system.name} has no period; {cure}")


def _unknown_model(model: str, known: Iterable[str]) -> str:
    if Path(model).suffix and Path(model).is_file():
        return (
            f"{model!r} is a file, whose name does not end in .toml, and no model; where it holds"
            f" a system in TOML, write .{os.sep}{model}"
        )
    sentence = unknown_name("model", model, known)
    for file in (f"{model}.toml", model):
        if Path(file).is_file():
            shown = file if is_file(file) else f".{os.sep}{file}"
            return f"{sentence}; for the file of that name write {shown}"
    return f"{sentence}; a file of your own ends in .toml"


def _number_or_text(text: str) -> float | str:
    # A plain number as such: the system then equals the one that a script makes. One beyond the
    # range of numbers stays a text, so that an error can tell what was typed.
    if not _NUMBER.fullmatch(text.strip()) or math.isinf(float(text)):
        return text
    return float(text)


def settings(
    texts: Sequence[str], option: str, form: str = "name=value", apart: str = ""
) -> dict[str, str]:
    """Texts such as ``b=0.15`` as names with the texts of their values.

    form: what such a text is; apart: how several are given, where a value has no sign ``=``
    """
    values: dict[str, str] = {}
    for text in texts:
        name, sign, value = (part.strip() for part in text.partition("="))
        if not (name and sign and value):
            raise OptionError(f"{option}: {text!r} is not of the form {form}")
        if apart and _SECOND.search(value):
            raise OptionError(f"{option}: {text!r} has a second sign =; {apart}")
        if name in values:
            raise OptionError(f"{option}: {name!r} is given twice")
        values[name] = value
    return values


def constants(values: dict[str, str], option: str) -> dict[str, float]:
    """Values of constant expressions such as ``pi/2``."""
    return {name: _constant(text, f"{option}: {name}") for name, text in values.items()}


def _constant(text: str, where: str) -> float:
    """Value of a constant expression; `where` says in an error what the text stands for."""
    from nonsmooth.system.text.evaluate import constant_value
    from nonsmooth.system.text.expressions import names_in
    from nonsmooth.system.text.grammar import parse

    _check_range(text, where)
    tree = parse(text, where=where)
    others = sorted(n.name for n in names_in(tree) if n.name != "pi")
    if others:
        raise OptionError(
            f"{where} = {text} uses {others[0]!r}; give a number or a constant expression such as"
            " pi/2"
        )
    return constant_value(tree, {})


def _check_range(text: str, where: str) -> None:
    """Refuse a number that is larger than any, and would become infinite."""
    if _NUMBER.fullmatch(text.strip()) and math.isinf(float(text)):
        raise OptionError(f"{where} = {text} is beyond the range of numbers, about 1.8e308")


def names(text: str | None, option: str) -> list[str]:
    """Names separated by commas; none of no text."""
    parts = [part.strip() for part in (text or "").split(",")]
    if parts == [""]:
        return []
    if "" in parts:
        raise OptionError(f"{option}: {text!r} has a comma too many")
    return parts


def whole_names(parts: Sequence[str], known: Iterable[str]) -> list[str]:
    """Names out of the parts between commas: a known name, such as ``touch,up``, may have some."""
    names, found, k = set(known), [], 0
    while k < len(parts):
        ends = range(len(parts), k, -1)
        end = next((end for end in ends if ",".join(parts[k:end]) in names), k + 1)
        found.append(",".join(parts[k:end]))
        k = end
    return found


def number(text: str, option: str) -> float:
    """A number, which may be a constant expression such as ``pi/2``."""
    _check_range(text, option)
    try:
        return float(text)
    except ValueError:
        return _constant(text, option)


def whole(text: str, option: str) -> int:
    """A whole number, such as ``100``, ``1e6`` or ``2**10``; ValueError for any other text."""
    try:
        return int(text)
    except ValueError:
        value = number(text, option)
    if value != int(value):
        raise ValueError(text)
    return int(value)


def initial_state(text: str, option: str) -> dict[str, float]:
    """Initial state of a text such as ``x=0.1,v=0``."""
    apart = "put commas between the states, as in x=0.1,v=0"
    return constants(settings(names(text, option), option, "x=0.1,v=0", apart), option)


def widths(text: str, option: str) -> list[float] | str:
    """Widths, which may be expressions; or the name of a parameter."""
    from nonsmooth.system.text.grammar import is_name

    parts = names(text, option)
    if not parts:
        raise OptionError(f"{option}: give widths such as 0.1,0.01,0.001")
    if len(parts) == 1 and is_name(parts[0]):
        return parts[0]
    return [_constant(part, option) for part in parts]


def by_column(text: str, option: str) -> str | dict[str, str]:
    """A text for all columns, or one for each, such as ``x=mm,y=g``."""
    return settings(names(text, option), option) if "=" in text else text


def numbers_by_column(text: str, option: str) -> float | dict[str, float]:
    """A number for all columns, or one for each, such as ``x=7.87,y=8.1``."""
    found = by_column(text, option)
    return constants(found, option) if isinstance(found, dict) else number(found, option)


def number_list(text: str, option: str) -> tuple[float, ...]:
    """Numbers separated by commas."""
    return tuple(number(part, option) for part in names(text, option))


def number_or_limits(text: str, option: str) -> float | tuple[float, float]:
    """A number, or two separated by a colon."""
    if ":" not in text:
        return number(text, option)
    return value_limits(f"{option.lstrip('-')}={text}", option)[1]


def time_range(text: str, option: str) -> tuple[float, float]:
    """Two times separated by a comma."""
    parts = names(text, option)
    if len(parts) != 2:
        raise OptionError(f"{option}: {text!r} is not two times, such as 800,1200")
    times = constants(dict(zip(("begin", "end"), parts, strict=True)), option)
    return times["begin"], times["end"]


def _limits(
    text: str, shape: Sequence[str], option: str = "--over"
) -> tuple[str, dict[str, float]]:
    """Name and numbers of ``name=first:last``, or of ``name=first:last:count``."""
    form = f"name={':'.join(shape)}"
    ((name, value),) = settings([text], option, form, f"it is one {form}").items()
    parts = [part.strip() for part in value.split(":")]
    if len(parts) != len(shape) or not all(parts):
        raise OptionError(f"{option}: {text!r} is not of the form {form}")
    return name, constants(dict(zip(shape, parts, strict=True)), option)


def value_limits(text: str, option: str = "--over") -> tuple[str, tuple[float, float]]:
    """Name and ends of ``name=low:high``."""
    name, numbers = _limits(text, ("low", "high"), option)
    if not numbers["low"] < numbers["high"]:
        raise OptionError(
            f"{option}: {text!r} is an empty range; the first number must be below the second one"
        )
    return name, (numbers["low"], numbers["high"])


def value_range(text: str) -> tuple[str, np.ndarray]:
    """Name and values of ``name=first:last:count``."""
    import numpy as np

    name, numbers = _limits(text, ("first", "last", "count"))
    count = numbers["count"]
    if count != int(count) or not 1 <= count <= _MOST_VALUES:
        raise OptionError(
            f"--over: the count {count:g} is not a whole number from 1 to {_MOST_VALUES}"
        )
    return name, np.linspace(numbers["first"], numbers["last"], int(count))
