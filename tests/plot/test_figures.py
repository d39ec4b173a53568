import os
import stat

import matplotlib
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth.errors import OptionError
from nonsmooth.files import replacing

SIGNATURES = {"png": b"\x89PNG", "pdf": b"%PDF", "PNG": b"\x89PNG"}


@pytest.mark.parametrize("suffix", SIGNATURES)
def test_the_suffix_says_the_format(mole, ax, tmp_path, suffix):
    ns.plot.phases(mole, ["x", "v"], ax=ax)
    path = ns.plot.save_figure(ax.figure, tmp_path / f"history.{suffix}")
    assert path.read_bytes().startswith(SIGNATURES[suffix])
    assert os.listdir(tmp_path) == [path.name]
    # readable by others as far as the user's own settings allow
    mask = os.umask(0)
    os.umask(mask)
    assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~mask


@pytest.mark.slow
def test_the_same_picture_is_the_same_file(mole, tmp_path):
    files = []
    for name in ("a.pdf", "b.pdf"):
        figure, (ax,) = ns.plot.print_figure()
        ns.plot.time_history(mole, "x", ax=ax)
        files.append(ns.plot.save_figure(figure, tmp_path / name).read_bytes())
    assert files[0] == files[1]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("history.gif", r"ends with '.gif'; the suffix says the format: .png, .pdf"),
        ("history", "has no suffix"),
        ("missing/history.png", "the folder .* does not exist"),
    ],
)
def test_files_that_cannot_be(ax, tmp_path, name, message):
    with pytest.raises(OptionError, match=message):
        ns.plot.save_figure(ax.figure, tmp_path / name)


def test_a_folder_is_no_file(ax, tmp_path):
    (tmp_path / "a.png").mkdir()
    with pytest.raises(OptionError, match="is a folder"):
        ns.plot.save_figure(ax.figure, tmp_path / "a.png")


def test_a_crash_leaves_the_old_file(tmp_path):
    target = tmp_path / "run.nc"
    target.write_text("old")
    with pytest.raises(RuntimeError), replacing(target) as draft:
        draft.write_text("half")
        raise RuntimeError
    assert target.read_text() == "old"
    assert os.listdir(tmp_path) == ["run.nc"]


def test_column_width_and_legible_texts(mole):
    """8 cm wide, no text under 7 points; also ticks, which are made when drawn."""
    figure, axes = ns.plot.print_figure()
    ns.plot.phases(mole, ["x", "z", "v"], ax=axes[0])
    figure.canvas.draw()
    assert figure.get_size_inches() * 2.54 == pytest.approx([8.0, 6.0])
    texts = figure.findobj(matplotlib.text.Text)
    assert min(text.get_fontsize() for text in texts if text.get_text()) >= 7.0


def test_nothing_of_a_picture_is_cut_off(mole):
    figure, axes = ns.plot.print_figure(3, 2, width=16.0)
    for ax in axes:
        ns.plot.time_history(mole, ["p", "q"], ax=ax, events=True, time_range=(1100.0, 1200.0))
    figure.canvas.draw()
    box = figure.get_tightbbox()
    width, height = figure.get_size_inches()
    assert box.x0 >= 0.0 and box.y0 >= 0.0
    assert box.x1 <= width and box.y1 <= height


def test_settings_of_the_user_stay(ax):
    before = matplotlib.rcParams.copy()
    ns.plot.print_figure(2, 1)
    assert matplotlib.rcParams == before


@pytest.mark.parametrize(
    ("attrs", "label"),
    [
        ({"long_name": "displacement", "units": "mm"}, "displacement [mm]"),
        ({"long_name": "time"}, "time"),
        ({"long_name": "ratio", "units": "1"}, "ratio"),
        ({}, "x"),
    ],
)
def test_axis_label(attrs, label):
    assert ns.plot.axis_label(xr.DataArray(0.0, name="x", attrs=attrs)) == label


def test_all_is_sorted_and_there():
    names = ns.plot.__all__
    assert names == sorted(names, key=lambda name: (not name.isupper(), name))
    assert all(hasattr(ns.plot, name) for name in names)


SIDES = {
    "width": ({"width": 1e9}, r"width = 1e\+09 must be from 0.5 to 500, in cm"),
    "thin": ({"width": 1e-9}, "width = 1e-09 must be from 0.5"),
    "height": ({"height": 600}, "height = 600 must be from 0.5 to 500"),
    "rows": ({"rows": 10**9}, "rows = 1000000000: axes would have no room; give at most 100"),
    "text": ({"width": "8 cm"}, "width = '8 cm' is not a finite number"),
}


@pytest.mark.parametrize("case", SIDES)
def test_a_figure_of_no_size_is_refused(case):
    options, words = SIDES[case]
    with pytest.raises(ns.OptionError, match=words):
        ns.plot.print_figure(**options)


def test_whole_numbers_of_axes_may_be_floats():
    assert len(ns.plot.print_figure(2.0, 1.0)[1]) == 2


def test_an_image_of_too_many_dots_is_told(tmp_path):
    """Agg has 16 bits for each side; 4800 dots per inch reach them at 34.7 cm."""
    figure, _ = ns.plot.print_figure(width=40.0, height=5.0)
    with pytest.raises(ns.OptionError, match=r"40 cm long, which are 75591 dots; .* dpi = 4161 or"):
        ns.plot.save_figure(figure, tmp_path / "banner.png", dpi=4800)


def test_sizes_of_points_and_lines_are_positive_and_not_huge():
    points = ns.stroboscopic_map(ns.models.soft_impact(), record=20)
    for draw in (ns.plot.section, ns.plot.transient_section):
        with pytest.raises(ns.OptionError, match=r"size = 1e\+09 is a diameter in typographic po"):
            draw(points, "x", "v", size=1e9)
    spectra = ns.waterfall(ns.models.soft_impact(), "omega", [0.7, 0.8], "x", transient=0, record=8)
    for height in (0.0, -1.0):
        with pytest.raises(ns.OptionError, match=f"height = {height:g} must be positive"):
            ns.plot.waterfall(spectra, height=height)


def test_a_film_of_one_frame_names_both_ways_to_more():
    run = ns.simulate(ns.models.soft_impact(), periods=2)
    with pytest.raises(ns.OptionError, match="slow_down than 4, or more frames_per_second than 1e"):
        ns.plot.animate(run, frames_per_second=1e-9)
