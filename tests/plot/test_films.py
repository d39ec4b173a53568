"""Films of machines: what they show, at which pace, and the files they become."""

import base64
import re
import sys

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

import nonsmooth as ns
from nonsmooth.errors import OptionError
from nonsmooth.plot.film_files import _pictures
from nonsmooth.plot.film_panels import HistoryPanel


def pixels(film, frame, dpi=50):
    """A frame as it stands in a file."""
    (picture,) = (each.copy() for each in _pictures(film, dpi, [frame]))
    return picture[..., :3].astype(int)


@pytest.fixture(scope="module")
def struck():
    """An oscillator at its wall, sampled too coarsely for a film: 7 times in a period."""
    return ns.simulate(ns.models.impact_oscillator(), periods=12, samples_per_period=7)


def test_frames_are_exact_between_samples_and_events(struck):
    """The frames of a coarse run are the samples of a fine one.

    Both are exact up to rounding: a few impacts of the film enlarge 1e-16 to below 1e-11.
    """
    T = struck.attrs["period"]
    film = ns.plot.animate(struck, time_range=(10 * T, 12 * T), slow_down=2.0)
    assert film.count == 101  # 2 periods of 2 s, 25 times a second, and the last one
    times = 10 * T + 2 * T * np.arange(101) / 100
    fine = ns.simulate(ns.models.impact_oscillator(), times=np.concatenate([[0.0], times]))
    portrait, point = film.figure.axes[1], []
    for frame in range(film.count):
        film.update(frame)
        point.append([line.get_data() for line in portrait.lines][-1])
    found = np.array(point)[..., 0]
    np.testing.assert_allclose(found[:, 0], fine["x"].values[1:], atol=1e-11)
    np.testing.assert_allclose(found[:, 1], fine["v"].values[1:], atol=1e-11)


def test_curves_have_more_samples_than_frames(struck):
    """At 13 frames per period the portrait is no polygon: a curve meets its extremes."""
    T = struck.attrs["period"]
    film = ns.plot.animate(struck, time_range=(10 * T, 12 * T), slow_down=0.5)
    assert film.count == 26
    times = np.append(0.0, np.linspace(10 * T, 12 * T, 4001))
    fine = ns.simulate(ns.models.impact_oscillator(), times=times).isel(time=slice(1, None))
    curves = [np.array(line.get_data(), float) for line in film.figure.axes[1].lines]
    x, y = max(curves, key=np.size)
    known = np.isfinite(x)
    for values, name in ((x[known], "x"), (y[known], "v")):
        size = np.ptp(fine[name].values)
        assert values.min() == pytest.approx(fine[name].values.min(), abs=1e-3 * size)
        assert values.max() == pytest.approx(fine[name].values.max(), abs=1e-3 * size)
    assert known.sum() >= 400


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("slow_down", "words", "count"),
    [(None, "1 s of the film is 0.25 periods", 301), (1.0, "is 1 period\n", 76), (0.5, "2 p", 38)],
)
def test_the_pace_is_stated(struck, slow_down, words, count):
    T = struck.attrs["period"]
    film = ns.plot.animate(struck, time_range=(0.0, 3 * T), slow_down=slow_down)
    assert words in film.figure.get_supxlabel()
    assert film.count == count


def test_the_pace_without_a_period():
    run = ns.simulate(ns.models.belt_oscillator(), times=np.linspace(0.0, 24.0, 241))
    film = ns.plot.animate(run)
    assert film.count == 301  # 12 s
    assert film.figure.get_supxlabel().startswith("1 s of the film is 2 units of time\n")


def test_long_runs_take_twenty_seconds(struck):
    assert ns.plot.animate(struck).count == 501


def test_mode_and_events_are_named(struck):
    T = struck.attrs["period"]
    film = ns.plot.animate(struck, time_range=(10 * T, 11 * T))
    flash = film._panels[1]
    texts, seen = [], []
    for frame in range(film.count):
        film.update(frame)
        texts.append(flash._name.get_text())
        seen.append(flash._event.get_visible())
    assert set(texts) == {"free"}
    named = flash._event.get_text()
    assert named == "impact" and 0 < sum(seen) < film.count
    # each event is shown for 0.16 s of the film: four or five frames of 0.04 s
    lengths = [len(each) for each in "".join("x" if s else " " for s in seen).split()]
    assert lengths and set(lengths) <= {4, 5}


