"""Options of commands, made from the parameters of verbs.

What an option means, its default and its allowed values stand in the signature and the docstring
of the verb. How its value is written in a shell depends on its kind: numbers may be expressions,
states are given as ``x=0.1,v=0``. `FORMS` says that by the name of the parameter, once for every
command.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import click
from click.shell_completion import CompletionItem

from nonsmooth.cli.arguments import (
    by_column,
    initial_state,
    names,
    number,
    number_list,
    number_or_limits,
    numbers_by_column,
    time_range,
    whole,
    widths,
)
from nonsmooth.cli.signatures import Parameter
from nonsmooth.cli.wording import spoken, text_in_words_of_shell
from nonsmooth.errors import NonsmoothError, OptionError

__all__ = [
    "FORMS",
    "LEAST",
    "Kind",
    "Own",
    "flag",
    "own_option",
    "verb_option",
]


class Form(NamedTuple):
    """How an option is written: a placeholder, what makes a value of the text, and a help text."""

    metavar: str
    convert: Callable[[str, str], Any] | None = None  # takes the text and the option
    text: str = ""  # where the docstring speaks of objects of Python
    multiple: bool = False


class Own(NamedTuple):
    """An option that only the shell has."""

    name: str
    text: str
    metavar: str = ""  # of a flag there is none
    default: Any = None
    choices: tuple[Any, ...] = ()
    convert: Callable[[str, str], Any] | None = None
    multiple: bool = False
    required: bool = False
    drawn: bool = False  # it says something about the picture, so it needs --plot
    filmed: bool = False  # likewise about the film, which --animate names


def _words(text: str, _: str) -> list[str]:
    return text.replace(",", " ").split()


def _column(text: str, _: str) -> str | int:
    return int(text) if text.isdecimal() else text


def _labels(text: str, option: str) -> tuple[int, int]:
    try:
        first, second = (whole(part, option) for part in names(text, option))
    except (ValueError, OverflowError, NonsmoothError):
        raise OptionError(f"{option}: {text!r} is not two labels, such as 1,2") from None
    return first, second


# By the name of the parameter.
FORMS = {
    "initial": Form(
        "x=0.1,v=0", initial_state, "Initial state. States that you leave out are at rest."
    ),
    "start_a": Form("x=0.1,v=0", initial_state, "Start in one basin; states left out are at rest."),
    "start_b": Form("x=0.1,v=0", initial_state, "Start in the other basin."),
    "scales": Form(
        "x=0.1,v=2",
        initial_state,
        "Sizes by which states are divided before distances are measured; 1 without it.",
    ),
    "section": Form(
        "EXPRESSION",
        text="Where points are taken: an expression that is zero there, such as x-0.5, or the name"
        " of an event, such as impact.",
    ),
    "period": Form(
        "EXPRESSION",
        text="Time between strobes, in place of the period of the system. Parameters may stand in"
        " it, as in 2*pi/omega.",
    ),
    "measured.indicators.period": Form(
        "EXPRESSION",
        number,
        "Period of records without marks, in units of their times: exactly that of the forcing.",
    ),
    "find_orbit.period": Form(
        "N", text="Order of the orbit: how many periods of the forcing one turn takes."
    ),
    "smoothing_report.period": Form(
        "N", text="Order of the orbit that is followed: how many periods one turn takes."
    ),
    "find_orbit.transient": Form(
        "N",
        text="Periods left out before the orbit is looked for; 0 with --initial, 200 without it.",
    ),
    "smoothing_report.kind": Form("NAME", text="Function in place of the sign of a switch."),
    "samples_per_period": Form("N", text="Samples per period of the forcing."),
    "word": Form(
        '"MODE MODE ..."',
        _words,
        "Modes of one turn of the orbit in order; the last one is the first one again. Without it"
        " they are those of a simulation.",
    ),
    "completion": Form(
        "q=EXPRESSION",
        text="Value of a state that --over does not name, such as q=max(0,p-g). Without it the"
        " state is at rest. You may give it several times.",
        multiple=True,
    ),
    "mode": Form("MODE", text="Mode to start in, where several would fit."),
    "variable": Form("x[,y]", names),
    "contact": Form("MODE[,MODE...]", names),
    "of": Form("NAME[,NAME...]", names),
    "at": Form("EVENT"),
    "window": Form("NAME", text="Window against leakage, such as hann; boxcar is none."),
    "measured.Channel.units": Form(
        "UNIT", by_column, "Units of the displacements, such as mm; or of each, such as x=mm,y=g."
    ),
    "measured.Channel.sensitivity": Form(
        "A or x=A,y=B",
        numbers_by_column,
        "Reading per unit of displacement, such as 7.87; or of each column, such as x=7.87,y=8.1.",
    ),
    "measured.Channel.offset": Form(
        "A or x=A,y=B",
        numbers_by_column,
        "Reading at zero displacement, such as -9.6; or of each column, such as x=-9.6,y=-9.4.",
    ),
    "posterior.draws": Form("N", text="Draw the posterior too, with so many steps of each walker."),
    "mains": Form("50,60", number_list),
    "harmonics": Form("1,2", number_list),
    "leave_out": Form("KIND[,KIND...]", names),
    "time_range": Form("A,B", time_range),
    "shift": Form("NUMBER or A:B", number_or_limits),
    "private": Form("NAME[,NAME...]", names),
    "delimiter": Form("SIGN"),
    "epsilons": Form(
        "0.1,0.01",
        widths,
        "Widths of the smooth switches, in units of their functions; two or more.",
    ),
    "between": Form("1,2", _labels, "Look only at the boundary between these two outcomes."),
    "time": Form(
        "COLUMN",
        _column,
        "Column of the times: its header, or its number from 0. Without it the column 'time' or"
        " 't'. Times are in s, or in ms or us where the header says so.",
    ),
    "mark": Form("COLUMN", _column, "Column with one pulse per revolution, which a section needs."),
    "store": Form(
        "FOLDER",
        text="Keep finished parts in this folder. After an interruption the same command goes on"
        " there.",
    ),
    "cluster.plan_map.store": Form(
        "FOLDER",
        text="Folder of the map, a Zarr store. One that was planned with the same options stays as"
        " it is.",
    ),
    "threads": Form(
        "N", text="Threads to use, all processors by default. The result does not depend on it."
    ),
}

# Least values of whole and other numbers, which the verbs check and the help tells; by the name of
# the parameter, or with the verb before it where verbs differ.
LEAST: Mapping[str, float | None] = {
    "transient": 0,
    "record": 1,
    "lyapunov_spectrum.record": None,  # any length of time above 0
    "regime.record": 2,
    "regime_map.record": 2,
    "zero_one_test.record": 100,
    "evidence": 20,
    "longest": 1,
    "confirm": 0,
    "refine": 0,
    "bifurcation_picture.columns": 2,
    "searches": 0,
    "iterates": 1,
    "points": 1,
    "every": 1,
    "exponents": 1,
    "frequencies": 1,
    "structures.campbell.count": 1,
    "seed": 0,
    "cycle": 1,
    "segments": 1,
    "bootstrap": 0,
    "hold_back": 0,
    "posterior.draws": 10,
    "samples": 1,
    "samples_per_period": 1,
    "max_events": 1,
    "cells": 1,
    "threads": 1,
    "box": 2,
    "steps": 1,
    "starts": 1,
    "fatten": 1,
    "period": 1,
    "measured.indicators.periods": 3,
    "most_period": 1,
    "needed": 1,
    "among": 1,
    "tile": 1,
    "cluster.forecast.sample": 8,
    "cluster.plan_map.record": 2,
}


class Kind(click.ParamType):
    """Type of an option: text, a number, one of some values, or what a form makes of the text."""

    def __init__(
        self,
        metavar: str,
        convert: Callable[[str, str], Any] | None = None,
        choices: tuple[Any, ...] = (),
    ) -> None:
        self.name = metavar
        self.make = convert
        self.choices = {spoken(value): value for value in choices}

    def convert(self, value: Any, param: click.Parameter | None, ctx: Any) -> Any:
        """Value of a text; a default is one already."""
        if not isinstance(value, str):
            return value
        option = param.opts[0] if param is not None else ""
        if param is not None and not value.strip() and value != param.default:
            raise OptionError(f"{option}: the text is empty; give {self.name}, or leave it out")
        if self.choices:
            found = self.choices.get(value.strip().replace(" ", "-"))
            if found is None:
                texts = all(isinstance(each, str) for each in self.choices.values())
                shown = repr(value) if texts else value
                known = ", ".join(self.choices)
                raise OptionError(f"{option} = {shown} is not one of {known}")
            return found
        if self.name == "N":
            try:
                return whole(value, option)
            except (ValueError, OverflowError, NonsmoothError):
                self.fail(f"{value!r} is not a whole number, such as 100")
        if self.name == "NUMBER":
            try:
                return number(value, option)
            except NonsmoothError:
                self.fail(f"{value!r} is not a number or a constant expression, such as pi/2")
        return value if self.make is None else self.make(value, option)

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Allowed values, files or folders."""
        if self.name in ("FILE", "FOLDER"):
            return [CompletionItem(incomplete, type="dir" if self.name == "FOLDER" else "file")]
        return [CompletionItem(value) for value in self.choices if value.startswith(incomplete)]


