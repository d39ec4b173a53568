"""Orbits, cascades and statistics: what is drawn, where, and with which labels."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import LogNorm

import nonsmooth as ns


@pytest.fixture(scope="module")
def run():
    return ns.simulate(ns.models.rotor(eta=3.0), periods=60)


@pytest.fixture(scope="module")
def in_si(run):
    """The same in millimetres and seconds, as a rig's data come."""
    scaled = run.copy()
    for name in ("x", "y", "sx", "sy"):
        attrs = {"long_name": f"displacement {name}", "units": "mm"}
        scaled[name] = (run[name].dims, 0.5 * run[name].values, attrs)
    seconds = {"units": "s"}
    for name in ("time", "phase"):
        scaled[name] = ("time", 0.011 * run[name].values, run[name].attrs | seconds)
    scaled["event_time"] = ("event", 0.011 * run["event_time"].values, seconds)
    for name in ("state_before", "state_after"):
        scaled[name] = (run[name].dims, 0.5 * run[name].values, run[name].attrs)
    return scaled.assign_attrs(period=0.011 * run.attrs["period"])


@pytest.fixture(scope="module")
def spectra():
    system = ns.models.rotor()
    return ns.waterfall(system, "eta", np.linspace(2.0, 3.0, 5), ("x", "y"), record=12)


def by_label(ax):
    return {line.get_label(): line for line in ax.lines}


def test_orbit(run, ax):
    ns.plot.orbit(run, ax=ax, ring=("sx", "sy"), clearance=1.0)
    lines = by_label(ax)
    assert ax.get_aspect() == 1.0
    assert {"free", "sx, sy", "clearance", "every period"} <= set(lines)
    assert np.hypot(*lines["clearance"].get_data()) == pytest.approx(1.0, abs=1e-14)
    marks = np.array(lines["every period"].get_data())
    np.testing.assert_allclose(marks, [run["x"][::100], run["y"][::100]], atol=1e-12)
    ring = np.array(lines["sx, sy"].get_data())
    assert ring[0].max() == pytest.approx(float(run["sx"].max()), abs=1e-3)


def test_marks_between_samples(ax):
    """Where no sample is at the beginning of a period, the mark lies on the line between."""
    system = ns.models.rotor(eta=3.0)
    run = ns.simulate(system, times=np.arange(0.0, 60.0, 0.01))
    fine = ns.simulate(system, periods=28)
    ns.plot.orbit(run, ax=ax, time_range=(20.0, 58.0))
    x, y = by_label(ax)["every period"].get_data()
    first = int(np.ceil(20.0 / run.attrs["period"]))
    wanted = fine.isel(time=slice(100 * first, None, 100))
    np.testing.assert_allclose(x, wanted["x"][: len(x)], atol=2e-4)
    np.testing.assert_allclose(y, wanted["y"][: len(y)], atol=2e-4)


def test_orbit_in_millimetres(in_si, ax):
    ns.plot.orbit(in_si, ax=ax, ring=("sx", "sy"), clearance=0.5, centre=(0.1, 0.0))
    assert ax.get_xlabel() == "displacement x [mm]"
    assert ax.get_ylabel() == "displacement y [mm]"
    assert len(by_label(ax)["every period"].get_xdata()) == 61
    x, y = by_label(ax)["clearance"].get_data()
    assert np.hypot(x - 0.1, y) == pytest.approx(0.5, abs=1e-14)


def test_spectra_in_millimetres(in_si, ax):
    found = ns.full_spectrum(in_si, "x", "y")
    ns.plot.spectrum(found, ax=ax)
    assert ax.get_xlabel() == "frequency [Hz]"
    assert ax.get_ylabel() == "amplitude of x + i y [mm]"
    low, high = ax.get_xlim()
    assert low == -high


def test_spectrum_over_orders(run, ax):
    ns.plot.spectrum(ns.full_spectrum(run, "x", "y"), ax=ax, over="harmonic")
    assert ax.get_xlabel() == "frequency over that of the forcing"
    assert ax.get_xlim() == pytest.approx((-5.0, 5.0))
    marks = sorted(line.get_xdata()[0] for line in ax.lines[:-1])
    assert marks == pytest.approx(np.arange(-5.0, 6.0))
    with pytest.raises(ns.OptionError, match="over = 'order'"):
        ns.plot.spectrum(ns.full_spectrum(run, "x", "y"), ax=ax, over="order")


