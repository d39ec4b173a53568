"""Pictures for print: the calls of a view, drawn by the functions of `nonsmooth.plot`."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.explorer import calls
from nonsmooth.explorer.view import View

__all__ = ["SUFFIXES", "printed"]

SUFFIXES = (".png", ".pdf", ".svg")
_SIZE = (12.0, 8.0)  # cm, as the shell draws


def printed(view: View, which: str, suffix: str, known: Mapping[str, Any]) -> bytes:
    """Bytes of a picture file; what is not among the known results is computed."""
    from nonsmooth import plot

    if suffix not in SUFFIXES:
        raise OptionError(unknown_name("suffix", suffix, SUFFIXES))
    made = _DRAWN.get(which)
    if made is None:
        raise OptionError(unknown_name("picture", which, _DRAWN))
    missing = [] if _WANTED[which] & set(known) else made(view)
    results = calls.computed(missing, {"system": view.system} | dict(known))
    width, height = _SIZE
    figure, (ax,) = plot.print_figure(width=width, height=height)
    _draw(view, which, results, ax)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{which}{suffix}"
        plot.save_figure(figure, file)
        return file.read_bytes()


def _draw(view: View, which: str, results: dict[str, Any], ax: Any) -> None:
    from nonsmooth import plot

    if which == "history":
        plot.phases(results["run"], list(view.drawn), ax=ax)
    elif which == "portrait":
        plot.phase_portrait(results["run"], *view.portrait, phases=True, ax=ax)
    elif which == "diagram" and "branch" in results:
        plot.branch(results["branch"], view.shown, diagram=results["diagram"], ax=ax)
    elif which == "diagram":
        plot.bifurcation(results["diagram"], view.shown, ax=ax)
    elif "basins" in results:
        plot.basins(results["basins"], ax=ax)
    else:
        plot.section(results["points"], *view.plane, ax=ax)


def _diagram(view: View) -> list[calls.VerbCall]:
    made = calls.diagram(view)
    if view.turn > 0 and view.branch:
        made += [*calls.motion(view), *calls.orbit(view), *calls.branch(view)]
    return made


def _plane(view: View) -> list[calls.VerbCall]:
    return calls.basins(view) if view.picture == "basins" else calls.points(view)


_DRAWN = {
    "history": calls.motion,
    "portrait": calls.motion,
    "diagram": _diagram,
    "plane": _plane,
}
# results of which one is enough for a picture
_WANTED = {
    "history": {"run"},
    "portrait": {"run"},
    "diagram": {"diagram"},
    "plane": {"basins", "points"},
}
