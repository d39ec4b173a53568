import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.errors import OptionError
from nonsmooth.plot.trace import DENSE


def test_states_go_through_their_events(bouncing, ax):
    ns.plot.phase_portrait(bouncing, "h", "u", ax=ax)
    (line,) = ax.lines
    root2 = np.sqrt(2.0)
    assert line.get_xdata() == pytest.approx([1, 1, 1, 0.5, 0, 0, *bouncing["h"].values[2:]])
    assert line.get_ydata()[4:6] == pytest.approx([-root2, root2 / 2])
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("height [m]", "velocity [m/s]")


def test_jumps_are_no_part_of_a_mode(bouncing, ax):
    ns.plot.phase_portrait(bouncing, "h", "u", ax=ax, phases=True)
    flight, jump = ax.lines
    root2 = np.sqrt(2.0)
    gap = np.flatnonzero(np.isnan(flight.get_ydata()))
    assert flight.get_ydata()[gap - 1] == pytest.approx(-root2)
    assert flight.get_ydata()[gap + 1] == pytest.approx(root2 / 2)
    assert jump.get_label() == "jump"
    assert jump.get_ydata() == pytest.approx([-root2, root2 / 2])


def test_modes_of_the_mole(mole, ax):
    """In contact the mass is on the slider, which rounding must not turn into jumps."""
    ns.plot.phase_portrait(mole, "p", "y", ax=ax, phases=True)
    labels = [line.get_label() for line in ax.lines]
    assert labels == ["no contact", "contact", "progression"]
    colours = [line.get_color() for line in ax.lines]
    assert colours == list(ns.plot.mode_colours(mole).values())
    length = [np.count_nonzero(np.isfinite(line.get_xdata())) for line in ax.lines]
    points = mole.sizes["time"] + 2 * mole.sizes["event"]
    changes = np.count_nonzero(mole["event_from"].values != mole["event_to"].values)
    # each point belongs to one mode; the start is there twice, its first point alone
    assert sum(length) <= points
    assert sum(length) >= points - changes


def test_outputs_take_both_to_the_samples(mole, ax):
    ns.plot.phase_portrait(mole, "x", "y", ax=ax, time_range=(0.0, 100.0))
    samples = mole.sel(time=slice(0.0, 100.0))
    x, y = ax.lines[0].get_data()
    np.testing.assert_array_equal(x[:-1], samples["x"])
    np.testing.assert_array_equal(y[:-1], samples["y"])


def test_unknown_variable(mole):
    with pytest.raises(OptionError, match="did you mean"):
        ns.plot.phase_portrait(mole, "p", "slider_forces")


def test_many_points_are_thinned_or_an_image(ax):
    """A slow motion loses the points that no picture shows; a wild one becomes an image."""
    slow = ns.simulate(ns.models.moling(), periods=2, samples_per_period=50_000)
    ns.plot.phase_portrait(slow, "p", "y", ax=ax)
    (line,) = ax.lines
    assert line.get_xdata().size < slow.sizes["time"] / 2
    assert line.get_xdata().max() == slow["p"].values.max()
    wild = ns.simulate(ns.models.moling(b=0.19), periods=300, samples_per_period=100)
    ns.plot.phase_portrait(wild, "p", "y", ax=ax)
    assert wild.sizes["time"] > DENSE
    assert ax.lines[1].get_rasterized()
