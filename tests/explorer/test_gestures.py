"""Gestures are functions of views: no browser is needed to see what a click does."""

import pytest

from nonsmooth.errors import NonsmoothError, OptionError
from nonsmooth.explorer.gestures import after
from nonsmooth.explorer.links import to_link
from nonsmooth.explorer.openings import opening, presets
from nonsmooth.explorer.view import system_of

MOLE = opening("moling")
WALL = opening("impact_oscillator")


def test_a_slider_changes_a_parameter_and_puts_the_orbit_away():
    shown = after(MOLE, {"do": "set", "fields": {"turn": "2", "branch": "1"}})
    view = after(shown, {"do": "value", "name": "b", "value": "0.12"})
    assert view.system.parameter_values["b"] == 0.12
    assert (view.turn, view.branch) == (0, False)


def test_a_value_may_be_an_expression_and_nothing_else():
    view = after(MOLE, {"do": "value", "name": "phi", "value": " pi/4 "})
    assert view.system.parameter_values["phi"] == pytest.approx(0.785398163, abs=1e-9)
    for text in ("__import__('os')", "1 if 2 else 3", "b = 2", ""):
        with pytest.raises(NonsmoothError):
            after(MOLE, {"do": "value", "name": "phi", "value": text})


@pytest.mark.parametrize("value", ["0.4", "-1", "1e300"])
def test_a_value_outside_the_diagram_leaves_its_range(value):
    view = after(MOLE, {"do": "value", "name": "b", "value": value})
    assert view.between == MOLE.between
    assert view.system.parameter_values["b"] == float(value)


def test_a_click_in_the_diagram_runs_there_with_the_digits_of_a_picture():
    view = after(MOLE, {"do": "click", "pane": "diagram", "x": 0.123456789, "y": 3.0})
    assert dict(view.values) == {"b": "0.12346"}


def test_a_click_in_the_plane_or_the_portrait_starts_there():
    for pane in ("plane", "portrait"):
        view = after(MOLE, {"do": "click", "pane": pane, "x": -3.5, "y": 0.25})
        assert dict(view.initial) == {"p": -3.5, "y": 0.25}
        assert view.leave_out == 0.0  # so that the start is seen


def test_a_click_on_an_output_is_no_start():
    view = after(MOLE, {"do": "set", "fields": {"portrait": "x,y"}})
    with pytest.raises(OptionError, match="x is an output"):
        after(view, {"do": "click", "pane": "portrait", "x": 1.0, "y": 1.0})


def test_a_box_becomes_the_range_whichever_way_it_was_drawn():
    box = {"do": "box", "x0": 0.14, "x1": 0.10, "y0": 5.0, "y1": 2.0}
    view = after(MOLE, box | {"pane": "diagram"})
    assert (view.between, view.height) == ((0.10, 0.14), (2.0, 5.0))
    # a frame has at most some thousand pixels: digits beyond those say nothing
    rough = {"x0": 0.10000000123, "x1": 0.13000001066116265, "y0": 2.0000001, "y1": 5.0}
    view = after(MOLE, {"do": "box", "pane": "diagram"} | rough)
    assert (view.between, view.height) == ((0.1, 0.13), (2.0, 5.0))
    view = after(MOLE, box | {"pane": "plane"})
    assert view.region == (0.10, 0.14, 2.0, 5.0)
    with pytest.raises(OptionError, match="too small"):
        after(MOLE, {"do": "box", "pane": "diagram", "x0": 0.1, "x1": 0.1, "y0": 0.0, "y1": 1.0})


def test_orbit_asks_for_the_period_of_the_motion_and_again_puts_it_away():
    view = after(MOLE, {"do": "orbit"})
    assert (view.turn, view.branch) == (-1, True)
    assert after(view, {"do": "orbit"}).turn == 0


