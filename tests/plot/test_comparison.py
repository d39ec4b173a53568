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


def late_record(run, offset):
    """A record of ten periods of a run, whose clock began at another time."""
    part = run.isel(time=slice(3000, 4001))
    times = part["time"].values + offset
    marks = np.arange(30, 40) * np.pi + offset
    record = ns.measured.from_arrays({"x": part["x"].values}, times=times, marks=marks)
    return record.assign_coords(time=record["time"].drop_attrs())


def test_histories_are_aligned_by_their_marks(run, ax):
    record = late_record(run, -50.0)
    ns.plot.comparison(run, record, "time", "x", ax=ax)
    drawn = lines(ax)
    rig, model = drawn["measured"], drawn["computed"]
    here = (model.get_xdata() > rig.get_xdata()[0]) & (model.get_xdata() < rig.get_xdata()[-1])
    assert here.sum() > 990
    at_samples = np.interp(model.get_xdata()[here], rig.get_xdata(), rig.get_ydata())
    np.testing.assert_allclose(model.get_ydata()[here], at_samples, atol=1e-3)
    assert ax.get_xlabel() == "time of the record"
    low, high = ax.get_xlim()
    assert low >= rig.get_xdata()[0] and high <= rig.get_xdata()[-1]


def test_histories_are_folded_by_phase(run, ax):
    record = late_record(run, 17.0).assign_coords()
    record["time"].attrs["units"] = "s"  # a phase has no unit of time
    settled = run.isel(time=slice(3000, None))
    ns.plot.comparison(settled, record, "time", "x", align="phase", ax=ax)
    assert ax.get_xlabel() == "phase [periods since the mark]" and ax.get_xlim() == (0.0, 1.0)
    for line in ax.lines:
        phase, x = line.get_xdata(), line.get_ydata()
        there = np.isfinite(phase)
        assert (phase[there] >= 0.0).all() and (phase[there] <= 1.0).all()
        ahead = np.diff(phase)[np.isfinite(np.diff(phase))]
        assert (ahead >= 0.0).all()  # no line leads back from 1 to 0
        first = settled["x"].values[:101]
        expected = np.interp(phase[there], np.linspace(0.0, 1.0, 101), first)
        np.testing.assert_allclose(x[there], expected, atol=1e-3)


def test_histories_as_they_are(run, ax):
    ns.plot.comparison(run, late_record(run, -50.0), "time", "x", align="time", ax=ax)
    np.testing.assert_array_equal(lines(ax)["computed"].get_xdata()[-1], run["time"][-1])


def test_what_cannot_be_aligned_is_refused(run, record, ax):
    record = record.assign_coords(time=record["time"].drop_attrs())
    with pytest.raises(OptionError, match=r"align = 'marks'.*mark"):
        ns.plot.comparison(run, record, "time", "x", align="marks", ax=ax)
    with pytest.raises(OptionError, match="give x='time'"):
        ns.plot.comparison(run, record, "x", "vx", align="phase", ax=ax)
    with pytest.raises(OptionError, match="measured has no marks and no period"):
        ns.plot.comparison(run, record.drop_vars("mark_time"), "time", "x", align="phase", ax=ax)


def test_spectra_are_compared_in_decibels(run, ax):
    found = ns.power_spectrum(run, "x", transient=40)
    tenth = found.assign(amplitude=found["amplitude"] / 10.0)
    tenth = tenth.assign(amplitude=tenth["amplitude"].assign_attrs(found["amplitude"].attrs))
    ns.plot.comparison(found, tenth, "harmonic", "amplitude", ax=ax)
    model, rig = lines(ax)["computed"].get_ydata(), lines(ax)["measured"].get_ydata()
    assert model.max() == pytest.approx(20.0 * np.log10(float(found["amplitude"].max())))
    assert model.max() - rig.max() == pytest.approx(20.0)
    assert model.max() - min(model.min(), rig.min()) <= 120.0 + 1e-9
    assert lines(ax)["computed"].get_linestyle() == "-" and "dB re 1" in ax.get_ylabel()
    power = found.assign(power_density=found["power_density"] / 10.0)
    power["power_density"].attrs = found["power_density"].attrs
    axes = ns.plot.comparison(found, power, "frequency", "power_density")
    assert lines(axes)["computed"].get_ydata().max() - lines(axes)[
        "measured"
    ].get_ydata().max() == (pytest.approx(10.0))


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


def test_what_was_measured_has_one_colour_and_is_seen_below_a_curve_that_agrees(run, record, ax):
    ns.plot.comparison(run, record, "x", "vx", ax=ax)
    assert lines(ax)["measured"].get_linewidth() > 2.0 * lines(ax)["computed"].get_linewidth()
    points = ns.measured.section(record)
    spectra = [ns.power_spectrum(each, "x") for each in (run, record)]
    spectra[1]["amplitude"].attrs = spectra[0]["amplitude"].attrs
    spectra[1]["frequency"].attrs = spectra[0]["frequency"].attrs
    others = [
        ns.plot.comparison(points, points, "x", "vx"),
        ns.plot.comparison(*spectra, "frequency", "amplitude"),
    ]
    colours = {lines(each)["measured"].get_color() for each in (ax, *others)}
    assert len(colours) == 1
