"""Words of Python as the shell has them: what docstrings and errors say of keyword arguments.

The library speaks of arguments as a script gives them, such as ``transient=200`` or ``mode = 'x'``.
A command gives the same values by options. Here, and only here, the first becomes the second.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from typing import Any

__all__ = [
    "advice_in_words_of_shell",
    "error_in_words_of_shell",
    "spoken",
    "text_in_words_of_shell",
]

# A value as errors recommend one: a text, a collection, a number or a plain name.
_VALUE = r"'[^']*'|\"[^\"]*\"|\{[^{}]*\}|\([^()]*\)|\[[^\[\]]*\]|-?\d[\w.+-]*\w|-?\d|True\b|False\b"

_COLLECTION = r"\{[^{}]*\}|\([^()]*\)|\[[^\[\]]*\]"
_WORDS = r"[a-z]+(?: [a-z]+)+"  # of a choice, such as follow up
_FILE = r"[^\s:]+\.\w+: "  # a message may begin with the name of a file
# Keys of the file of a system, which errors call as arguments of `System`.
_KEYS = (
    "definitions|drift|equations|initial|modes|outputs|parameters|period|require|signals|slow"
    "|states|surfaces|symmetry"
)


def spoken(value: Any) -> str:
    """A value as it is written in a shell: words with hyphens, an expression in quotes."""
    if isinstance(value, dict):
        told = ",".join(
            f"{name}={each if isinstance(each, str) else spoken(each)}"
            for name, each in value.items()
        )
        return f'"{told}"' if " " in told else told
    if isinstance(value, list | tuple):
        return ",".join(map(spoken, value))
    if not isinstance(value, str):
        return f"{value:g}"
    if " " not in value or re.fullmatch(_WORDS, value):
        return value.replace(" ", "-")
    return f'"{value}"'


def text_in_words_of_shell(text: str, options: Mapping[str, str]) -> str:
    """First sentence of a docstring's text; `options` has the option of every argument."""
    first = re.split(r"(?<=[\w)\"`])\. (?=[A-Z])", text.rstrip("."), maxsplit=1)[0]

    def shown(found: re.Match[str]) -> str:
        word = found[1]
        name, sign, value = word.partition("=")
        if name in options:
            return f"{options[name]} {value}" if sign else options[name]
        return spoken(word.strip('"')) if word.startswith('"') else word

    return re.sub(r"``?([^`]+)``?", shown, first.replace(" (dimensionless)", "")) + "."


def error_in_words_of_shell(message: str, options: Mapping[str, str]) -> str:
    """An error with the options of a command in place of the arguments of its verbs.

    Where the message begins with an argument it has ``record = 1``, ``record:`` or ``record[...]``.
    Elsewhere such words may be parameters of a system and stay as they are.
    """
    names = _any_of(options)
    begin = rf"^({_FILE})?({names})"
    if re.match(rf"{begin}(?= = |: |\[)", message):
        message = re.sub(rf"{begin}(?=: |\[)", lambda m: f"{m[1] or ''}{options[m[2]]}", message)
        message = re.sub(rf"(?<![\w.'\"-])({names})(?= = )", lambda m: options[m[1]], message)
        # of one entry of a mapping, or of one item of a list
        message = re.sub(rf"^({_FILE})?([\w -]+)\[['\"]?(\w+)['\"]?\]", r"\1\2: \3", message)
        message = re.sub(rf"(?<= = )({_COLLECTION})|(?<= as )({_COLLECTION})", _shown, message)
        message = re.sub(rf"(--[\w-]+) = '({_WORDS})'", _chosen, message)
    return advice_in_words_of_shell(message, options)


def advice_in_words_of_shell(message: str, options: Mapping[str, str]) -> str:
    """A message with options in place of arguments, which the sign ``=`` right behind marks.

    A choice between an option and an argument that the shell lacks leaves the option.
    """
    lacking = _any_of({name: told for name, told in options.items() if not told.startswith("-")})
    message = re.sub(rf" or ({lacking})=(?!\w)|(?<= )({lacking})= or ", "", message)

    def given(found: re.Match[str]) -> str:
        option, value = options[found[1]], found[2]
        if value in ("", "True") or (option == f"--no-{found[1]}" and value == "False"):  # a flag
            return option
        if option == "--word" and " " in value:
            return f'{option} "{value[1:-1]}"'
        try:
            return f"{option} {spoken(ast.literal_eval(value))}"
        except (ValueError, SyntaxError, TypeError):  # a range in words, such as (low, high)
            return f"{option} {value}"

    argument = rf"(?<![\w.'\"\[{{-])({_any_of(options)})="
    message = re.sub(rf"{argument}({_VALUE}|(?=[\s,;:.)]|$))", given, message)
    # what is left stands in the file of a system
    message = re.sub(rf"\b({_KEYS})=(?=[\s,;:.)]|$)", r"\1", message)
    return message.replace("(low, high)", "low:high")


def _shown(found: re.Match[str]) -> str:
    """A collection as the shell writes it; what no value is stays."""
    try:
        return spoken(ast.literal_eval(found[0])) or found[0]
    except (ValueError, SyntaxError, TypeError):
        return found[0]


def _chosen(found: re.Match[str]) -> str:
    """A value of several words, which are modes in a word and else the name of a choice."""
    option, value = found[1], found[2]
    return found[0] if option == "--word" else f"{option} = '{spoken(value)}'"


def _any_of(options: Mapping[str, str]) -> str:
    """Expression of any of the arguments, longer ones first."""
    return "|".join(sorted(map(re.escape, options), key=len, reverse=True)) or "(?!)"
