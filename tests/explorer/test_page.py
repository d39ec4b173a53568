"""The page in a real browser: what a visitor does, and what the page then shows."""

import math
import re
import time
from dataclasses import replace

import numpy as np
import pytest

import nonsmooth as ns
from explorer.conftest import SMALL, Screen
from explorer.typed_systems import RIGID, ZENO
from nonsmooth.explorer.links import from_link, to_link
from nonsmooth.explorer.openings import opening, presets

pytestmark = pytest.mark.browser

SPRING = """states = ["x", "v"]
period = "2*pi/w"

[parameters]
w = 1.0
c = 0.25
[describe]
x = "elongation [mm]"
c = "damping [N s/m]"

[equations]
x = "v"
v = "sin(w*t) - c*v - x"
"""


def typed(screen, text):
    screen.page.get_by_role("tab", name="Equations").click()
    screen.page.get_by_label("Equations of the system as TOML").fill(text)


@pytest.mark.slow
def test_a_typed_model_comes_to_its_portrait(screen, wall):
    """Its steady motion is -cos(t)/c, so the portrait is a circle with the radius 1/c = 4."""
    screen.open(wall)
    typed(screen, SPRING)
    screen.after("motion", lambda: screen.page.keyboard.press("Control+Enter"))
    screen.page.get_by_role("tab", name="Parameters").click()
    leave_out = screen.page.get_by_label("leave out")

    def settled():
        leave_out.fill("60")
        leave_out.press("Enter")

    screen.after("motion", settled).settle()
    ranges = [
        screen.model("portrait", f"[it.{r}.start, it.{r}.end]") for r in ("x_range", "y_range")
    ]
    # transients fall by exp(-c/2 T) per period; five per cent of room stand beside the curve
    for low, high in ranges:
        assert (low, high) == pytest.approx((-4.4, 4.4), abs=0.02)
    assert screen.model("portrait", "it.below[0].axis_label") == "x: elongation [mm]"
    assert "N s/m" in screen.page.locator("#sliders").inner_text()


def test_a_wrong_equation_has_its_message_under_the_fault(screen, wall):
    screen.open(wall)
    typed(screen, SPRING.replace("c*v", "d*v"))
    screen.page.get_by_role("button", name="Run", exact=True).click()
    alert = screen.page.locator("#fault")
    alert.wait_for()
    line = SPRING.split("\n").index('v = "sin(w*t) - c*v - x"') + 1
    assert alert.inner_text().startswith(f"Line {line}. equations.v: unknown name 'd'")
    row, caret = alert.locator("pre").inner_text().split("\n")[:2]
    assert row[caret.index("^")] == "d"
    assert screen.page.locator("#marks mark").inner_text() == "d"
    assert from_link(screen.link) == wall  # the page stays as it was
    screen.after(
        "motion", lambda: typed(screen, SPRING) or screen.page.keyboard.press("Control+Enter")
    )
    assert not alert.is_visible()


def test_the_mark_of_a_fault_lies_on_it_though_the_editor_is_scrolled(screen, wall):
    screen.open(wall)
    row = 'v = "sin(w*t) - d*v - x' + " + 0*x" * 12 + '"'  # wider than the editor
    text = SPRING.replace('v = "sin(w*t) - c*v - x"', row) + "\n" * 12
    typed(screen, text)
    screen.page.keyboard.press("Control+Enter")
    screen.page.locator("#marks mark").wait_for()
    line = text.split("\n").index(row)
    place = "element => element.getBoundingClientRect().top"
    box = screen.page.locator("#text")
    box.evaluate("element => { element.scrollTop = 1e6; }")
    screen.page.wait_for_timeout(100)
    expected = box.evaluate(place) + 6 + 18 * line - box.evaluate("element => element.scrollTop")
    # a mark is less high than its line
    assert screen.page.locator("#marks mark").evaluate(place) == pytest.approx(expected, abs=5)


