"""Figures of the chapter: the table of them, drawing, and files with the data they show."""

from __future__ import annotations

import importlib
import inspect
import tomllib
from collections.abc import Iterable
from functools import cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth import OptionError
from nonsmooth.plot import save_figure
from nonsmooth_chapter.results import save_data, unknown_name

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr
    from matplotlib.figure import Figure

__all__ = [
    "draw_figure",
    "figure_ids",
    "figure_place",
    "figure_summary",
    "figure_text",
    "group_of",
    "run_figures",
    "write_figure",
]

# Beside a figure in the report: what the chapter shows, and what is taken where it leaves it open.
TEXTS = ("where", "caption", "parameters", "protocol", "reading")


@cache
def _table() -> dict[str, dict[str, str]]:
    text = resources.files("nonsmooth_chapter").joinpath("figures.toml").read_text("utf-8")
    return tomllib.loads(text)


def figure_ids() -> list[str]:
    """Names of the figures, in the order of the chapter.

    Returns
    -------
    list of str

    Examples
    --------
    >>> from nonsmooth_chapter import figure_ids
    >>> figure_ids()
    ['fig1', 'fig2a', 'fig3b', 'fig5b', 'fig5d', 'fig6', 'fig7', 'fig8', 'fig9', ...]
    """
    return list(_table())


def figure_summary(name: str) -> str:
    """What a figure shows, in one line.

    Parameters
    ----------
    name : str
        Name of the figure.

    Returns
    -------
    str

    Raises
    ------
    OptionError
        For an unknown name.

    Examples
    --------
    >>> from nonsmooth_chapter import figure_summary
    >>> figure_summary("phases")
    'four phases of a period-one motion'
    """
    return _row(name)["summary"]


def figure_place(name: str) -> tuple[str, str]:
    """Module and function that draw a figure.

    Parameters
    ----------
    name : str
        Name of the figure.

    Returns
    -------
    tuple of str

    Examples
    --------
    >>> figure_place("fig8")
    ('nonsmooth_chapter.mole.diagram_figures', 'fig8')
    """
    module, _, function = _row(name)["draw"].partition(":")
    return f"nonsmooth_chapter.{module}", function


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
    row = _table().get(name, {})
    return {part: row.get(part, name if part == "where" else "") for part in TEXTS}


def group_of(name: str) -> str:
    """Group of claims and figures that share computations with a figure.

    Parameters
    ----------
    name : str
        Name of the figure.

    Returns
    -------
    str

    Examples
    --------
    >>> group_of("fig8"), group_of("fig1")
    ('mole over force', 'fig1')
    """
    return _row(name).get("together", name)


def draw_figure(name: str, **options: Any) -> tuple[Figure, xr.Dataset]:
    """Draw a figure of the chapter.

    Parameters
    ----------
    name : str
        Name of the figure, see `figure_ids`.
    **options
        Options of the function that draws it, such as ``columns`` of a diagram. Those by default
        give the figure as it stands in the report.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The figure.
    data : xarray.Dataset
        What it shows.

    Raises
    ------
    OptionError
        For an unknown figure or option.

    Examples
    --------
    >>> from nonsmooth_chapter import draw_figure
    >>> figure, data = draw_figure("fig27", points=11)
    >>> data.sizes["deflection"]
    11
    """
    draw = _maker(name)
    known = inspect.signature(draw).parameters
    for option in options:
        if option not in known:
            raise OptionError(f"{name}: {unknown_name('option', option, known)}")
    return draw(**options)


def run_figures(ids: Iterable[str], out: Path | str) -> list[Path]:
    """Draw figures and write each as PNG and PDF with its data as netCDF beside them.

    Parameters
    ----------
    ids : iterable of str
        Names of figures, see `figure_ids`.
    out : pathlib.Path or str
        Folder for the files; made if it is not there.

    Returns
    -------
    list of pathlib.Path
        Files written, pictures and data of each figure in turn. Each appears whole or not
        at all.

    Raises
    ------
    OptionError
        For an unknown name.

    See Also
    --------
    run_chapter : on several processes, resumable, with a report.

    Examples
    --------
    >>> import tempfile
    >>> from nonsmooth_chapter import run_figures
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [path.name for path in run_figures(["fig5b"], folder)]
    ['fig5b.png', 'fig5b.pdf', 'fig5b.nc']
    """
    names = [ids] if isinstance(ids, str) else list(ids)
    makers = [_maker(name) for name in names]  # unknown names before any work
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, make in zip(names, makers, strict=True):
        written += write_figure(name, figure_summary(name), *make(), folder)
    return written


def _row(name: str) -> dict[str, str]:
    if name not in _table():
        raise OptionError(unknown_name("figure", str(name), _table()))
    return _table()[name]


def _maker(name: str) -> Callable[..., tuple[Figure, xr.Dataset]]:
    module, function = figure_place(name)
    found: Callable[..., tuple[Figure, xr.Dataset]] = getattr(
        importlib.import_module(module), function
    )
    return found


# Files of one figure: the picture for screens and for print, and the data it shows.


def write_figure(
    name: str, title: str, figure: Figure, data: xr.Dataset, folder: Path
) -> list[Path]:
    """Write a figure as PNG and PDF and its data as netCDF, each whole or not at all.

    Parameters
    ----------
    name : str
        Name of the figure, which is that of the files.
    title : str
        What it shows.
    figure : matplotlib.figure.Figure
        The figure.
    data : xarray.Dataset
        What it shows; gets the name, title and command of the figure as attributes.
    folder : pathlib.Path
        Folder of the files, which exists.

    Returns
    -------
    list of pathlib.Path
        The three files.

    Examples
    --------
    >>> import tempfile
    >>> from nonsmooth_chapter import draw_figure
    >>> drawn = draw_figure("fig27")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [path.name for path in write_figure("fig27", "forces", *drawn, Path(folder))]
    ['fig27.png', 'fig27.pdf', 'fig27.nc']
    """
    command = f"nonsmooth chapter run {name}"
    data.attrs = {"figure": name, "title": title, "command": command, **data.attrs}
    return [
        save_figure(figure, folder / f"{name}.png"),
        save_figure(figure, folder / f"{name}.pdf"),
        save_data(data, folder / f"{name}.nc"),
    ]
