"""`animate`: a machine that moves, with its phase portrait beside it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from nonsmooth.arguments import checked
from nonsmooth.drawings import Drawing, drawing_of
from nonsmooth.drawings.drawing import values_of
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import FIGURE_STYLE, set_ticks
from nonsmooth.plot.film_panels import (
    EventFlash,
    HistoryPanel,
    MachinePanel,
    PortraitPanel,
)
from nonsmooth.plot.film_run import film_run, pace_of
from nonsmooth.plot.trace import check_variables
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.animation import FuncAnimation
    from matplotlib.figure import Figure

    from nonsmooth.drawings import Frames
    from nonsmooth.plot.film import FilmPanel

__all__ = ["animate"]

_SIZE = (6.4, 3.84)  # inches: 800 by 480 dots at 125 dots per inch, which all players like
_DOTS = 125.0
_WIDTHS, _HEIGHTS = (1.35, 1.0), (1.0, 0.24)
_FLASH = 0.16  # seconds of film for which an event is named
_SMALL = 6.5  # letters in points
_DRAWING = "a Drawing, which plot.Drawing.from_toml reads from a file"


@checked
def animate(
    run: xr.Dataset,
    *,
    portrait: tuple[str, str] | None = None,
    drawing: Annotated[Drawing, _DRAWING] | None = None,
    time_range: tuple[float, float] | None = None,
    slow_down: float | None = None,
    frames_per_second: float = 25.0,
) -> FuncAnimation:
    """Film of a machine: how it moves, its phase portrait beside it, and a cursor in time.

    The figure names the mode, lets events flash, and says below how much time of the motion a
    second of the film is, and what is not drawn to scale.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `simulate`.
    portrait : tuple of str, optional
        Two states or outputs of the phase portrait, the first of which is drawn over time too; by
        default the first two states that do not drift.
    drawing : Drawing, optional
        Another drawing than that of the system, which `drawing_of` gives.
    time_range : tuple of float, optional
        First and last time of the film; the whole run by default.
    slow_down : float, optional
        Seconds of film for a period of the run, or for a unit of its time where it has no period.
        By default 4, or less where the film would take more than 20 seconds; without a period the
        film takes 12 seconds.
    frames_per_second : float, optional
        How many pictures the film has in a second.

    Returns
    -------
    matplotlib.animation.FuncAnimation
        The film. Keep it in a variable as long as it is shown. `save_animation` writes it to a
        file; in a notebook ``film.to_jshtml()`` shows it.

    Raises
    ------
    OptionError
        For an unknown variable, a range that does not meet the run, a film of more than 2000
        frames, or a run that does not say of which system it is, as one in other units does not.

    See Also
    --------
    save_animation : write the film to a file.
    drawing_of : the drawing of a system.

    Notes
    -----
    Frames do not depend on the samples of the run. The motion is run anew from the last sample
    before the film, by `simulate`, to the instants of the frames, so no frame is interpolated
    across an event. The curves have 200 samples per period at least, and 2000 in all without a
    period. A drawing is worked out for all frames at once.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.moling(), periods=20)
    >>> T = run.attrs["period"]
    >>> film = ns.plot.animate(run, time_range=(18 * T, 20 * T), slow_down=5)
    >>> film.figure.get_supxlabel()[:30]
    '1 s of the film is 0.2 periods'
    """
    values_of(run)
    system = System.from_toml(run.attrs["system"])
    shown = _portrait(run, system, portrait)
    pace = pace_of(run, time_range, slow_down, frames_per_second)
    drawing = drawing_of(system) if drawing is None else drawing
    again = film_run(run, system, pace.times)
    of_frames = again.isel(time=slice(None, None, pace.fine))
    frames = drawing.frames(of_frames, again)
    moment = _FLASH * frames_per_second * pace.step  # in the time of the run
    figure, panels = _composed(again, of_frames, frames, shown, drawing.title, moment)
    figure.supxlabel(f"{pace.text}\n{frames.note}".strip(), fontsize=_SMALL, color="0.25")
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # what stands still keeps its place, and frames are quick
    from nonsmooth.plot.film import Film

    return Film(figure, panels, pace.frames, frames_per_second)


def _composed(
    run: xr.Dataset,
    of_frames: xr.Dataset,
    frames: Frames,
    portrait: tuple[str, str],
    title: str,
    moment: float,
) -> tuple[Figure, list[FilmPanel]]:
    """The figure and its parts: curves of the run, and what moves with its frames."""
    import matplotlib
    import matplotlib.pyplot as plt

    with matplotlib.rc_context(FIGURE_STYLE):
        figure = plt.figure(figsize=_SIZE, dpi=_DOTS, layout="constrained")
        places = figure.subplot_mosaic(
            [["machine", "portrait"], ["history", "history"]],
            width_ratios=_WIDTHS,
            height_ratios=_HEIGHTS,
        )
    for name in ("portrait", "history"):
        set_ticks(places[name])
    return figure, [
        MachinePanel(frames, places["machine"], title),
        EventFlash(of_frames, places["machine"], moment),
        PortraitPanel(run, of_frames, *portrait, places["portrait"]),
        HistoryPanel(run, of_frames, portrait[0], places["history"]),
    ]


def _portrait(run: xr.Dataset, system: System, given: tuple[str, str] | None) -> tuple[str, str]:
    """Variables of the portrait; of a system of one state, those of an output if there is one."""
    if given is not None:
        first, second = check_variables(run, list(given))
        return first, second
    states = [name for name in system.states if name not in system.drift_states]
    names = [*states, *system.drift_states, *system.outputs]
    if len(names) < 2:
        raise OptionError(
            f"the portrait needs two variables, and {system.name!r} has only {names[0]!r}; name"
            f" another among its outputs, such as rate({names[0]})"
        )
    return names[0], names[1]