def test_texts_of_a_drawing_have_their_lines(screen):
    screen.page.add_init_script(
        "window.texts = new Set(); const write = CanvasRenderingContext2D.prototype.fillText;"
        " CanvasRenderingContext2D.prototype.fillText = function (text, ...place)"
        " { texts.add(text); write.call(this, text, ...place); }"
    )
    screen.open(replace(opening("duffing"), **SMALL))
    screen.page.wait_for_function("texts.has('max')")
    assert not [text for text in screen.page.evaluate("[...texts]") if "\n" in text]


@pytest.mark.slow
def test_another_system_leaves_nothing_of_the_one_before(screen, wall):
    """At rest on the ground, rebounds accumulate at once: there is one point of a motion."""
    screen.open(wall)
    typed(screen, ZENO)
    screen.after("motion", lambda: screen.page.keyboard.press("Control+Enter"))
    screen.settle()
    assert "event_limit" in screen.page.locator("#motion-note").inner_text()
    assert "ended early" in screen.page.locator("#motion-said").inner_text()
    assert "ended early" in screen.page.locator("#diagram-note").inner_text()
    points = "it.renderers.map((each) => each.data_source.data.x?.length ?? 0)"
    assert not any(screen.model("diagram", points))
    typed(screen, RIGID)
    screen.after("motion", lambda: screen.page.keyboard.press("Control+Enter"))
    screen.settle()
    assert "no parameter" in screen.page.locator("#diagram-note").inner_text()
    assert not screen.page.locator(".plot.stale").count()


@pytest.mark.slow
def test_an_empty_editor_is_told_and_a_toast_goes_with_its_cause(screen, wall):
    screen.open(wall)
    field = screen.page.get_by_label("value of r", exact=True)
    field.fill("1.5")
    field.press("Enter")
    toast = screen.page.locator("#toast")
    toast.wait_for()
    field.fill("0.7")
    field.press("Enter")
    toast.wait_for(state="hidden", timeout=4_000)  # before its own time is over
    typed(screen, "")
    screen.page.keyboard.press("Control+Enter")
    screen.page.locator("#fault").wait_for()
    assert "there is no system" in screen.page.locator("#fault").inner_text()
    screen.settle()


def test_the_bare_address_is_answered(screen):
    screen.page.goto(screen.address)
    screen.page.wait_for_function("window.explorer?.gestures.heard === 1")
    header = screen.page.locator("header")
    assert header.bounding_box()["height"] < 40  # one row, though work is told there
    screen.page.keyboard.press("Escape")


def test_a_slider_moves_the_motion_and_its_number(screen, wall):
    screen.open(wall)
    slider = screen.page.locator("#p-zeta")
    slider.focus()
    screen.after("motion", lambda: slider.press("End"))
    assert float(slider.input_value()) == screen.field("value of zeta") == 0.04
    assert dict(from_link(screen.link).values) == {"zeta": "0.04"}
    screen.settle()
    assert len(screen.page.evaluate("explorer.timings")) >= 1


@pytest.mark.slow
def test_a_slider_keeps_a_typed_value_as_its_end_while_it_is_moved(screen, wall):
    screen.open(wall)
    slider, field = screen.page.locator("#p-zeta"), screen.page.get_by_label("value of zeta")
    assert slider.get_attribute("max") == "0.04"
    screen.after("ranges", lambda: field.fill("0.3") or field.press("Enter")).settle()
    slider.focus()
    for _ in range(3):
        screen.after("ranges", lambda: slider.press("PageDown")).settle()
    assert screen.field("value of zeta") < 0.25
    screen.after("motion", lambda: slider.press("End")).settle()
    assert screen.field("value of zeta") == 0.3


@pytest.mark.slow
def test_a_start_is_typed_as_an_expression_or_refused_with_the_reason(screen, wall):
    screen.open(wall)
    x = screen.page.locator("#start input").nth(0)
    screen.after("motion", lambda: x.fill("-pi/3") or x.press("Enter")).settle()
    assert dict(from_link(screen.link).initial) == {"x": -math.pi / 3}
    assert x.input_value() == "-1.047197551"
    # the other state is typed, and the first one keeps the digits that its field does not show
    v = screen.page.locator("#start input").nth(1)
    screen.after("motion", lambda: v.fill("1") or v.press("Enter")).settle()
    assert dict(from_link(screen.link).initial) == {"x": -math.pi / 3, "v": 1.0}
    v.fill("fast")
    v.press("Enter")
    screen.page.locator("#start input.wrong").wait_for()
    assert "v = 'fast' is not a number" in screen.page.locator("#toast").inner_text()


