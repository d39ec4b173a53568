import numpy as np
import pytest
from matplotlib.colors import to_rgb

import nonsmooth as ns
from nonsmooth.errors import OptionError

ROOT2 = np.sqrt(2.0)


def test_kinks_and_jumps_are_drawn_at_the_event(bouncing, ax):
    """Samples at 0, 1, 2, 2.5 only; the impacts at sqrt(2) would be cut off by a chord."""
    ns.plot.time_history(bouncing, ["h", "u"], ax=ax)
    height, velocity = ax.lines
    assert height.get_xdata() == pytest.approx([0, 0, 0, 1, ROOT2, ROOT2, 2, 2.5])
    assert height.get_ydata()[4:6] == pytest.approx([0.0, 0.0])
    assert velocity.get_ydata()[4:6] == pytest.approx([-ROOT2, ROOT2 / 2])


def test_a_sample_at_an_event_keeps_its_side(bouncing, ax):
    """Times never decrease and the jump is taken once, whichever state the sample holds."""
    time = float(bouncing["event_time"][1])
    run = ns.simulate(ns.models.moling(), periods=1)
    crossing = float(run["event_time"][1])
    run = ns.simulate(ns.models.moling(), times=[0.0, crossing, 2 * crossing])
    ns.plot.time_history(run, "v", ax=ax)
    assert np.all(np.diff(ax.lines[0].get_xdata()) >= 0.0)
    assert time == pytest.approx(ROOT2)


def test_outputs_are_drawn_at_samples(mole, ax):
    ns.plot.time_history(mole, ["x", "v"], ax=ax)
    mass, slider = ax.lines
    np.testing.assert_array_equal(mass.get_xdata(), mole["time"])
    np.testing.assert_array_equal(mass.get_ydata(), mole["x"])
    assert slider.get_xdata().size == mole.sizes["time"] + 2 * mole.sizes["event"]


def test_a_range_is_cut_where_it_says(mole, ax):
    ns.plot.time_history(mole, ["x", "v"], ax=ax, time_range=(800.0, 1200.0))
    assert ax.get_xlim() == (800.0, 1200.0)
    for line, name in zip(ax.lines, ("x", "v"), strict=True):
        assert line.get_xdata()[[0, -1]] == pytest.approx([800.0, 1200.0])
        low, high = mole["time"].searchsorted([800.0, 1200.0])
        inside = mole[name].values[low:high]
        assert set(inside) <= set(line.get_ydata())


def test_a_range_within_one_step_is_a_straight_line(bouncing, ax):
    ns.plot.time_history(bouncing, "u", ax=ax, time_range=(1.1, 1.2))
    assert ax.lines[0].get_ydata() == pytest.approx([-1.1, -1.2])


def test_styles_and_legend(mole, ax):
    """The chapter draws the mass solid and the slider dashed."""
    ns.plot.time_history(mole, ["x", "v"], ax=ax, labels={"x": "mass"})
    assert [line.get_linestyle() for line in ax.lines] == ["-", "--"]
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["mass", "v"]


def test_one_line_needs_no_legend(mole, ax):
    ns.plot.time_history(mole, "x", ax=ax)
    assert ax.get_legend() is None
    assert ax.get_ylabel() == "displacement of the mass"


def test_labels_have_units(bouncing, ax):
    ns.plot.time_history(bouncing, ["h", "u"], ax=ax)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time", "h [m], u [m/s]")


def test_labels_of_the_caller_stay(bouncing, ax):
    ax.set_xlabel("time in s")
    ns.plot.time_history(bouncing, "h", ax=ax)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time in s", "height [m]")


def test_new_axes_belong_to_pyplot(bouncing):
    import matplotlib.pyplot as plt

    assert ns.plot.time_history(bouncing, "h").figure is plt.gcf()


def test_unknown_variable_lists_the_known_ones(mole):
    with pytest.raises(OptionError, match=r"unknown variable 'w' \(known: acceleration, p, q,"):
        ns.plot.time_history(mole, ["x", "w"])


def test_a_diagram_has_no_time():
    columns = ns.bifurcation_diagram(ns.models.soft_impact(), "omega", [0.7], transient=1, record=2)
    with pytest.raises(OptionError, match="no dimension 'time'; give it a run"):
        ns.plot.time_history(columns, "x")


@pytest.mark.parametrize("wrong", ["mode", "state_before", "end_state"])
def test_only_variables_over_time_are_drawn(mole, wrong):
    with pytest.raises(OptionError, match="unknown variable"):
        ns.plot.time_history(mole, wrong)


@pytest.mark.parametrize("wrong", [(3, 2), (1e6, 2e6), (-2, -1), (1,), "ab", 7])
def test_a_range_that_misses_the_run_is_refused(mole, wrong):
    with pytest.raises(OptionError, match="time_range"):
        ns.plot.time_history(mole, "x", time_range=wrong)


