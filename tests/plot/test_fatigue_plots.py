import numpy as np
import pytest
from matplotlib.text import Text

import nonsmooth as ns
from fatigue.bending import bent_beam, table_3
from nonsmooth.errors import OptionError


@pytest.fixture(scope="module")
def cycles():
    noise = ns.excitation.band_noise(5.0, 60.0, 40.0, duration=20.0, seed=1)
    times, values = noise.closed()
    return ns.fatigue.count_cycles(values, times, repeating=True)


def test_bars_hold_all_cycles(ax, cycles):
    ns.plot.load_cycles(cycles, ax=ax, per_second=True)
    total = sum(bar.get_height() for bar in ax.patches)
    assert total == pytest.approx(cycles.attrs["n_cycles"] / 20.0)
    assert ax.get_ylabel() == "cycles per second"


def test_the_matrix_holds_all_cycles(ax, cycles):
    ns.plot.load_cycles(cycles, ax=ax, kind="matrix", bins=12)
    assert ax.collections[0].get_array().sum() == pytest.approx(cycles.attrs["n_cycles"])


def test_a_matrix_of_equal_cycles(ax):
    same = ns.fatigue.count_cycles([0.0, 1.0] * 5 + [0.0], repeating=True)
    ns.plot.load_cycles(same, ax=ax, kind="matrix")
    assert ax.collections[0].get_array().sum() == pytest.approx(5.0)


def test_shaking_marks_the_strongest_line():
    sine = ns.excitation.harmonic(20.0, 3.0, duration=8.0)
    time, frequency = ns.plot.shaking(sine.to_dataset(), span=0.1)
    assert time.get_xlim()[1] == pytest.approx(0.1, rel=0.02)
    assert frequency.lines[0].get_xdata()[0] == pytest.approx(20.0)
    assert frequency.get_ylabel() == "power density [(m/s^2)²/Hz]"


@pytest.mark.slow
def test_lives_of_two_laws(ax):
    tests = table_3()
    law = ns.fatigue.published_laws()["walker 2024-T3"]
    published = ns.fatigue.compare_lives(tests, bent_beam, law)
    ns.plot.lives(published, ax=ax, label="published")
    fitted = ns.fatigue.fit_law(tests, bent_beam, law)
    ns.plot.lives(ns.fatigue.compare_lives(tests, bent_beam, fitted), ax=ax, label="fit")
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    lines = ["predicted as measured", "a factor of 2 off"]
    assert texts == ["published", "fit (fitted, in sample)", *lines]
    np.testing.assert_array_equal(ax.collections[0].get_offsets()[:, 1], published["predicted"])
    low, high = ax.get_ylim()
    assert low < published["measured"].min() and high > published["predicted"].max()
    assert len(ax.lines) == 3
    assert sorted(text.get_text() for text in ax.texts) == sorted(tests["test"].values)


@pytest.mark.slow
@pytest.mark.parametrize("fitted", [False, True])
def test_names_of_tests_are_free(ax, fitted):
    """As drawn: no name on another one, on a point, or beyond the axes."""
    tests, law = table_3(), ns.fatigue.published_laws()["walker 2024-T3"]
    found = ns.fatigue.compare_lives(tests, bent_beam, law)
    if fitted:
        law = ns.fatigue.fit_law(tests, bent_beam, law, free=("C", "m", "gamma"))
        ns.plot.lives(found, ax=ax, names=False)
        found = ns.fatigue.compare_lives(tests, bent_beam, law)
    ns.plot.lives(found, ax=ax)
    ax.figure.draw_without_rendering()
    boxes = [Text.get_window_extent(note) for note in ax.texts]
    assert len(boxes) == 8
    for k, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[:k])
        for dots in ax.collections:
            assert not any(box.contains(*p) for p in ax.transData.transform(dots.get_offsets()))
        inside = ax.get_window_extent()
        assert inside.x0 <= box.x0 and box.x1 <= inside.x1 and inside.y0 <= box.y0


def test_no_dashed_lines_at_a_factor_of_one(ax):
    lives = table_3().rename(life="measured").assign(predicted=("test", np.arange(1.0, 9.0)))
    ns.plot.lives(lives, ax=ax, factor=1.0, names=False)
    assert len(ax.lines) == 1 and not ax.texts


def test_bad_input(cycles):
    with pytest.raises(OptionError, match="count_cycles"):
        ns.plot.load_cycles(table_3())
    with pytest.raises(OptionError, match="draw 'histogram'"):
        ns.plot.load_cycles(cycles, kind="bars")
    with pytest.raises(OptionError, match="bins = 0"):
        ns.plot.load_cycles(cycles, bins=0)
    with pytest.raises(OptionError, match="none to draw"):
        ns.plot.load_cycles(cycles.isel(cycle=slice(0, 0)))
    with pytest.raises(OptionError, match="no 'load' over time"):
        ns.plot.shaking(ns.excitation.harmonic().to_dataset(), "load")
    with pytest.raises(OptionError, match="1 axes came"):
        ns.plot.shaking(ns.excitation.harmonic().to_dataset(), axes=ns.plot.print_figure()[1])
    with pytest.raises(OptionError, match="compare_lives"):
        ns.plot.lives(table_3())
    with pytest.raises(OptionError, match="must be from 1 to"):
        lives = table_3().rename(life="measured").assign(predicted=("test", np.ones(8)))
        ns.plot.lives(lives, factor=0.5)