@pytest.mark.slow
def test_a_value_that_is_refused_is_told_with_the_reason(screen, wall):
    screen.open(wall)
    field = screen.page.get_by_label("value of r", exact=True)
    field.fill("1.5")
    field.press("Enter")
    screen.page.locator("#toast").wait_for()
    assert "an impact cannot feed energy in" in screen.page.locator("#toast").inner_text()
    assert dict(from_link(screen.link).values) == {}
    leave_out = screen.page.get_by_label("leave out")
    leave_out.fill("100000")
    leave_out.press("Enter")
    screen.page.locator('[data-field="leave_out"].wrong').wait_for()
    screen.after("motion", lambda: leave_out.fill("20") or leave_out.press("Enter"))
    assert not screen.page.locator("input.wrong").count()  # what was refused before, neither


def test_a_click_in_the_basin_or_the_portrait_starts_there(screen, wall):
    screen.open(wall)
    for pane, (right, up) in (("plane", (0.25, 0.75)), ("portrait", (0.5, 0.4))):
        ends = screen.model(
            pane, "[it.x_range.start, it.x_range.end, it.y_range.start, it.y_range.end]"
        )
        screen.after(
            "motion", lambda p=pane, r=right, u=up: screen.page.mouse.click(*screen.place(p, r, u))
        )
        at = dict(from_link(screen.link).initial)
        pixel = [(ends[k + 1] - ends[k]) / 100 for k in (0, 2)]
        assert at["x"] == pytest.approx(ends[0] + right * (ends[1] - ends[0]), abs=pixel[0])
        assert at["v"] == pytest.approx(ends[2] + up * (ends[3] - ends[2]), abs=pixel[1])
        shown = float(screen.page.locator("#start input").nth(0).input_value())
        assert shown == pytest.approx(at["x"], rel=1e-9)  # ten digits are shown
        screen.settle()


@pytest.mark.slow
def test_a_double_click_shows_all_of_a_motion_again(screen, wall):
    screen.open(wall)
    link = screen.link
    for pane in ("history", "portrait"):
        whole = ends_of(screen, pane)
        for _ in range(2):
            left, right = box_of(screen, pane, whole)[:2]
            # half the width, drawn to a pixel
            assert (right - left) / (whole[1] - whole[0]) == pytest.approx(0.5, abs=0.02)
            screen.page.mouse.dblclick(*screen.place(pane, 0.5, 0.5))
            wait_for_ends(screen, pane, "===", whole)
    screen.page.wait_for_timeout(700)
    assert screen.link == link  # no click of them has moved the start
    box_of(screen, "portrait", whole)
    screen.after("motion", lambda: screen.page.mouse.click(*screen.place("portrait", 0.5, 0.5)))
    assert from_link(screen.link).initial  # one click has


ENDS = "[it.x_range.start, it.x_range.end, it.y_range.start, it.y_range.end]"


def ends_of(screen, pane):
    return screen.model(pane, ENDS)


def wait_for_ends(screen, pane, sign, ends):
    screen.page.wait_for_function(
        f"""ends => {{
          const it = Bokeh.documents[0].get_model_by_name('{pane}');
          return JSON.stringify({ENDS}) {sign} JSON.stringify(ends);
        }}""",
        arg=ends,
    )


def box_of(screen, pane, whole):
    """Ends of a pane in which a box is drawn."""
    screen.drag(pane, (0.25, 0.2), (0.75, 0.8))
    wait_for_ends(screen, pane, "!==", whole)
    screen.page.wait_for_timeout(300)  # the server hears of it too
    return ends_of(screen, pane)


