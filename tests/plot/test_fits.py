"""Pictures of fits: what is drawn is what the result has."""

from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns

TIMES = np.linspace(0.0, 12.0, 240)


@pytest.fixture(scope="module")
def found():
    """A driven oscillator, of which stiffness, damping and a factor of the sensor are found."""
    system = ns.System(
        states=["x", "v"], parameters={"k": 2.0, "c": 0.2}, period="2",
        equations={"x": "v", "v": "cos(pi*t) - k*x - c*v"},
    )  # fmt: skip
    run = ns.simulate(system, {"x": 0.5, "v": 0.0}, times=TIMES)
    noise = 0.02 * np.random.default_rng(1).standard_normal((2, TIMES.size))
    record = xr.Dataset(
        {"a": ("time", 1.1 * run["x"].values + noise[0]),
         "b": ("time", run["v"].values + noise[1])},
        {"time": TIMES},
    )  # fmt: skip
    return ns.fit(
        system, record, {"k": (1.0, 3.0), "c": (0.05, 0.5)}, {"a": "x", "b": "v"},
        gain={"a": (0.5, 2.0)}, starts=1, bootstrap=20,
    )  # fmt: skip


def labelled(ax, label):
    """The one artist with a label."""
    (artist,) = [each for each in ax.get_children() if each.get_label() == label]
    return artist


@pytest.mark.slow
def test_profiles_pass_through_their_points_and_meet_the_threshold(found):
    panels = ns.plot.profiles(found)
    assert [ax.get_xlabel() for ax in panels] == ["k", "c", "a gain"]
    for ax, name in zip(panels, found["parameter"].values, strict=True):
        one = found.sel(parameter=name)
        curve = labelled(ax, "profile").get_xydata()
        points = one[["profile_value", "profile_rise"]].dropna("profile_point")
        # between points of the curve, 200 of them, a straight line is right to 1e-3
        heights = np.interp(points["profile_value"], *curve.T)
        np.testing.assert_allclose(heights, points["profile_rise"], atol=0.01)
        (height,) = set(labelled(ax, "threshold").get_ydata())
        for end in ("interval_low", "interval_high"):
            # an end is found to 1 % of the threshold
            assert np.interp(float(one[end]), *curve.T) == pytest.approx(height, rel=0.02)
        quadratic = labelled(ax, "quadratic").get_xydata()
        off = float(one["estimate"] + one["standard_error"])
        assert np.interp(off, *quadratic.T) == pytest.approx(1.0, abs=0.01)


def test_some_profiles_in_the_place_of_axes(found):
    figure, axes = ns.plot.print_figure(1, 2, width=16.0)
    panels = ns.plot.profiles(found, ["c", "k"], ax=axes[1])
    assert [ax.get_xlabel() for ax in panels] == ["c", "k"]
    figure.draw_without_rendering()
    assert all(ax.get_window_extent().x0 > figure.bbox.x1 / 2 for ax in panels)


def test_bounds_are_hatched_where_they_cut_an_interval_off(found):
    cut = found.sel(parameter=["k"]).copy(deep=True)
    cut["upper_bound"][0] = float(cut["interval_high"][0])
    (ax,) = ns.plot.profiles(cut)
    assert labelled(ax, "beyond the bounds").get_hatch()


def test_profiles_that_are_not_there(found):
    lost = found.copy(deep=True)
    lost["profile_value"][:] = np.nan
    with pytest.raises(ns.OptionError, match="no profile of 'k' was found"):
        ns.plot.profiles(lost)
    with pytest.raises(
        ns.OptionError, match=r"parameters: unknown parameter 'q' \(known: a gain, c, k\)"
    ):
        ns.plot.profiles(found, "q")


def panels_by_labels(axes):
    """Panels of a corner, row by row."""
    rows = {1: (0,), 3: (0, 1, 1), 6: (0, 1, 1, 2, 2, 2)}[len(axes)]
    return {
        (row, rows[:k].count(row)): ax for k, (row, ax) in enumerate(zip(rows, axes, strict=True))
    }