@pytest.mark.slow
def test_what_is_drawn_once_looks_as_if_it_were_drawn_anew(struck):
    """A frame in a file is what matplotlib draws of the same frame, but for the order at edges."""
    T = struck.attrs["period"]
    film = ns.plot.animate(struck, time_range=(10 * T, 12 * T))
    quick = pixels(film, 60, dpi=100)
    film.update(60)
    for artist in film._artists():
        artist.set_animated(False)
    film.figure.set_dpi(100)
    film.figure.canvas.draw()
    whole = np.asarray(film.figure.canvas.buffer_rgba())[..., :3].astype(int)
    assert quick.shape == whole.shape
    different = np.abs(quick - whole).max(axis=-1) > 60
    assert different.mean() < 2e-3
    assert np.abs(quick - pixels(film, 0, dpi=100)).max() > 60, "nothing moves"


def test_a_gif_has_all_frames_and_keeps_the_pace(struck, tmp_path):
    T = struck.attrs["period"]
    film = ns.plot.animate(struck, time_range=(10 * T, 12 * T), slow_down=0.7, frames_per_second=15)
    file = ns.plot.save_animation(film, tmp_path / "a.gif", dpi=50)
    with Image.open(file) as image:
        assert image.size == (320, 192)
        lengths = []
        for frame in range(image.n_frames):
            image.seek(frame)
            lengths.append(image.info["duration"])
    # frames that look alike may have been joined; a fifteenth of a second is 6 or 7 hundredths
    assert sum(lengths) == pytest.approx(1000 * film.count / 15, abs=5)
    assert film.count == 22 and len(lengths) > 15
    assert [each.name for each in tmp_path.iterdir()] == ["a.gif"]


@pytest.mark.slow
def test_an_mp4_has_all_frames(struck, tmp_path):
    ffmpeg = pytest.importorskip("imageio_ffmpeg", reason="writes films; an extra, movie")
    T = struck.attrs["period"]
    film = ns.plot.animate(struck, time_range=(10 * T, 11 * T), slow_down=1.0)
    file = ns.plot.save_animation(film, tmp_path / "a.mp4", dpi=50)
    frames, seconds = ffmpeg.count_frames_and_secs(str(file))
    assert frames == film.count == 26
    assert seconds == pytest.approx(26 / 25, abs=0.05)
    reader = ffmpeg.read_frames(str(file))
    assert next(reader)["size"] == (320, 192)
    first = np.frombuffer(next(reader), np.uint8).reshape(192, 320, 3).astype(int)
    reader.close()
    assert np.abs(first - pixels(film, 0)).mean() < 8.0  # what compression loses


@pytest.mark.slow
def test_a_page_holds_its_pictures(struck, tmp_path):
    T = struck.attrs["period"]
    film = ns.plot.animate(struck, time_range=(10 * T, 11 * T), slow_down=0.4)
    file = ns.plot.save_animation(film, tmp_path / "a.html", dpi=50)
    assert [each.name for each in tmp_path.iterdir()] == ["a.html"]
    page = file.read_text(encoding="utf-8")
    found = re.findall(r'frames\[(\d+)\] = "data:image/png;base64,([^"]+)"', page)
    assert len(found) == film.count == 11
    (tmp_path / "b.png").write_bytes(base64.b64decode(found[7][1].replace("\\\n", "")))
    with Image.open(tmp_path / "b.png") as image:
        shown = np.asarray(image.convert("RGB")).astype(int)
    # in 128 colours
    assert np.abs(shown - pixels(film, 7)).mean() < 3.0


def test_another_portrait_and_another_drawing(struck):
    drawing = ns.plot.Drawing.from_toml(
        'title = "a dot"\n[view]\nx = [-9, 9]\ny = [-1, 1]\n'
        '[[shapes]]\nkind = "circle"\ncentre = ["x", 0]\nradius = 0.2\n'
    )
    film = ns.plot.animate(struck, portrait=("v", "acceleration"), drawing=drawing, slow_down=0.2)
    machine, portrait, history = film.figure.axes
    assert machine.get_title(loc="left") == "a dot"
    assert portrait.get_xlabel() == "velocity of the mass"
    assert history.get_title(loc="left") == "velocity of the mass"  # as that of the portrait


