import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.errors import OptionError


def rectangles(ax) -> dict[str, np.ndarray]:
    """Begin and end of the stretches of each mode."""
    return {
        c.get_label(): np.array([path.vertices[[0, 2], 0] for path in c.get_paths()])
        for c in ax.collections
    }


def test_modes_change_at_the_events(mole, ax):
    """One period of the steady motion has the four phases of the chapter's Fig. 9."""
    period = mole.attrs["period"]
    low, high = 18.25 * period, 19.25 * period
    ns.plot.phases(mole, ["x", "z", "v"], time_range=(low, high), ax=ax)
    found = rectangles(ax)
    assert {name: len(spans) for name, spans in found.items()} == {
        "no contact": 2,
        "contact": 2,
        "progression": 1,
    }
    edges = np.sort(np.concatenate([spans.ravel() for spans in found.values()]))
    times = mole["event_time"].values
    inside = times[(times > low) & (times < high)]
    assert edges[::2] == pytest.approx([low, *inside])
    assert edges[1::2] == pytest.approx([*inside, high])


def test_the_whole_run_is_covered(mole, ax):
    ns.plot.phases(mole, "v", ax=ax)
    total = sum(np.sum(spans[:, 1] - spans[:, 0]) for spans in rectangles(ax).values())
    assert total == pytest.approx(float(mole["time"][-1]))


def test_a_run_that_goes_on_has_its_first_mode(mole, ax):
    """Its log begins with the mode in which it goes on."""
    more = ns.simulate(ns.models.moling(), mole, periods=1)
    assert more["event_kind"].values[0] == "start"
    ns.plot.phases(more, "v", ax=ax)
    total = sum(np.sum(spans[:, 1] - spans[:, 0]) for spans in rectangles(ax).values())
    assert total == pytest.approx(mole.attrs["period"])


def test_one_mode_is_one_stretch(bouncing, ax):
    """Impacts of a ball do not change the mode."""
    ns.plot.phases(bouncing, "h", ax=ax)
    assert rectangles(ax)["flight"] == pytest.approx(np.array([[0.0, 2.5]]))


def test_legend_has_lines_and_modes(mole, ax):
    ns.plot.phases(mole, ["x", "v"], ax=ax, labels={"contact": "II, IV"})
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert texts == ["x", "v", "no contact", "II, IV", "progression"]


def test_a_mode_has_one_colour(mole):
    """The colour does not depend on which modes a picture shows."""
    colours = ns.plot.mode_colours(mole)
    _, axes = ns.plot.print_figure(1, 2)
    ns.plot.phases(mole, "v", ax=axes[0])
    ns.plot.phases(mole, "v", ax=axes[1], time_range=(1150.0, 1180.0))
    (only,) = axes[1].collections
    assert only.get_label() == "no contact"
    np.testing.assert_array_equal(only.get_facecolor(), axes[0].collections[0].get_facecolor())
    assert len(set(colours.values())) == 3


def test_colours_need_a_run(mole):
    with pytest.raises(OptionError, match="no variable 'mode'"):
        ns.plot.mode_colours(mole.drop_vars("mode"))


def test_many_modes_have_different_colours(mole):
    names = " ".join(f"m{i}" for i in range(28))
    run = mole.copy()
    run["mode"].attrs["flag_meanings"] = names
    assert len(set(ns.plot.mode_colours(run).values())) == 28


def test_a_legend_of_many_cells_leaves_room_for_the_curves(ax):
    stairs = "0"
    for i in range(-20, 20):
        stairs = f"where(x > {i}/10, {0.1 * i}*x, {stairs})" if i % 2 else stairs
    stairs = ns.System(states=["x", "v"], equations={"x": "v", "v": f"-9*x - {stairs}"})
    run = ns.simulate(stairs, {"v": 7.0}, t_end=30)
    assert len(set(run["mode"].values)) > 15
    ns.plot.phases(run, "x", ax=ax)
    ax.figure.canvas.draw()
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert texts[-1].startswith("and ") and texts[-1].endswith(" more")
    assert len(texts) <= 16
    assert ax.get_position().height > 0.5


def test_cells_of_one_name_have_one_colour(ax):
    flow = {"x": "v", "v": "-x - clip(x, -1, 1)"}
    modes = {"m": ns.Mode(flow, cells={"++": "far", "-.": "far", "+-": "near"})}
    system = ns.System(states=["x", "v"], modes=modes)
    run = ns.simulate(system, {"x": 0.0, "v": 4.0}, t_end=6.0)
    assert list(ns.plot.mode_colours(run)) == ["far", "near"]
    ns.plot.phases(run, "x", ax=ax)
    found = rectangles(ax)
    assert sorted(found) == ["far", "near"]
    # both far cells are drawn: x beyond 1 and below -1
    sides = {
        float(np.sign(run["x"].sel(time=span.mean(), method="nearest"))) for span in found["far"]
    }
    assert sides == {-1.0, 1.0}
