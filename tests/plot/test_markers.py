import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.errors import OptionError


def test_states_are_marked_just_before(bouncing, ax):
    ns.plot.event_markers(bouncing, "u", ax)
    (impacts,) = ax.lines
    assert impacts.get_label() == "impact"
    assert impacts.get_xdata() == pytest.approx([np.sqrt(2.0)])
    assert impacts.get_ydata() == pytest.approx([-np.sqrt(2.0)])


def test_outputs_are_marked_between_samples(bouncing, ax):
    ns.plot.event_markers(bouncing, "energy", ax)
    first, later = bouncing["energy"].values[1:3]
    share = np.sqrt(2.0) - 1.0
    assert ax.lines[0].get_ydata() == pytest.approx([first + share * (later - first)])


def test_each_name_has_its_shape(mole, ax):
    ns.plot.event_markers(mole, "p", ax)
    shapes = {line.get_label(): line.get_marker() for line in ax.lines}
    assert list(shapes) == ["contact", "impact", "progression", "release"]
    assert len(set(shapes.values())) == 4
    _, (other,) = ns.plot.print_figure()
    ns.plot.event_markers(mole, "p", other, time_range=(1189.0, 1190.0))
    assert all(shapes[line.get_label()] == line.get_marker() for line in other.lines)
    assert len(other.lines) < 4


def test_two_curves_share_the_legend(mole, ax):
    ns.plot.time_history(mole, ["p", "q"], ax=ax, events=True, time_range=(1100.0, 1200.0))
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert texts == ["p", "q", "contact", "impact", "progression", "release"]


def test_tangencies_say_so(mole, ax):
    run = mole.copy(deep=True)
    kinds = run["event_kind"].values.copy()
    kinds[1] = "graze"
    run["event_kind"] = ("event", kinds)
    ns.plot.event_markers(run, "p", ax)
    name = str(run["event_name"].values[1])
    assert f"{name} (graze)" in ax.get_legend_handles_labels()[1]


def test_unknown_variable(mole, ax):
    with pytest.raises(OptionError, match="unknown variable 'w'"):
        ns.plot.event_markers(mole, "w", ax)


def test_a_run_without_its_log_is_drawn_by_its_samples_alone(ax):
    run = ns.simulate(ns.models.moling(), periods=3, events=False)
    line = ns.plot.time_history(run, "p", ax=ax).lines[0]
    assert np.array_equal(line.get_ydata(), run["p"].values)
    for draw in (ns.plot.event_markers, lambda run, name, ax: ns.plot.phases(run, name, ax=ax)):
        with pytest.raises(ns.OptionError, match="simulate without events=False"):
            draw(run, "p", ax)