def test_no_variables(mole):
    with pytest.raises(OptionError, match="name at least one of"):
        ns.plot.time_history(mole, [])


def test_run_without_samples(mole):
    with pytest.raises(OptionError, match="no samples"):
        ns.plot.time_history(mole.isel(time=slice(0)), "x")


def test_motions_in_si_units_are_drawn(ax):
    """Their times are converted, and the clock of the run is not told any more."""
    rig = ns.models.MolingRig(
        mass=0.9, stiffness=7.05e5, damping=79.6, friction_force=200.0, static_force=30.0,
        dynamic_force=60.0, angular_frequency=88.5, gap=6e-6,
    )  # fmt: skip
    run = rig.to_si(ns.simulate(rig.system(), periods=5))
    assert run.sizes["event"] > 2
    ns.plot.time_history(run, "x", ax=ax)
    assert ax.lines[0].get_xdata().size >= run.sizes["time"]
    assert ax.get_xlabel() == "time [s]"


def sizes_apart(units=True):
    """Curves of a millimetre, of a tenth of a metre per second, and of a hundred radians."""
    tell = {"x": "place [m]", "v": "speed [m/s]", "y": "other place [m]", "w": "turning [rad/s]"}
    rig = ns.System(
        states=["x", "v", "y", "w"],
        equations={"x": "v", "v": "-1e4*x", "y": "0", "w": "0"},
        initial={"x": 1e-3, "y": 5e-3, "w": 100.0},
        describe=tell if units else {},
    )
    return ns.simulate(rig, times=np.linspace(0.0, 0.2, 200))


@pytest.mark.parametrize("draw", [ns.plot.time_history, ns.plot.phases])
@pytest.mark.parametrize("units", [True, False])
def test_small_variables_have_axes_of_their_own(draw, units):
    ax = draw(sizes_apart(units), ["x", "v", "y", "w"])
    panels = ax.figure.axes
    assert panels[0] is ax
    drawn = [[line.get_label() for line in each.lines] for each in panels]
    assert drawn == [["x", "y"], ["v"], ["w"]]
    for each in panels:  # every curve reaches over a tenth of its axes
        low, high = each.get_ylim()
        sizes = [np.abs(line.get_ydata()).max() for line in each.lines]
        assert min(sizes) > 0.05 * (high - low)
    assert [each.get_xlabel() for each in panels][:-1] == ["", ""]
    assert panels[-1].get_xlabel() == "time"
    assert len({each.get_xlim() for each in panels}) == 1


def test_axes_that_are_given_hold_all_variables(ax):
    assert ns.plot.time_history(sizes_apart(), ["x", "w"], ax=ax) is ax
    assert ax.figure.axes == [ax] and len(ax.lines) == 2


def test_a_variable_that_is_zero_needs_no_axes():
    run = sizes_apart(units=False).assign(z=lambda run: 0.0 * run["x"])
    ax = ns.plot.time_history(run, ["z", "w"])
    assert ax.figure.axes == [ax]


def test_sizes_are_those_of_the_range_that_is_drawn():
    decay = ns.System(states=["a", "b"], equations={"a": "-a", "b": "0"}, initial={"a": 1, "b": 1})
    run = ns.simulate(decay, times=np.linspace(0.0, 10.0, 200))
    assert len(ns.plot.time_history(run, ["a", "b"], time_range=(0.0, 1.0)).figure.axes) == 1
    assert len(ns.plot.time_history(run, ["a", "b"], time_range=(5.0, 9.0)).figure.axes) == 2


def test_stays_shorter_than_a_pixel_tint_it_by_their_share():
    """3000 turns of which a tenth is short: drawn by chance, some pixels would hold them whole."""
    turns = ns.System(
        states=["x"],
        modes={
            "long": ns.Mode({"x": "1"}, exits=[ns.Exit("9 - x", to="short")]),
            "short": ns.Mode({"x": "1"}, exits=[ns.Exit("10 - x", to="long", reset={"x": "0"})]),
        },
    )
    run = ns.simulate(turns, times=[0.0, 30_000.0])
    ax = ns.plot.phases(run, "x", legend=False)
    ax.lines[0].remove()
    figure = ax.figure
    figure.canvas.draw()
    picture = np.asarray(figure.canvas.buffer_rgba())[..., :3] / 255.0
    (left, bottom), (right, top) = ax.transAxes.transform([(0.02, 0.02), (0.98, 0.98)])
    height = len(picture)
    inside = picture[height - int(top) : height - int(bottom), int(left) : int(right)]
    colours = ns.plot.mode_colours(run)
    mixed = 0.9 * np.array(to_rgb(colours["long"])) + 0.1 * np.array(to_rgb(colours["short"]))
    pale = 0.3 * mixed + 0.7
    row = inside[len(inside) // 2]
    np.testing.assert_allclose(row.mean(axis=0), pale, atol=0.05)
    assert np.abs(row - row.mean(axis=0)).max() < 0.05  # no pixel is one mode alone