def flag(name: str) -> str:
    """Option of a name."""
    return "--" + name.replace("_", "-")


def own_option(own: Own) -> click.Option:
    """Option that a command has beside those of its verb."""
    if not own.metavar:
        return click.Option([flag(own.name), own.name], is_flag=True, help=own.text)
    kind = Kind(own.metavar, own.convert, own.choices)
    text = _help(own.text, own.choices, None, own.default)
    return _option(own.name, kind, text, own.default, own.multiple, own.required)


def verb_option(
    verb: str,
    parameter: Parameter,
    name: str,
    *,
    default: Any,
    multiple: bool,
    flags: Mapping[str, str],
) -> click.Option:
    """Option for a parameter of a verb; `flags` has the option of every parameter by its name."""
    form = FORMS.get(f"{verb}.{parameter.name}", FORMS.get(parameter.name, Form("")))
    text = form.text or text_in_words_of_shell(parameter.text, flags)
    types = parameter.annotation.split(" | ")
    if "bool" in types:
        return click.Option([flag(name), name], is_flag=True, help=text)
    metavar = form.metavar or {"int": "N", "float": "NUMBER"}.get(types[0], "TEXT")
    if parameter.choices:
        metavar = "NAME" if isinstance(parameter.choices[0], str) else "N"
    least = LEAST.get(f"{verb}.{parameter.name}", LEAST.get(parameter.name))
    if metavar not in ("N", "NUMBER") or parameter.choices:
        least = None
    several = multiple or form.multiple
    if several and "several times" not in text:
        text += " You may give it several times."
    kind = Kind(metavar, form.convert, parameter.choices)
    text = _help(text, parameter.choices, least, default)
    return _option(name, kind, text, default, several, parameter.required)


def _option(
    name: str, kind: Kind, text: str, default: Any, multiple: bool, required: bool
) -> click.Option:
    """Option of click, which takes the default None for a value that is given."""
    more = {} if multiple or default is None else {"default": default}
    return click.Option(
        [flag(name), name],
        type=kind,
        metavar=kind.name,
        multiple=multiple,
        required=required,
        help=text,
        **more,
    )


def _help(text: str, choices: tuple[Any, ...], least: float | None, default: Any) -> str:
    """A help text with allowed values, the least value and the default behind it."""
    parts = []
    if choices:
        *most, last = map(spoken, choices)
        parts.append(f"{', '.join(most)} or {last}")
    if least is not None:
        parts.append(f"{least:g} or more")
    if default not in (None, "", ()):
        parts.append(f"default: {default if isinstance(default, int) else spoken(default)}")
    return f"{text} [{'; '.join(parts)}]" if parts else text
