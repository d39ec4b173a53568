"""`save_animation`: a film into a file, frame by frame."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.files import check_target, replacing

if TYPE_CHECKING:
    from PIL.Image import Image

    from nonsmooth.plot.film import Film

__all__ = ["FILMS", "check_film", "save_animation"]

_COARSEST, _FINEST = 40.0, 400.0  # dots per inch
_NO_MOVIES = (
    "an .mp4 is written by ffmpeg, which is not installed here: pip install 'nonsmooth[movie]', or"
    " write a .gif or an .html"
)
_LARGEST_PAGE = 500.0  # megabytes that matplotlib may put into one page; the frames are bounded
_COLOURS = 128  # of a GIF
_LOOKED_AT = 5  # frames from which they are chosen
_HUNDREDTHS = 100.0  # of a second, in which a GIF counts

Picture = npt.NDArray[np.uint8]


@checked
def save_animation(film: Film, path: str | Path, *, dpi: float = 125.0) -> Path:
    """Write a film to an MP4, GIF or HTML file, whole or not at all.

    Parameters
    ----------
    film : Film
        Result of `animate`.
    path : str or pathlib.Path
        File to write, in a folder that exists; its suffix says the format. An ``.mp4`` is small
        and needs ffmpeg (``pip install 'nonsmooth[movie]'``); a ``.gif`` plays everywhere; an
        ``.html`` has buttons to stop, to step and to change the speed, and needs no other file.
    dpi : float, optional
        Dots per inch. A film is 6.4 by 3.84 inches, so 800 by 480 dots by default.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    OptionError
        For another suffix, a folder that does not exist, or an ``.mp4`` without ffmpeg.

    Notes
    -----
    What stands still is drawn once, what moves is drawn over it in each frame of an MP4 or a GIF.
    A GIF counts in hundredths of a second; frames are given one hundredth more or less, so that
    the pace stays as stated.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.bouncing_ball(), periods=2)
    >>> film = ns.plot.animate(run, slow_down=0.5)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = ns.plot.save_animation(film, Path(folder) / "ball.gif", dpi=50)
    ...     file.stat().st_size > 1000
    True
    """
    target = check_film(path)
    if not _COARSEST <= dpi <= _FINEST:
        raise OptionError(f"dpi = {dpi:g} must be between {_COARSEST:g} and {_FINEST:g}")
    with replacing(target) as draft:
        FILMS[target.suffix.lower()](film, draft, dpi)
    return target


def check_film(path: str | Path) -> Path:
    """File of a film, which could be written here."""
    target = check_target(path, tuple(FILMS))
    if target.suffix.lower() == ".mp4":
        _ffmpeg()
    return target


def _ffmpeg() -> Any:
    try:
        import imageio_ffmpeg

        imageio_ffmpeg.get_ffmpeg_exe()
    except (ImportError, RuntimeError):
        raise OptionError(_NO_MOVIES) from None
    return imageio_ffmpeg


def _pictures(film: Film, dpi: float, frames: Iterable[int]) -> Iterator[Picture]:
    """Frames as red, green, blue and opacity; what stands still is drawn once.

    The array of a frame is that of the next one too: it is to be used at once.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure, before = film.figure, film.figure.dpi
    shown = figure.canvas
    try:
        canvas = FigureCanvasAgg(figure)
        figure.set_dpi(dpi)
        canvas.draw()
        still = canvas.copy_from_bbox(figure.bbox)
        for frame in frames:
            canvas.restore_region(still)
            for artist in film.update(frame):
                if artist.get_visible():
                    figure.draw_artist(artist)
            yield np.asarray(canvas.buffer_rgba())
    finally:
        figure.set_canvas(shown)
        figure.set_dpi(before)


def _write_mp4(film: Film, draft: Path, dpi: float) -> None:
    ffmpeg = _ffmpeg()
    # even, as players ask for
    width, height = (int(side * dpi) // 2 * 2 for side in film.figure.get_size_inches())
    writer = ffmpeg.write_frames(
        str(draft), (width, height), fps=film.frames_per_second, codec="libx264", quality=8,
        pix_fmt_in="rgba", macro_block_size=1, ffmpeg_log_level="error",
    )  # fmt: skip
    writer.send(None)
    try:
        for picture in _pictures(film, dpi, range(film.count)):
            writer.send(np.ascontiguousarray(picture[:height, :width]))
    finally:
        writer.close()


def _few_colours(film: Film, dpi: float) -> Iterator[Image]:
    """Frames in the colours that some of them have most; flat ones make small files."""
    from PIL import Image

    some = range(0, film.count, max(1, film.count // _LOOKED_AT))
    looked_at = np.concatenate([picture.copy() for picture in _pictures(film, dpi, some)])
    palette = Image.fromarray(looked_at).convert("RGB").quantize(_COLOURS)
    for picture in _pictures(film, dpi, range(film.count)):
        whole = Image.fromarray(picture).convert("RGB")
        yield whole.quantize(palette=palette, dither=Image.Dither.NONE)


def _write_gif(film: Film, draft: Path, dpi: float) -> None:
    frames = _few_colours(film, dpi)
    ends = np.rint(_HUNDREDTHS * np.arange(1, film.count + 1) / film.frames_per_second)
    next(frames).save(
        draft, format="GIF", save_all=True, append_images=frames, loop=0, optimize=True,
        duration=[int(10 * length) for length in np.diff(ends, prepend=0.0)],
    )  # fmt: skip


def _write_html(film: Film, draft: Path, dpi: float) -> None:
    import matplotlib
    from matplotlib.animation import HTMLWriter
    from matplotlib.figure import Figure

    # a player of matplotlib that is given finished pictures: it would draw all of each frame
    sheet = Figure(figsize=tuple(film.figure.get_size_inches()), dpi=dpi)
    writer = HTMLWriter(fps=film.frames_per_second, embed_frames=True, default_mode="loop")  # type: ignore[arg-type]  # it divides 1000 by it
    limit: Any = {"animation.embed_limit": _LARGEST_PAGE}
    with matplotlib.rc_context(limit), writer.saving(sheet, str(draft), dpi):
        for frame in _few_colours(film, dpi):
            sheet.clear()
            sheet.figimage(np.asarray(frame.convert("RGB")))
            writer.grab_frame()


FILMS: dict[str, Callable[[Film, Path, float], None]] = {
    ".mp4": _write_mp4,
    ".gif": _write_gif,
    ".html": _write_html,
}