def test_an_index_of_a_unit_stands_below_the_line_in_the_strip(struck):
    run = struck.copy()
    run["v"].attrs["units"] = "A_b"
    ax = Figure().add_subplot()
    HistoryPanel(run, run, "v", ax)
    assert ax.get_title(loc="left") == "velocity of the mass [$A_{b}$]"


def test_systems_without_a_machine_and_with_one_state():
    decay = ns.System(states=["x"], equations={"x": "-x"}, outputs={"rate_of_x": "rate(x)"})
    film = ns.plot.animate(ns.simulate(decay, {"x": 1.0}, t_end=3.0))
    assert film.figure.axes[1].get_ylabel() == "rate_of_x"
    alone = ns.System(states=["x"], equations={"x": "-x"})
    with pytest.raises(OptionError, match=r"rate\(x\)"):
        ns.plot.animate(ns.simulate(alone, {"x": 1.0}, t_end=3.0))


def test_the_number_above_a_bar_is_named_and_that_of_the_whole_motion():
    """The steady state of x'' + 2 x' + x = cos t has the amplitude 1/2."""
    damped = ns.System(
        states=["x", "v"],
        period="2*pi",
        equations={"x": "v", "v": "-x - 2*v + cos(t)"},
    )
    run = ns.simulate(damped, {"x": 0.0, "v": 0.5}, periods=3)
    # 7 frames per period, none of which is at a peak of x = sin(t)/2
    film = ns.plot.animate(run, slow_down=0.28)
    shown = [text.get_text() for text in film.figure.axes[0].texts]
    assert [text for text in shown if text.startswith("max")] == ["max\n0.5", "max\n0.5"]


@pytest.mark.slow
def test_a_run_that_was_saved_is_animated(struck, tmp_path):
    import xarray as xr

    struck.to_netcdf(tmp_path / "run.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as again:
        film = ns.plot.animate(again.load(), slow_down=0.5)
    assert film.count == 151


def test_a_growing_crack_is_animated():
    """Parameters that change from period to period are those of the frames."""
    beam = ns.models.breathing_crack(growth="8 + t/100")
    run = ns.simulate(beam, periods=40)
    T = 2 * np.pi / 1.1475
    film = ns.plot.animate(run, time_range=(35 * T, 37 * T), slow_down=1.0)
    assert film.count in (50, 51)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"slow_down": 100.0}, "frames, at most 2000"),
        ({"slow_down": 1e-4}, "one frame"),
        ({"slow_down": -1.0}, "slow_down"),
        ({"frames_per_second": 0.0}, "frames_per_second"),
        ({"time_range": (900.0, 901.0)}, "meet the run"),
        ({"portrait": ("x", "w")}, "unknown variable 'w'"),
        ({"drawing": "mole"}, "Drawing.from_toml"),
    ],
)
def test_wrong_options_are_named(struck, options, words):
    with pytest.raises(OptionError, match=words):
        ns.plot.animate(struck, **options)


def test_runs_in_other_units_are_refused():
    rig = ns.models.FatigueRig.from_dimensionless()
    run = rig.to_si(ns.simulate(rig.system(), periods=2))
    with pytest.raises(OptionError, match="as it came from simulate"):
        ns.plot.animate(run)


def test_wrong_files_are_named(struck, tmp_path, monkeypatch):
    film = ns.plot.animate(struck, slow_down=0.1)
    with pytest.raises(OptionError, match=r"\.mp4, \.gif, \.html"):
        ns.plot.save_animation(film, tmp_path / "a.avi")
    with pytest.raises(OptionError, match="dpi"):
        ns.plot.save_animation(film, tmp_path / "a.gif", dpi=5.0)
    with pytest.raises(OptionError, match=r"plot\.animate makes"):
        ns.plot.save_animation(plt.figure(), tmp_path / "a.gif")
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(OptionError, match=r"pip install 'nonsmooth\[movie\]'"):
        ns.plot.save_animation(film, tmp_path / "a.mp4")
    assert not list(tmp_path.iterdir())
