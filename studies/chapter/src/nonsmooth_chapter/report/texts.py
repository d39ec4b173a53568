"""Texts beside the figures: caption, parameters, protocol, and how an open place was read."""

from __future__ import annotations

import re
import tomllib
from functools import cache
from importlib import resources
from typing import Any

from nonsmooth_chapter.registry import figure_place

__all__ = ["command_of", "figure_text", "figures_of_claim", "section_of", "snippet_of"]

FIELDS = ("where", "caption", "parameters", "protocol", "reading")
_SECTIONS = {"method": 1, "mole": 2, "fatigue": 3, "rotor": 4}


@cache
def _texts() -> dict[str, dict[str, str]]:
    file = resources.files("nonsmooth_chapter.report").joinpath("figures.toml")
    return tomllib.loads(file.read_text("utf-8"))


def figure_text(name: str) -> dict[str, str]:
    """Texts beside a figure.

    Parameters
    ----------
    name : str
        Name of the figure.

    Returns
    -------
    dict of str to str
        ``where``, ``caption``, ``parameters``, ``protocol`` and ``reading``; empty where nothing
        is written.

    Examples
    --------
    >>> figure_text("fig8")["where"]
    'Fig. 8'
    """
    return dict.fromkeys(FIELDS, "") | {"where": name} | _texts().get(name, {})


def section_of(name: str) -> int:
    """Section of the chapter that a figure belongs to.

    Parameters
    ----------
    name : str
        Name of the figure.

    Returns
    -------
    int

    Examples
    --------
    >>> section_of("fig8")
    2
    """
    return _SECTIONS[figure_place(name)[0].split(".")[1]]


def command_of(name: str) -> str:
    """Command that writes a figure with its data.

    Parameters
    ----------
    name : str
        Name of the figure.

    Returns
    -------
    str

    Examples
    --------
    >>> command_of("fig8")
    'nonsmooth chapter run fig8 --out figures'
    """
    return f"nonsmooth chapter run {name} --out figures"


def snippet_of(name: str, options: dict[str, Any]) -> str:
    """Lines of Python that draw a figure.

    Parameters
    ----------
    name : str
        Name of the figure.
    options : dict
        Options of the function that draws it.

    Returns
    -------
    str

    Examples
    --------
    >>> print(snippet_of("fig27", {"points": 201}))
    from nonsmooth_chapter import draw_figure
    <BLANKLINE>
    figure, data = draw_figure("fig27", points=201)
    figure.savefig("fig27.png")
    """
    given = "".join(f", {key}={_literal(value)}" for key, value in options.items())
    return (
        "from nonsmooth_chapter import draw_figure\n\n"
        f'figure, data = draw_figure("{name}"{given})\n'
        f'figure.savefig("{name}.png")'
    )


def _literal(value: Any) -> str:
    """Value of an option as Python writes it; lists of records were tuples."""
    return repr(tuple(value) if isinstance(value, list) else value)


def figures_of_claim(where: str, names: list[str]) -> list[str]:
    """Figures that a claim is about, by the place it stands in the chapter.

    Parameters
    ----------
    where : str
        Such as ``"Fig. 8a-c"`` or ``"Figs. 36, 37"``.
    names : list of str
        Names of figures.

    Returns
    -------
    list of str

    Examples
    --------
    >>> figures_of_claim("Fig. 5a,b", ["fig5b", "fig5d", "fig50"])
    ['fig5b', 'fig5d']
    """
    text = re.search(r"Figs?\. ([\da-z, -]+)", where)
    numbers = set(re.findall(r"\d+", text[1])) if text else set()
    return [name for name in names if (n := re.search(r"\d+", name)) and n[0] in numbers]