def test_cascade(spectra, ax):
    """Every line stands at its value, and is as high as its amplitude."""
    ns.plot.waterfall(spectra, ax=ax, over="harmonic", height=0.5, orders=False)
    lines = {round(float(line.get_ydata().min()), 3): line for line in ax.lines}
    values = spectra["parameter"].values
    assert len(ax.lines) == 5
    amplitude = spectra["amplitude"].where(spectra["harmonic"] != 0.0, 0.0)
    amplitude = amplitude.sel(harmonic=slice(-5.2, 5.2))
    largest = float(amplitude.max())
    for k, value in enumerate(values):
        line = lines[min(lines, key=lambda low, value=value: abs(low - value))]
        height = float(np.ptp(line.get_ydata()))
        here = float(amplitude[k].max() - amplitude[k].min())
        assert height == pytest.approx(0.5 * here / largest, abs=1e-9)


def test_a_cascade_says_how_many_spectra_it_draws(spectra, ax):
    """Of 120 spectra one in three, as more than 50 lines are not told apart."""
    many = spectra.isel(parameter=np.arange(120) % 5)
    many = many.assign_coords(parameter=np.linspace(2.0, 3.0, 120))
    ns.plot.waterfall(many, ax=ax, orders=False)
    assert len(ax.lines) == 40
    assert "(40 of 120 drawn" in ax.get_ylabel()
    few = ns.plot.waterfall(spectra, orders=False)
    assert "drawn" not in few.get_ylabel()


@pytest.mark.parametrize("kind", ["cascade", "map"])
@pytest.mark.parametrize("over", ["frequency", "harmonic"])
def test_orders_reach_over_the_whole_axis(spectra, kind, over):
    """A speed of eta has the order n at n eta/(2 pi), also beyond the first and last spectrum."""
    ax = ns.plot.waterfall(spectra, kind=kind, over=over)
    marks = [line for line in ax.lines if line.get_linestyle() == "--"]
    assert len(marks) == 10
    for line, order in zip(marks, [-5, -4, -3, -2, -1, 1, 2, 3, 4, 5], strict=True):
        x, y = line.get_data()
        assert (y[0], y[-1]) == pytest.approx(ax.get_ylim(), rel=1e-12)
        wanted = order * (y / (2.0 * np.pi) if over == "frequency" else np.ones(y.size))
        np.testing.assert_allclose(x, wanted, rtol=1e-9)


@pytest.mark.parametrize("two_sided", [False, True])
@pytest.mark.parametrize(
    ("first", "highest", "ends"),
    [
        (1.2, 1.0, "top right"),
        (1.2, 3.0, "top right"),
        (0.2, None, "top right"),
        (1.9, None, "top"),
    ],
)
def test_names_of_orders_are_apart(ax, two_sided, first, highest, ends):
    """At speeds up to 2 the order n is at n 2/(2 pi) at most, and beyond the axis above that."""
    speeds = np.linspace(first, 2.0, 4)
    harmonic = np.arange(-15.0 if two_sided else 0.0, 16.0)
    data = xr.Dataset(
        {
            "amplitude": (("parameter", "harmonic"), np.ones((4, harmonic.size))),
            "period": ("parameter", 2.0 * np.pi / speeds),
        },
        {"parameter": speeds, "harmonic": harmonic},
    )
    data = data.assign_coords(frequency=data["harmonic"] / data["period"])
    ns.plot.waterfall(data, ax=ax, highest=highest)
    ax.figure.draw_without_rendering()
    names = {text.get_text(): text.get_window_extent() for text in ax.texts}
    assert "1X" in names and len(names) > 2
    boxes, inside = list(names.values()), ax.get_window_extent()
    assert not any(one.overlaps(other) for k, one in enumerate(boxes) for other in boxes[:k])
    assert not any(one.overlaps(inside) for one in boxes)
    top, right = (any(getattr(b, s) >= getattr(inside, e) for b in boxes)
                  for s, e in (("y0", "y1"), ("x0", "x1")))  # fmt: skip
    assert (top, right) == ("top" in ends, "right" in ends)


def test_the_highest_order_is_seen_as_a_whole(spectra, ax):
    """The main lobe of the Hann window is two lines wide on each side; 12 periods are recorded."""
    ns.plot.waterfall(spectra, ax=ax, kind="map", over="harmonic", highest=4.0)
    low, high = ax.get_xlim()
    assert -low == high > 4.0 + 1.0 / 12.0
    assert ax.get_xlabel().startswith("order")


@pytest.mark.parametrize("kind", ["cascade", "map"])
def test_a_waterfall_says_how_many_motions_show_no_period(spectra, kind):
    plain = spectra["parameter"].attrs["long_name"]
    for periods, text in (([1, 0, 2, 0, 0], " (3 of 5 without a period)"), ([1, 1, 2, 3, 1], "")):
        data = spectra.assign(motion_period=("parameter", periods))
        label = ns.plot.waterfall(data, kind=kind).get_ylabel().replace("\n", " ")
        assert label == plain + text
    tracked = ns.plot.waterfall(spectra.drop_vars("motion_period"), kind=kind)
    assert tracked.get_ylabel() == plain


