import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.errors import OptionError

SYSTEM = ns.System(
    name="spring",
    states=["x", "vx"],
    parameters={"w": 2.0},
    period="2*pi/w",
    equations={"x": "vx", "vx": "cos(w*t) - 0.5*vx - x"},
)


@pytest.fixture(scope="module")
def run():
    return ns.simulate(SYSTEM, periods=60)


@pytest.fixture(scope="module")
def record(run):
    found = ns.measured.from_arrays({"x": run["x"]}, times=run["time"], marks=np.arange(60) * np.pi)
    return ns.measured.velocities(found)


def lines(ax):
    return {line.get_label(): line for line in ax.lines}


def test_orbits(run, record, ax):
    ns.plot.comparison(run, record, "x", "vx", ax=ax)
    drawn = lines(ax)
    assert list(drawn) == ["measured", "computed"]
    np.testing.assert_array_equal(drawn["measured"].get_ydata(), record["vx"])
    assert drawn["computed"].get_xdata().size >= run.sizes["time"]
    assert drawn["computed"].get_color() != drawn["measured"].get_color()
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["measured", "computed"]


def test_histories(run, record, ax):
    measured = record.assign_coords(time=record["time"].drop_attrs())
    ns.plot.comparison(run, measured, "time", "x", ax=ax, labels=("model", "rig"), legend=False)
    assert list(lines(ax)) == ["rig", "model"] and ax.get_legend() is None
    np.testing.assert_array_equal(lines(ax)["rig"].get_xdata(), record["time"])


def test_sections(record, ax):
    points = ns.measured.section(record)
    computed = ns.stroboscopic_map(SYSTEM, record=40)
    ns.plot.comparison(computed, points, "x", "vx", ax=ax)
    np.testing.assert_array_equal(lines(ax)["measured"].get_xdata(), points["x"])
    np.testing.assert_array_equal(lines(ax)["computed"].get_ydata(), computed["vx"])


def test_diagrams(record, ax):
    model = ns.bifurcation_diagram(SYSTEM, "w", [1.5, 2.0], transient=30, record=10)
    shorter = record.isel(mark=slice(0, 20))
    rig = ns.measured.diagram([record, shorter], values=[2.0, 2.1])
    ns.plot.comparison(model, rig, "parameter", "x", ax=ax)
    across = lines(ax)["measured"].get_xdata()
    assert np.unique(across).tolist() == [2.0, 2.1]
    assert across.size == int(rig["n_points"].sum())  # what is nan is left out
    assert lines(ax)["computed"].get_xdata().size == 20


def test_measured_motions_alone(record, ax):
    ns.plot.phase_portrait(record, "x", "vx", ax=ax)
    np.testing.assert_array_equal(ax.lines[0].get_xdata(), record["x"])
    ax = ns.plot.time_history(record, ["x", "vx"])
    assert len(ax.lines) == 2
    with pytest.raises(OptionError, match="event log"):
        ns.plot.time_history(record, "x", events=True)
    with pytest.raises(OptionError, match="mode"):
        ns.plot.phase_portrait(record, "x", "vx", phases=True)


def test_wrong_use(run, record, ax):
    points = ns.measured.section(record)
    millimetres = points.assign(x=points["x"].assign_attrs(units="mm"))
    computed = ns.stroboscopic_map(SYSTEM, record=40)
    with pytest.raises(OptionError, match="'x' is in no units as computed and in mm as measured"):
        ns.plot.comparison(computed, millimetres, "x", "vx", ax=ax)
    with pytest.raises(OptionError, match="measured: unknown variable 'w'"):
        ns.plot.comparison(computed.assign(w=computed["x"]), points, "x", "w", ax=ax)
    with pytest.raises(OptionError, match="two results of one kind"):
        ns.plot.comparison(run, points, "x", "vx", ax=ax)
    with pytest.raises(OptionError, match="two results of one kind"):
        ns.plot.comparison(computed, record, "x", "vx", ax=ax)
    with pytest.raises(OptionError, match="over the same points"):
        ns.plot.comparison(run, run, "event_time", "x", ax=ax)
    with pytest.raises(OptionError, match="give a dataset"):
        ns.plot.comparison([1.0], record, "x", "vx", ax=ax)
