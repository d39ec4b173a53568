"""Figures of the chapter by name: drawing them, and writing them with the data they show."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from nonsmooth import OptionError
from nonsmooth_chapter.files import unknown_name

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr
    from matplotlib.figure import Figure

__all__ = [
    "draw_figure",
    "figure_ids",
    "figure_place",
    "figure_summary",
    "run_figures",
]


class _Entry(NamedTuple):
    module: str
    function: str
    summary: str


_FIGURES = {
    "fig1": _Entry(
        "method.subspaces", "fig1", "trajectories across a surface and along it, two real systems"
    ),
    "fig2a": _Entry(
        "mole.friction_slider", "fig2a", "mass on a dry-friction slider: model and motion"
    ),
    "fig3b": _Entry(
        "mole.soil_figure", "fig3b", "resistance of the soil over penetration, slow and fast"
    ),
    "fig5b": _Entry(
        "mole.histories", "fig5b", "history of the mole with the data of the first test"
    ),
    "fig5d": _Entry(
        "mole.histories", "fig5d", "history of the mole with the data of the second test"
    ),
    "fig6": _Entry(
        "mole.histories", "fig6", "mass and slider bottom from rest for six static forces"
    ),
    "fig7": _Entry("mole.histories", "fig7", "the same in the steady state, tau from 800 to 1200"),
    "fig8": _Entry(
        "mole.diagrams", "fig8", "velocity and progression over the static force, three amplitudes"
    ),
    "fig9": _Entry(
        "mole.four_stages", "fig9", "four stages of a period-one orbit, with their durations"
    ),
    "fig10": _Entry(
        "mole.best_progression",
        "fig10",
        "progression per period over frequency, dynamic and static force, on branches of orbits",
    ),
    "fig11": _Entry(
        "mole.phases", "fig11", "drifting motion split into bounded oscillation and progression"
    ),
    "fig12": _Entry("mole.basins", "fig12", "basins of attraction of the mole, six frequencies"),
    "phases": _Entry("mole.phases", "period_one_phases", "four phases of a period-one motion"),
    "fig16": _Entry(
        "fatigue.record_figures", "fig16", "simulated records of the rig under harmonic shaking"
    ),
    "fig17": _Entry(
        "fatigue.record_figures", "fig17", "simulated records of the rig under chaotic shaking"
    ),
    "fig18": _Entry(
        "fatigue.life_figures", "fig18", "crack length over time, amplitude 100 N, four mean loads"
    ),
    "fig19": _Entry(
        "fatigue.life_figures", "fig19", "crack length over time, mean load 0, three amplitudes"
    ),
    "fig20": _Entry(
        "fatigue.life_figures", "fig20", "crack length over time, mean load 150 N, two amplitudes"
    ),
    "fig21": _Entry(
        "fatigue.life_figures", "fig21", "harmonic and chaotic shaking of equal power, mean load 0"
    ),
    "fig22": _Entry("fatigue.life_figures", "fig22", "the same at a mean load of 150 N"),
    "fig23": _Entry("fatigue.schematics", "fig23", "model of the rig with two masses"),
    "fig24": _Entry(
        "fatigue.rig_figures", "fig24", "two masses and the specimen: four phases from zero, steady"
    ),
    "fig25": _Entry(
        "fatigue.rig_figures", "fig25", "theoretical histories of the rig, dimensionless and in SI"
    ),
    "fig26": _Entry("fatigue.schematics", "fig26", "model of the rig with one mass"),
    "fig27": _Entry(
        "fatigue.stiffness", "fig27", "restoring force of a specimen with a breathing crack"
    ),
    "fig28": _Entry(
        "fatigue.portraits", "fig28", "phase portraits at four crack ratios by two stiffness laws"
    ),
    "fig29": _Entry(
        "fatigue.crack_figures", "fig29", "crack growth curve with sections at four lengths"
    ),
    "fig30": _Entry(
        "fatigue.crack_figures", "fig30", "transient sections of a beam whose crack grows"
    ),
    "fig31": _Entry("rotor.schematics", "fig31", "model of the rotor in its ring, and coordinates"),
    "fig32": _Entry("rotor.schematics", "fig32", "force of the ring against the normal of contact"),
    "fig33": _Entry("rotor.schematics", "fig33", "four forces of the ring over its displacement"),
    "fig34": _Entry("rotor.regions", "fig34", "regions of operation of the rotor in its ring"),
    "fig35": _Entry("rotor.regions", "fig35", "their boundaries, Eqs. (62)-(66)"),
    "fig36": _Entry(
        "rotor.diagrams",
        "fig36",
        "displacement of the rotor over its speed, with and without preload",
    ),
    "fig37": _Entry("rotor.sections", "fig37", "four sections of the rotor's motion"),
    "fig38": _Entry("rotor.ring_motion", "fig38", "velocity of the ring over its displacement"),
    "fig40": _Entry("rotor.diagrams", "fig40", "the rig from 7 to 50 Hz, with two sections"),
    "fig41": _Entry("rotor.diagrams", "fig41", "the rig from 7 to 30 Hz, with two sections"),
    "fig42": _Entry("rotor.rig_orbits", "fig42", "orbits of the rig at 13.1 Hz in x and in y"),
}


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
    return list(_FIGURES)


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
    return _entry(name).summary


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
    ('nonsmooth_chapter.mole.diagrams', 'fig8')
    """
    entry = _entry(name)
    return f"nonsmooth_chapter.{entry.module}", entry.function


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
    from nonsmooth_chapter.figure_files import write_figure

    names = [ids] if isinstance(ids, str) else list(ids)
    makers = [_maker(name) for name in names]  # unknown names before any work
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, make in zip(names, makers, strict=True):
        written += write_figure(name, figure_summary(name), *make(), folder)
    return written


def _entry(name: str) -> _Entry:
    if name not in _FIGURES:
        raise OptionError(unknown_name("figure", str(name), _FIGURES))
    return _FIGURES[name]


def _maker(name: str) -> Callable[..., tuple[Figure, xr.Dataset]]:
    module, function = figure_place(name)
    found: Callable[..., tuple[Figure, xr.Dataset]] = getattr(
        importlib.import_module(module), function
    )
    return found
