"""Pictures of alarms: what has a mark, where lines are, and what is refused."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns


def windows(a, b, **coords):
    data = {"a": ("window", np.asarray(a)), "b": ("window", np.asarray(b))}
    return xr.Dataset(data, {name: ("window", each) for name, each in coords.items()})


@pytest.fixture(scope="module")
def healthy():
    return windows(*np.random.default_rng(0).normal(size=(2, 400)))


def found(healthy, **coords):
    watched = windows([0.1, 9.0, 0.2, 9.0, 0.0], [0.1, 0.0, 0.0, 0.0, -9.0], **coords)
    return ns.measured.alarm(healthy, watched, rate=0.02)


def test_marks_lines_and_labels(healthy):
    time = ("window", np.arange(5.0), {"long_name": "time", "units": "s"})
    one = found(healthy).assign_coords(time=time)
    ax = ns.plot.alarm(one)
    lines = {line.get_label(): line for line in ax.lines}
    assert lines["leading: a"].get_xdata().tolist() == [1.0, 3.0]
    assert lines["leading: b"].get_xdata().tolist() == [4.0]
    assert lines["below the threshold"].get_xdata().tolist() == [0.0, 2.0]
    assert lines["threshold for 0.02"].get_ydata()[0] == float(one["threshold"])
    assert lines["first alarm"].get_xdata()[0] == 1.0
    assert ax.get_xlabel() == "time [s]" and ax.get_yscale() == "log"


def test_times_that_begin_anew_are_not_drawn_over(healthy):
    ax = ns.plot.alarm(found(healthy, time=[0.0, 1.0, 0.0, 1.0, 2.0]), legend=False)
    assert ax.get_xlabel() == "window" and ax.get_legend() is None
    # windows are counted from 1, as the shell and people do
    assert ax.lines[0].get_xdata().tolist() == [1.0, 3.0]


def test_curves_side_by_side(healthy):
    rng, ax = np.random.default_rng(1), None
    for shift in (1.0, 3.0):
        curve = ns.measured.roc(healthy, windows(shift + rng.normal(size=50), np.zeros(50)))
        ax = ns.plot.roc(curve, ax=ax, label=f"{shift:g}", logarithmic=True)
    labels = [text for text in ax.get_legend_handles_labels()[1] if "area" in text]
    assert [text.partition(",")[0] for text in labels] == ["1", "3"]
    assert len({line.get_color() for line in ax.lines}) == 3  # one of them is chance
    assert ax.get_xscale() == "log" and ax.get_ylabel() == "rate of detections"
    step = next(line for line in ax.lines if line.get_label().startswith("3"))
    np.testing.assert_array_equal(step.get_ydata(), curve["detections"])


def test_wrong_use(healthy):
    with pytest.raises(ns.OptionError, match="with watched= windows"):
        ns.plot.alarm(ns.measured.alarm(healthy, rate=0.02))
    with pytest.raises(ns.OptionError, match="give a result of measured"):
        ns.plot.roc(found(healthy))


@pytest.mark.parametrize(("top", "least"), [(6.0, 2), (60.0, 4)])
def test_scores_have_plain_numbers(top, least):
    noise = np.random.default_rng(0).normal(size=600)
    healthy = xr.Dataset({"second": ("window", noise[:500])})
    watched = xr.Dataset({"second": ("window", noise[500:] * 0.1 + np.linspace(5.0, top, 100))})
    ax = ns.plot.alarm(ns.measured.alarm(healthy, watched))
    ax.get_figure(root=True).canvas.draw()
    low, high = ax.get_ylim()
    ticks = zip(ax.get_yticks(), ax.yaxis.get_majorticklabels(), strict=True)
    told = [(place, text.get_text()) for place, text in ticks if low <= place <= high]
    assert len(told) >= least
    assert all(float(text) == place for place, text in told)
    assert not any(text.get_text() for text in ax.yaxis.get_minorticklabels())
