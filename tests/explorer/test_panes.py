"""Ranges and texts of the axes of the page."""

import pytest

pytest.importorskip("bokeh", reason="the page is made with Bokeh, the extra `explore`")

from bokeh.models import Range1d

from nonsmooth.explorer.panes.look import axis_text, fit, is_zoomed, new_figure


def test_a_range_has_room_beside_its_values():
    found = Range1d()
    fit(found, -1.0, 3.0)
    assert (found.start, found.end) == pytest.approx((-1.2, 3.2), rel=1e-12)
    fit(found, 0.25, 0.25 + 1e-11, room=0.0)  # of a box that is small, and no rounding
    assert (found.start, found.end) == (0.25, 0.25 + 1e-11)


@pytest.mark.parametrize("value", [-0.1974491327159, 0.65, 3e-7, 4e9])
def test_values_that_differ_by_rounding_are_one_value(value):
    found = Range1d()
    fit(found, value, value + abs(value) * 1e-15)
    assert (found.start, found.end) == pytest.approx(
        (value - 0.05 * abs(value), value + 0.05 * abs(value)), rel=1e-9
    )


def test_zero_alone_has_a_range():
    found = Range1d()
    fit(found, 0.0, 0.0)
    assert found.start < 0.0 < found.end


def test_a_figure_is_zoomed_until_its_ranges_are_fitted():
    plot = new_figure("history", boxes=False)
    fit(plot.x_range, 0.0, 1.0)
    fit(plot.y_range, 0.0, 1.0)
    assert not is_zoomed(plot)
    plot.y_range.end = 0.5
    assert is_zoomed(plot)


def test_a_text_that_is_too_long_for_its_axis_has_the_symbol_and_the_unit():
    label = ("deflection of the specimen", "A_b")
    assert axis_text("u", label, 35) == "u: deflection of the specimen [A_b]"
    assert axis_text("u", label, 34) == "u [A_b]"
    assert axis_text("x", ("x", "")) == axis_text("x", ("", "1")) == "x"
