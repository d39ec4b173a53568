"""The drawings that the library has, and one for every other system."""

from __future__ import annotations

from functools import lru_cache
from importlib.resources import files

from nonsmooth.drawings.drawing import Drawing
from nonsmooth.system.system import System

__all__ = ["drawing_of", "machines"]

_MOST_BARS = 12  # states; further ones are left out
_SHORT, _LONG = 6, 13  # characters of a name below a bar, and below two bars
_LINE = 0.32  # from one line of names to the next, where a bar reaches from -1 to 1
_GENERIC = """
title = "states of {name}"
note = "each bar is a state over its largest size, max"

[ranges]
{ranges}
[definitions]
{parts}
[view]
x = [-0.9, {right}]
y = [{below}, 2.35]

[[shapes]]
kind = "line"
points = [[-0.7, 0], ["{right} - 0.2", 0]]
role = "guide"
{shapes}"""
_BAR = """
[[shapes]]
kind = "rectangle"
x = ["{k} - 0.3", "{k} + 0.3"]
y = [-1, 1]
role = "casing"
[[shapes]]
kind = "rectangle"
x = ["{k} - 0.3", "{k} + 0.3"]
y = [0, "_{k}_part"]
role = "mass"
[[shapes]]
kind = "line"
points = [["{k} - 0.3", "_{k}_part"], ["{k} + 0.3", "_{k}_part"]]
role = "mark"
[[shapes]]
kind = "text"
at = [{k}, {down}]
text = "{name}"
[[shapes]]
kind = "text"
at = [{k}, 1.38]
text = "max\\n{{_{k}_high}}"
"""


@lru_cache(maxsize=1)
def machines() -> dict[str, Drawing]:
    """Drawings by the names of the systems that they are for."""
    folder = files("nonsmooth.drawings") / "machines"
    drawings = [
        Drawing.from_toml(each.read_text(encoding="utf-8"))
        for each in sorted(folder.iterdir(), key=lambda entry: entry.name)
        if each.name.endswith(".toml")
    ]
    return {name: drawing for drawing in drawings for name in drawing.systems}


def drawing_of(system: System) -> Drawing:
    """Drawing of a system: that of its machine, or bars of its states.

    Parameters
    ----------
    system : System
        The system; its name says which machine it is.

    Returns
    -------
    Drawing
        The drawing. Of systems that are no machine of `nonsmooth.models` it shows each state as a
        bar.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ns.plot.drawing_of(ns.models.moling()).title
    'ground mole'
    >>> ns.plot.drawing_of(ns.models.chua()).title
    'states of chua'
    """
    return machines().get(system.name) or _bars(system)


def _bars(system: System) -> Drawing:
    """One bar for each state."""
    states = system.states[:_MOST_BARS]
    # a bar is as wide as a short name; of longer ones every second stands in a line of its own
    lines = 2 if len(states) > 1 and max(map(len, states)) > _SHORT else 1
    return Drawing.from_toml(
        _GENERIC.format(
            name=system.name.replace('"', ""),
            right=len(states) - 0.1,
            ranges="".join(f'_{k} = "abs({state})"\n' for k, state in enumerate(states)),
            parts="".join(
                f'_{k}_part = "{state}/max(_{k}_high, 1e-300)"\n' for k, state in enumerate(states)
            ),
            shapes="".join(
                _BAR.format(k=k, name=_shortened(state), down=-1.3 - _LINE * (k % lines))
                for k, state in enumerate(states)
            ),
            below=-1.7 - _LINE * (lines - 1),
        )
    )


def _shortened(name: str) -> str:
    return name if len(name) <= _LONG else name[: _LONG - 1] + "\N{HORIZONTAL ELLIPSIS}"