def test_ellipses_are_those_of_the_covariance(found):
    panels = panels_by_labels(ns.plot.corner(found))
    assert (panels[2, 0].get_xlabel(), panels[2, 0].get_ylabel()) == ("k", "a gain")
    names = found["parameter"].values
    for (i, j), ax in panels.items():
        if i == j:
            continue
        pair = [names[j], names[i]]
        inverse = np.linalg.inv(found["covariance"].sel(parameter=pair, parameter_0=pair).values)
        edges = [line.get_xydata() for line in ax.lines if len(line.get_xydata()) == 200]
        assert len(edges) == 2
        # chi square of two degrees: the part 1 - exp(-r / 2) lies within the level r
        for edge, part in zip(edges, (0.95, 0.6827), strict=True):
            off = edge - found["estimate"].sel(parameter=pair).values
            levels = np.einsum("ki,ij,kj->k", off, inverse, off)
            np.testing.assert_allclose(1.0 - np.exp(-levels / 2.0), part, atol=1e-4)


@pytest.mark.slow
def test_a_corner_has_the_draws_of_bootstrap_and_posterior(found):
    with pytest.warns(ns.ResultWarning, match="chain is too short"):  # long enough to be drawn
        posterior = ns.posterior(found, draws=20, transient=0)
    panels = panels_by_labels(ns.plot.corner(found, ["k", "c"], posterior=posterior))
    dots = labelled(panels[1, 0], "bootstrap").get_xydata()
    np.testing.assert_array_equal(dots, found["bootstrap_estimate"].sel(parameter=["k", "c"]))
    dots = labelled(panels[1, 0], "posterior").get_xydata()
    assert len(dots) == posterior.sizes["walker"] * 20
    with pytest.raises(ns.OptionError, match="posterior: give a result of posterior with the"):
        ns.plot.corner(found, posterior=found)


@pytest.mark.parametrize("names", [["k"], ["k", "c"]])
def test_the_legend_of_a_corner_names_all_that_is_drawn(found, names):
    rng = np.random.default_rng(2)
    values = rng.normal(found["estimate"].sel(parameter=names), 0.01, (9, 4, len(names)))
    posterior = xr.Dataset(
        {"posterior_value": (("draw", "walker", "parameter"), values)}, {"parameter": names}
    )
    panels = ns.plot.corner(found, names, posterior=posterior)
    said = panels[0].figure.legends[0].get_texts()
    pairs = ["its 68 % and 95 %", "estimate"] * (len(names) > 1)
    assert sorted(text.get_text() for text in said) == sorted([
        "95 % interval of the fit", "posterior", "bootstrap", "normal density of the fit", *pairs
    ])  # fmt: skip
    line = labelled(panels[0], "normal density of the fit")
    across, density = line.get_xydata().T
    assert across[density.argmax()] == pytest.approx(float(found["estimate"].sel(parameter="k")),
                                                     abs=0.01 * np.ptp(across))  # fmt: skip


@pytest.mark.few(2)
@pytest.mark.parametrize("deviation", [0.0003, 0.0008, 0.0012, 0.002])
@pytest.mark.parametrize("inches", [2.2, 3.0, 4.0])
def test_numbers_below_a_small_corner_do_not_touch(found, deviation, inches):
    narrow = found.copy(deep=True)
    narrow = narrow.drop_vars("bootstrap_estimate")  # the view is that of the density
    narrow["estimate"][:2], narrow["standard_error"][:2] = [2.15, 0.15], deviation
    figure, ax = plt.subplots(figsize=(inches, inches))
    panels = panels_by_labels(ns.plot.corner(narrow, ["k", "c"], ax=ax))
    figure.canvas.draw()
    for panel in (panels[1, 0], panels[1, 1]):
        low, high = panel.get_xlim()
        boxes = [
            label.get_window_extent()
            for label, place in zip(panel.get_xticklabels(), panel.get_xticks(), strict=True)
            if low <= place <= high
        ]
        assert boxes
        for left, right in pairwise(boxes):
            assert left.x1 < right.x0
    plt.close(figure)