@pytest.mark.parametrize(
    ("width", "height"), [pytest.param(1280, 720, marks=pytest.mark.slow), (1501, 903)]
)
def test_marks_stand_where_their_values_are(screen, mole, width, height):
    """Within half a pixel, also in panes whose frames are no whole number of pixels wide."""
    screen.page.set_viewport_size({"width": width, "height": height})
    screen.open(mole)
    screen.page.get_by_role("button", name="Next event").click()
    screen.settle()
    middle = """kind => {
      const { left, width, top, height } = document.querySelector(kind).getBoundingClientRect();
      return [left + width / 2, top + height / 2];
    }"""
    rule, dot = (
        screen.page.evaluate(middle, f'[data-pane="history"] .{kind}') for kind in ("rule", "dot")
    )
    assert rule[0] == pytest.approx(dot[0], abs=0.5)
    for pane, kind, x, y in (("plane", "start", 0, 0), ("diagram", "rule", 0.15, None)):
        across, up = screen.model(
            pane,
            f"""(() => {{
              const {{ el, frame }} = Bokeh.index.find_one(it);
              const {{ left, top }} = el.getBoundingClientRect();
              return [left + frame.x_scale.compute({x}), top + frame.y_scale.compute({y or 0})];
            }})()""",
        )
        found = screen.page.evaluate(middle, f'[data-pane="{pane}"] .{kind}')
        assert found[0] == pytest.approx(across, abs=0.5)
        assert y is None or found[1] == pytest.approx(up, abs=0.5)


@pytest.mark.slow
def test_a_click_in_the_diagram_runs_there(screen, wall):
    screen.open(wall)
    screen.after("motion", lambda: screen.page.mouse.click(*screen.place("diagram", 0.5, 0.5)))
    omega = screen.field("value of omega")
    assert omega == pytest.approx(2.5, abs=0.01)
    assert screen.painted("diagram") == 4  # its four pieces, and none since


@pytest.mark.slow
def test_a_box_is_computed_finer_and_back_leads_back(screen, wall):
    screen.open(wall)
    first = screen.link
    screen.after("diagram", lambda: screen.drag("diagram", (0.2, 0.2), (0.6, 0.9))).settle()
    view = from_link(screen.link)
    assert view.between == pytest.approx((1.9, 2.7), abs=0.02)
    assert screen.model("diagram", "[it.x_range.start, it.x_range.end]") == list(view.between)
    columns = screen.model("diagram", "new Set(it.renderers[0].data_source.data.x).size")
    assert columns == view.columns
    screen.after("plane", lambda: screen.drag("plane", (0.2, 0.2), (0.6, 0.6))).settle()
    assert len(from_link(screen.link).region) == 4
    for _ in range(2):
        screen.page.get_by_role("button", name="Back").click()
        screen.settle()
    assert screen.link == first
    screen.page.get_by_role("button", name="Forward").click()
    screen.page.wait_for_function(f"location.hash !== '#{first}'")


@pytest.mark.slow
def test_work_is_stopped_by_the_next_gesture_and_by_the_button(screen, wall):
    long = replace(
        next(p for p in presets() if p.model == "rotor").view,
        columns=4000, transient=5000, plane=("x", "y"), picture="basins", cells=200,
        region=(-1.0, 1.0, -1.0, 1.0),
    )  # fmt: skip
    screen.page.goto(f"{screen.address}/#")
    screen.page.wait_for_function("window.explorer?.painted.motion > 0")
    screen.page.evaluate(f"location.hash = '#{to_link(long)}'")
    stop = screen.page.get_by_role("button", name="Stop")
    stop.wait_for()
    slider = screen.page.locator("#p-eta")
    slider.focus()
    screen.after("motion", lambda: slider.press("ArrowRight"))  # it answers all the same
    stop.wait_for()
    stop.click()
    screen.page.wait_for_function("explorer.work.size === 0")
    assert "stopped" in screen.page.locator("#plane-note").inner_text()
    screen.open(wall)