def test_map_of_colours(spectra, ax):
    ns.plot.waterfall(spectra, ax=ax, kind="map", over="frequency")
    (mesh,) = ax.collections
    assert isinstance(mesh.norm, LogNorm)
    # the line of the first order lies in the cells of the first order
    line = next(each for each in ax.lines if each.get_xdata()[0] > 0)
    np.testing.assert_allclose(line.get_xdata()[1:-1], spectra["parameter"] / (2 * np.pi))
    corners = mesh.get_coordinates()
    place = int(np.flatnonzero(np.isclose(spectra["harmonic"], 1.0))[0])
    shown = spectra["harmonic"].values[np.abs(spectra["frequency"].values).min(axis=0) >= 0]
    assert corners.shape[0] == 6 and shown[place] == pytest.approx(1.0)
    assert [t.get_text() for t in ax.texts if t.get_text() == "1X"] == ["1X"]


def test_motions_that_ended_early_are_left_out(spectra, ax):
    part = spectra.copy(deep=True)
    part["amplitude"][2] = np.nan
    part["period"][2] = np.nan
    ns.plot.waterfall(part, ax=ax, orders=False)
    assert len(ax.lines) == 4


def test_statistics(ax):
    found = ns.contact_statistics(
        ns.models.rotor(), "eta", [2.1, 2.4, 3.0], of="force", transient=30, record=10
    )
    ns.plot.statistics(found, "force", ax=ax)
    lines = by_label(ax)
    np.testing.assert_array_equal(lines["largest"].get_ydata(), found["force_max"])
    np.testing.assert_array_equal(lines["rms"].get_ydata(), found["force_rms"])
    assert ax.get_ylabel() == "force on the ring"
    first = ax.get_legend().get_texts()[0]
    assert first.get_text() == "5 to 95 %"


@pytest.mark.slow
def test_run_up_and_run_down_on_one_axes(ax):
    for text in ("2 + t/300", "3 - t/300"):
        system = ns.models.rotor()
        slow = ns.System(**{**system.__getstate__(), "slow": {"eta": text}, "equations": None})
        found = ns.period_statistics(ns.simulate(slow, t_end=300), "x", periods=4)
        ns.plot.statistics(found, "x_amplitude", ax=ax)
    assert [line.get_label() for line in ax.lines] == ["eta rises", "eta falls"]
    assert ax.get_xlabel() == "speed over the natural frequency"
    assert np.all(np.diff(ax.lines[1].get_xdata()) < 0.0)


@pytest.mark.parametrize("label", [None, "damped"])
@pytest.mark.parametrize("variable", ["a", "a_max"])
def test_no_entry_of_a_legend_of_statistics_stands_twice(ax, variable, label):
    for name in ("a", "b"):
        words = {"long_name": f"force of {name}"}
        data = xr.Dataset(
            {
                f"{name}_{key}": ("period", np.arange(3.0), words)
                for key in ("min", "max", "mean", "rms", "in_contact")
            }
            | {"Omega": ("period", np.arange(3.0))},
            attrs={"slow": "Omega"},
        )
        ns.plot.statistics(data, variable.replace("a", name, 1), ax=ax, label=label)
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert len(texts) == len(set(texts)) == (10 if variable == "a" else 2)
    if variable == "a" and label is None:
        assert "force of b, largest" in texts


@pytest.mark.parametrize(
    ("draw", "text"),
    [
        (lambda run, spectra, ax: ns.plot.orbit(run, "x", "z", ax=ax), "unknown variable 'z'"),
        (lambda run, spectra, ax: ns.plot.orbit(run, clearance=0, ax=ax), "must be positive"),
        (lambda run, spectra, ax: ns.plot.waterfall(run, ax=ax), "give it a result of waterfall"),
        (
            lambda run, spectra, ax: ns.plot.waterfall(spectra, kind="heap"),
            "kind = .heap.: give one",
        ),
        (lambda run, spectra, ax: ns.plot.waterfall(spectra, kind="map", height=1), "leave it out"),
        (lambda run, spectra, ax: ns.plot.waterfall(spectra, highest=0), "must be positive"),
        (lambda run, spectra, ax: ns.plot.statistics(run, "x"), "neither 'parameter' nor"),
    ],
)
def test_wrong_options(run, spectra, ax, draw, text):
    with pytest.raises(ns.OptionError, match=text):
        draw(run, spectra, ax)


def test_single_values_between_missing_ones_are_seen(ax):
    values = [1.0, np.nan, 2.0, 3.0, np.nan, 4.0]
    data = xr.Dataset({"a": ("parameter", values)}, {"parameter": np.arange(6.0)})
    ns.plot.statistics(data, "a", ax=ax)
    assert ax.lines[0].get_markevery() == [0, 5]