def test_typed_equations_keep_what_still_has_a_meaning():
    text = system_of("impact_oscillator", "").to_toml().replace("r = 0.8", "r = 0.5")
    moved = after(WALL, {"do": "set", "fields": {"length": "33", "portrait": "v,x"}})
    view = after(moved, {"do": "text", "text": text})
    assert view.system.parameter_values["r"] == 0.5
    assert (view.model, view.length, view.portrait) == ("", 33.0, ("v", "x"))
    assert view.between == WALL.between


def test_a_start_at_rest_is_no_start():
    view = after(WALL, {"do": "start", "states": {"x": -1.0, "v": 0.0}})
    assert view.initial == (("x", -1.0),)
    assert after(view, {"do": "start", "states": {}}).initial == ()


def test_a_start_and_a_range_may_be_expressions_and_nothing_else():
    view = after(WALL, {"do": "start", "states": {"x": "-pi/3", "v": 0.1 + 0.2}})
    assert dict(view.initial) == pytest.approx({"x": -1.047197551196598, "v": 0.3}, abs=1e-15)
    view = after(WALL, {"do": "set", "fields": {"between": "pi/2,pi", "leave_out": "2*10"}})
    assert view.between == pytest.approx((1.570796326794897, 3.141592653589793), abs=1e-15)
    assert view.leave_out == 20.0
    for text in ("x", "1/0", "", "0,5", "nan"):
        with pytest.raises(NonsmoothError, match=r"^x(:| = )"):
            after(WALL, {"do": "start", "states": {"x": text}})


def test_lists_and_links():
    assert after(WALL, {"do": "preset", "number": 3}) == presets()[3].view
    assert after(WALL, {"do": "link", "link": "#" + to_link(MOLE)}) == MOLE


def test_a_section_is_one_of_the_system():
    for section in ("impact", "v - 0.1"):
        assert after(WALL, {"do": "set", "fields": {"section": section}}).section == section
    with pytest.raises(OptionError, match="nothing"):
        after(WALL, {"do": "set", "fields": {"section": "nothing"}})


def test_a_typed_system_drops_the_section_that_it_has_no_more():
    view = after(WALL, {"do": "set", "fields": {"section": "impact"}})
    text = WALL.system.to_toml().replace('name = "impact"', 'name = "blow"')
    assert text != WALL.system.to_toml()
    assert after(view, {"do": "text", "text": text}).section == ""


def test_an_empty_editor_is_no_system():
    for text in ("", " \n "):
        with pytest.raises(OptionError, match="there is no system"):
            after(WALL, {"do": "text", "text": text})


def test_a_system_without_forcing_shows_another_variable_than_that_of_its_section():
    text = 'states = ["x", "v"]\n[parameters]\nc = 0.1\n[equations]\nx = "v"\nv = "-x - c*v"\n'
    view = opening(text=text)
    assert view.section == "v" and view.shown == "x"


@pytest.mark.parametrize(
    "gesture",
    [
        {},
        {"do": "eval"},
        {"do": ["value"]},
        {"do": "value"},
        {"do": "value", "name": "nothing", "value": "1"},
        {"do": "set", "fields": {"model": "duffing"}},
        {"do": "set", "fields": {"columns": "1e9"}},
        {"do": "set", "fields": ["length"]},
        {"do": "preset", "number": 10_000},
        {"do": "click", "pane": "plane"},
        {"do": "start", "states": {"x": "a"}},
        {"do": "start", "states": {"x": float("inf")}},
    ],
)
def test_what_is_no_gesture_is_refused(gesture):
    with pytest.raises(NonsmoothError):
        after(WALL, gesture)


def test_one_state_for_both_axes_of_the_plane_exchanges_them():
    view = after(WALL, {"do": "set", "fields": {"plane": "v,v"}})
    assert (WALL.plane, view.plane) == (("x", "v"), ("v", "x"))


@pytest.mark.parametrize("between", ["", ",", "0.1", "0.1,"])
def test_a_range_without_both_of_its_ends_is_refused(between):
    with pytest.raises(OptionError, match="between: give two numbers"):
        after(MOLE, {"do": "set", "fields": {"between": between}})