def test_a_link_brings_back_the_whole_page(screen, wall, server):
    screen.open(wall)
    screen.after("motion", lambda: screen.page.mouse.click(*screen.place("plane", 0.3, 0.6)))
    screen.page.get_by_label("variable").select_option("x")
    screen.page.get_by_role("button", name="Next event").click()
    screen.settle()
    link, text = screen.link, screen.page.locator("#event-text").inner_text()
    shown = screen.model("portrait", "[it.x_range.start, it.y_range.end]")
    assert "event=" in link and "certified" in text
    screen.page.goto("about:blank")
    screen.open(None, link=link)
    assert screen.link == link
    assert screen.model("portrait", "[it.x_range.start, it.y_range.end]") == shown
    assert screen.page.locator("#event-text").inner_text() == text
    assert screen.page.locator('[data-field="shown"]').input_value() == "x"


@pytest.mark.slow
def test_a_copied_script_gives_the_digits_of_the_page(screen, wall, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    screen.open(wall)
    slider = screen.page.locator("#p-r")
    slider.focus()
    screen.after("motion", lambda: slider.press("ArrowLeft")).settle()
    screen.page.get_by_role("button", name="Python").click()
    screen.page.locator("dialog[open]").wait_for()
    script = screen.page.evaluate("navigator.clipboard.readText()")
    assert script == screen.page.get_by_label("Text to copy").input_value()
    names = {}
    exec(compile(script, "copied.py", "exec"), names)
    run = names["run"]
    curves = screen.page.evaluate(
        """(() => { const figure = Bokeh.documents[0].get_model_by_name('portrait');
          return Array.from(figure.renderers[0].data_source.data.x, (each) => Array.from(each));
        })()"""
    )
    shown = sorted(x for curve in curves for x in curve if x is not None and not math.isnan(x))
    known = {*run["x"].values.tolist(), *run["state_before"].values[:, 0].tolist()}
    known |= {*run["state_after"].values[:, 0].tolist()}
    assert len(shown) > 1000 and set(shown) <= known
    assert names["basins"]["label"].shape == (12, 12)
    commands = screen.page
    commands.get_by_role("button", name="Close").click()
    commands.get_by_role("button", name="Command").click()
    commands.wait_for_function(
        "document.getElementById('copied-text').value.startsWith('nonsmooth')"
    )


@pytest.mark.slow
def test_orbit_with_its_multipliers_and_its_branch(screen, mole):
    """The mole at b = 0.15: its orbit of period one, whose branch folds near b = 0.1672."""
    view = replace(mole, between=(0.14, 0.18))
    screen.open(view)
    screen.after("orbit", lambda: screen.page.get_by_role("button", name="Orbit").click()).settle()
    text = screen.page.locator("#orbit-text").inner_text()
    assert "period 1, stable" in text and "fold at 0.1671505" in text
    known = ns.find_orbit(ns.models.moling())["multipliers"].values
    shown = [float(word) for word in re.findall(r"-?\d\.\d+", text.split("multipliers")[1])[:1]]
    assert shown[0] == pytest.approx(float(known[0].real), rel=1e-5)
    assert from_link(screen.link).turn == 1
    screen.page.get_by_role("button", name="Orbit").click()
    screen.page.wait_for_function("!location.hash.includes('turn')")


@pytest.mark.slow
def test_events_one_by_one_say_what_fires_and_why(screen, wall):
    screen.open(wall)
    text = screen.page.locator("#event-text")
    screen.page.get_by_role("button", name="Next event").click()
    screen.page.get_by_role("button", name="Next event").click()
    said = text.inner_text()
    words = r"impact at t = [\d.]+ \(\d+ of \d+; certified\): sigma - x falls through 0"
    assert re.search(words, said)
    assert text.get_attribute("title") == said
    before, after = (float(each) for each in re.search(r"v: ([\d.]+) → (-[\d.]+)", said).groups())
    assert after == pytest.approx(-0.8 * before, rel=1e-3)  # r = 0.8, to the four digits shown
    screen.page.locator("body").press("[")
    assert text.inner_text() != said


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 1920])
def test_the_whole_page_works_from_the_keyboard(screen, wall, width):
    screen.page.set_viewport_size({"width": width, "height": 9 * width // 16})
    screen.open(wall)
    page = screen.page
    reached = set()
    for _ in range(90):
        page.keyboard.press("Tab")
        stop = page.evaluate("document.activeElement.className")
        assert "bk-" not in stop  # a figure has no outline: its pane is the stop
        reached.add(
            page.evaluate(
                "document.activeElement.dataset.pane || document.activeElement.id"
                " || document.activeElement.dataset.field || ''"
            )
        )
    assert reached >= {
        "preset", "orbit", "p-omega", "play", "clock", "event-after",
        "history", "portrait", "diagram", "plane", "over", "tab-parameters",
    }  # fmt: skip
    page.locator('[data-pane="plane"]').focus()
    for _ in range(5):
        page.keyboard.press("ArrowLeft")
    ends = screen.model("plane", "[it.x_range.start, it.x_range.end]")
    screen.after("motion", lambda: page.keyboard.press("Enter"))
    at = dict(from_link(screen.link).initial)["x"]
    assert at == pytest.approx(ends[0] + 0.4 * (ends[1] - ends[0]))
    page.locator('[data-pane="diagram"]').focus()
    screen.after("diagram", lambda: page.keyboard.press("+")).settle()
    assert from_link(screen.link).between == pytest.approx((2.0, 3.0))
    screen.after("diagram", lambda: page.keyboard.press("Backspace")).settle()
    assert from_link(screen.link).between == wall.between


@pytest.mark.parametrize(
    ("width", "height"), [(1280, 720), pytest.param(1920, 1080, marks=pytest.mark.slow)]
)
def test_all_panes_have_room_and_nothing_lies_on_anything(screen, mole, width, height):
    screen.page.set_viewport_size({"width": width, "height": height})
    screen.open(mole)
    boxes = screen.page.evaluate(
        """[...document.querySelectorAll('header, aside, article')].map((each) => {
          const { left, top, right, bottom } = each.getBoundingClientRect();
          return [left, top, right, bottom]; })"""
    )
    for k, (left, top, right, bottom) in enumerate(boxes):
        assert 0 <= left < right <= width and 0 <= top < bottom <= height
        for other in boxes[:k]:
            apart = right <= other[0] or other[2] <= left or bottom <= other[1] or other[3] <= top
            assert apart, (boxes[k], other)
    plots = screen.page.evaluate(
        """[...document.querySelectorAll('.plot')].map(
          (each) => [each.clientWidth, each.clientHeight])"""
    )
    assert all(w >= 200 and h >= 180 for w, h in plots), plots
    cut = screen.page.evaluate(
        """[...document.querySelectorAll('header, .controls, .head')]
          .filter((each) => each.scrollWidth > each.clientWidth + 1)
          .map((each) => each.textContent.trim().slice(0, 60))"""
    )
    assert cut == []


@pytest.mark.slow
def test_a_picture_for_print(screen, wall):
    screen.open(wall)
    with screen.page.expect_download(timeout=90_000) as download:
        screen.page.get_by_label("print the portrait").select_option(".pdf")
    assert download.value.suggested_filename == "portrait.pdf"
    with open(download.value.path(), "rb") as file:
        assert file.read(5) == b"%PDF-"
    names = []
    screen.page.on("download", lambda found: names.append(found.suggested_filename))
    for suffix in (".pdf", ".png"):  # the second one while the first one is under way
        screen.page.get_by_label("print the plane").select_option(suffix)
    deadline = time.monotonic() + 90.0
    while len(names) < 2 and time.monotonic() < deadline:
        screen.page.wait_for_timeout(100)
    assert sorted(names) == ["plane.pdf", "plane.png"]


@pytest.mark.slow
def test_a_machine_of_the_list(screen, wall):
    screen.open(wall)
    number = next(k for k, preset in enumerate(presets()) if preset.title == "duffing")
    choose = screen.page.get_by_label("Machine or figure")
    screen.after("motion", lambda: choose.select_option(str(number)))
    assert screen.page.evaluate("document.title").startswith("duffing")
    assert np.isfinite(screen.model("portrait", "it.x_range.start"))
    assert from_link(screen.link).model == "duffing"


LONG_NAMES = """name = "cart"
states = ["position", "speed", "temperature"]
period = "2"

[parameters]
force = 1.0

[equations]
position = "speed"
speed = "force*sin(pi*t) - speed - position"
temperature = "-temperature"
"""


@pytest.mark.slow
@pytest.mark.parametrize("width", [390, 800])
def test_a_narrow_window_has_one_column_that_is_seen_whole(screen, wall, width):
    screen.page.set_viewport_size({"width": width, "height": 844})
    screen.open(wall)
    assert screen.page.evaluate("document.documentElement.scrollWidth") <= width
    for card in screen.page.locator("aside, article").all():
        box = card.bounding_box()
        assert box["x"] >= 0 and box["width"] > 0.9 * width
        assert box["x"] + box["width"] <= width
    screen.page.locator("#card-plane").scroll_into_view_if_needed()
    assert screen.page.locator("#p-zeta").is_visible()  # a slider stays beside what it moves


@pytest.mark.slow
def test_long_names_of_states_are_read_beside_their_fields(screen):
    screen.open(replace(opening(text=LONG_NAMES), **SMALL))
    for name in ("position", "temperature"):
        words = screen.page.locator("#start span").get_by_text(name, exact=True)
        assert words.evaluate("(it) => it.scrollWidth <= it.clientWidth")
        box, field = words.bounding_box(), screen.page.locator("#start").get_by_label(name)
        assert box["x"] + box["width"] <= field.bounding_box()["x"]


@pytest.mark.slow
def test_a_range_that_is_cleared_is_told_and_the_page_goes_on(screen, wall):
    screen.open(wall)
    for place in ("0", "1"):
        field = screen.page.locator(f"[data-between='{place}']")
        field.fill("")
        field.press("Enter")
        screen.page.wait_for_function("explorer.gestures.heard === explorer.gestures.sent")
        assert "give two numbers" in screen.page.locator("#toast").inner_text()
        assert "wrong" in field.get_attribute("class")
    assert from_link(screen.link) == wall
    screen.settle()


@pytest.mark.slow
def test_a_choice_that_is_refused_goes_back(screen):
    text = LONG_NAMES.replace("1.0", "1.0\nfixed = 2.0").replace(
        "[equations]", '[require]\n"fixed >= 2" = "so"\n"fixed <= 2" = "so"\n[equations]'
    )
    screen.open(replace(opening(text=text), **SMALL))
    over = screen.page.locator("[data-field=over]")
    assert over.input_value() == "force"
    over.select_option("fixed")
    screen.page.locator("#toast").get_by_text("cannot be varied").wait_for()
    assert over.input_value() == "force"
    screen.settle()


@pytest.mark.slow
def test_a_note_over_a_picture_can_be_put_away(screen, wall):
    screen.open(wall)
    typed(screen, ZENO)
    screen.after("motion", lambda: screen.page.keyboard.press("Control+Enter"))
    screen.settle()
    note = screen.page.locator("#motion-note")
    note.get_by_role("button", name="Hide this note").click()
    assert not note.is_visible()


@pytest.mark.slow
def test_a_server_that_has_ended_is_told_and_one_at_its_address_goes_on(chromium, wall):
    page = ns.explore(link=to_link(wall), browser=False)
    port = int(page.url.partition("/#")[0].rpartition(":")[2])
    context = chromium.new_context()
    try:
        screen = Screen(context.new_page(), f"http://127.0.0.1:{port}").open(wall)
        field = screen.page.get_by_label("value of r", exact=True)
        field.fill("0.5")
        screen.after("motion", lambda: field.press("Enter")).settle()
        page.stop()
        screen.page.locator("#work-text").get_by_text("not connected").wait_for()
        assert "The server of this page has ended" in screen.page.locator("#toast").inner_text()
        page = ns.explore(port=port, browser=False)
        screen.page.locator("#toast").wait_for(state="hidden")  # it tries again, and later again
        screen.page.wait_for_function("window.explorer?.painted.motion > 0")
        assert float(field.input_value()) == 0.5
    finally:
        context.close()
        page.stop()
