"""Files of one figure: the picture for screens and for print, and the data it shows."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from nonsmooth.plot import save_figure
from nonsmooth_chapter.files import save_data

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["write_figure"]


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