def test_a_parameter_that_is_not_determined_is_drawn_within_its_bounds(found):
    unclear = found.copy(deep=True)
    unclear["standard_error"][0] = 1e6
    (ax,) = ns.plot.corner(unclear, "k")
    low, high = ax.get_xlim()
    assert 0.9 < low < 1.0 and 3.0 < high < 3.1


def test_dots_of_a_phase_lie_where_the_forcing_says(found):
    ax = ns.plot.fit(found, "b", align="phase", periods=2)
    dots = labelled(ax, "measured").get_xydata()
    kept = ~found["held_back"].sel(channel="b").values
    # the period of the forcing is 2, so two of them are 4
    np.testing.assert_allclose(dots[:, 0], np.mod(TIMES[kept], 4.0) / 2.0, atol=1e-12)
    np.testing.assert_array_equal(dots[:, 1], found["measured"].sel(channel="b").values[kept])
    assert len(labelled(ax, "held back").get_xydata()) == np.count_nonzero(~kept)
    curve = labelled(ax, "fitted").get_xydata()
    gaps = np.isnan(curve[:, 0])
    assert gaps.sum() == 3  # at 4, 8 and 12, where the record ends
    assert curve[:-1][gaps[1:], 0].tolist() == [2.0] * 3
    assert curve[1:][gaps[:-1], 0].tolist() == [0.0] * 3


def test_axes_have_the_units_of_the_record(found):
    ax = ns.plot.fit(found.assign(channel_units=("channel", ["mm", "V"])), "b")
    assert ax.get_ylabel() == "b [V]"
    (panel,) = [each for each in ax.figure.axes if each.get_ylabel().startswith("residual")]
    assert panel.get_ylabel().split() == ["residual", "[V]"]
    assert ns.plot.fit(found.drop_vars("channel_units"), "b").get_ylabel() == "b"
    quantities = found.assign(channel_quantity=("channel", ["displacement", "speed b"]))
    assert ns.plot.fit(quantities, "a").get_ylabel() == "a: displacement"
    assert ns.plot.fit(quantities, "b").get_ylabel() == "speed b"
    timed = found.assign(channel_units=("channel", ["mm", "V"]))
    timed = timed.assign_coords(time=timed["time"].assign_attrs(units="s"))
    ax = ns.plot.fit_spectra(timed, "b")
    assert ax.get_xlabel() == "frequency [Hz]"
    assert ax.get_ylabel() == "power density [dB re 1 V^2/Hz]"


@pytest.mark.slow
def test_marks_of_the_record_come_before_the_forcing(found):
    record = ns.measured.from_arrays(
        {"a": found["measured"].sel(channel="a").values}, times=TIMES, marks=[1.5, 4.0, 6.5, 9.0]
    )
    system = ns.System.from_toml(found.attrs["system"])
    again = ns.fit(system, record, {"k": (1.0, 3.0)}, {"a": "x"}, starts=1)
    np.testing.assert_array_equal(again["mark_time"], [1.5, 4.0, 6.5, 9.0])
    dots = labelled(ns.plot.fit(again, align="phase"), "measured").get_xydata()
    kept = ~again["held_back"].values[0]
    np.testing.assert_allclose(dots[:, 0], np.mod((TIMES[kept] - 1.5) / 2.5, 1.0), atol=1e-12)


def test_a_phase_without_marks_is_refused(found):
    with pytest.raises(ns.OptionError, match="align = 'phase': the record has no two marks"):
        ns.plot.fit(found.isel(mark=slice(1)), align="phase")
    with pytest.raises(ns.OptionError, match="periods = 2: give a number of at least 1, together"):
        ns.plot.fit(found, periods=2)
    with pytest.raises(ns.OptionError, match="align = 'mark'"):
        ns.plot.fit(found, align="mark")


def test_spectra_have_the_power_of_what_they_show(found):
    """Parseval: the integral of a power density is the mean square."""
    ax = ns.plot.fit_spectra(found, "b", segments=1)
    kept = ~found["held_back"].sel(channel="b").values
    for name in ("measured", "fitted", "residual"):
        frequency, level = labelled(ax, name).get_xydata().T
        power = np.sum(10.0 ** (level / 10.0)) * (frequency[1] - frequency[0])
        values = found[name].sel(channel="b").values[kept]
        # one Hann window weighs the middle most: of a motion of six periods, and of noise, whose
        # sum of squares under a window has a spread of about 0.12, it keeps the power to a third
        assert power == pytest.approx(values.var(), rel=0.35)


def test_noise_lies_at_the_level_of_a_white_residual(found):
    ax = ns.plot.fit_spectra(found, "b", segments=8)
    (level,) = set(labelled(ax, "noise").get_ydata())
    step = TIMES[1] - TIMES[0]
    assert 10.0 ** (level / 10.0) == pytest.approx(2.0 * step * float(found["noise"][1]) ** 2)
    residual = 10.0 ** (labelled(ax, "residual").get_ydata() / 10.0)
    # a mean of some 30 values, each of which has a spread of about 1/sqrt(8)
    assert residual.mean() == pytest.approx(10.0 ** (level / 10.0), rel=0.3)


def test_spectra_of_what_has_none(found):
    uneven = found.assign_coords(time=found["time"].values ** 1.1)
    with pytest.raises(ns.OptionError, match="the times of the record are not even"):
        ns.plot.fit_spectra(uneven)
    holes = found.copy(deep=True)
    holes["residual"][:, ::20] = np.nan
    with pytest.raises(ns.OptionError, match="a spectrum needs 32 samples in a row"):
        ns.plot.fit_spectra(holes)


def test_times_between_events_are_drawn():
    """Bounces of a ball, each flight 0.8 times as long as the one before."""
    ball = ns.System(
        states=["x", "v"], parameters={"r": 0.8},
        modes={"flight": ns.Mode({"x": "v", "v": "-2"}, exits=[
            ns.Exit("x", reset={"v": "-r*v"}, name="bounce")])},
    )  # fmt: skip
    flights = 2.0 * 0.8 ** np.arange(1, 8)
    instants = 1.0 + np.concatenate([[0.0], np.cumsum(flights)])
    record = xr.Dataset({"hit": ("bounces", instants)})
    found = ns.fit(
        ball, record, {"r": (0.75, 0.85)}, {"hit": "bounce"}, initial={"x": 1.0}, noise=1e-3,
        segments=1, hold_back=0.2, starts=1,
    )  # fmt: skip
    ax = ns.plot.fit(found)
    np.testing.assert_allclose(labelled(ax, "measured").get_xydata()[:, 1], flights)
    np.testing.assert_allclose(labelled(ax, "fitted").get_xydata()[:, 1], flights, rtol=2e-3)
    assert ax.get_ylabel().split() == ["hit:", "time", "since", "the", "one", "before"]
    with pytest.raises(ns.OptionError, match="hit has instants of events; give align='time'"):
        ns.plot.fit(found, align="phase")
    with pytest.raises(ns.OptionError, match="no samples to draw"):
        ns.plot.fit_spectra(found)


def test_the_fitted_line_is_broken_where_samples_are_left_out():
    times = np.linspace(0.0, 10.0, 201)
    values = np.exp(-0.3 * times) + 0.01 * np.random.default_rng(1).standard_normal(201)
    values[80:120] = np.nan
    decay = ns.System(states=["x"], parameters={"k": 0.2}, equations={"x": "-k*x"})
    record = xr.Dataset({"x": ("time", values)}, {"time": times})
    found = ns.fit(decay, record, {"k": (0.1, 1.0)}, initial={"x": 1.0}, starts=1)
    curve = labelled(ns.plot.fit(found), "fitted").get_xydata()
    (gap,) = np.flatnonzero(np.isnan(curve[:, 1]))
    assert curve[gap - 1, 0] == times[79] and curve[gap + 1, 0] == times[120]
