"""A real browser on a page of the explorer; tests that need it are skipped where there is none."""

import shutil
from dataclasses import replace

import pytest

from nonsmooth.explorer.links import to_link
from nonsmooth.explorer.openings import opening

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip
PATIENCE = 90_000  # milliseconds: a machine may be busy with all other tests
# Little work, so that the tests are about the page.
SMALL = {"columns": 40, "transient": 40, "record": 16, "cells": 12}


@pytest.fixture(scope="session")
def chromium():
    """A browser, for all tests of a process."""
    program = next((found for name in NAMES if (found := shutil.which(name))), None)
    if program is None:
        pytest.skip(f"no browser was found (looked for {', '.join(NAMES)}); install chromium")
    api = pytest.importorskip("playwright.sync_api", reason="playwright drives the browser")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def server():
    """A page that is served, for all tests of a process."""
    pytest.importorskip("bokeh", reason="the page is made with Bokeh, the extra `explore`")
    import nonsmooth as ns

    made = ns.explore(browser=False)
    yield made
    made.stop()


class Screen:
    """A page as a visitor has it before them."""

    def __init__(self, page, address):
        self.page, self.address = page, address
        self.faults = []
        page.on("pageerror", lambda fault: self.faults.append(str(fault)))
        page.on("console", self._note)
        page.set_default_timeout(PATIENCE)

    def _note(self, message):
        if message.type in ("error", "warning"):
            self.faults.append(message.text)

    def open(self, view, link=None):
        link = link or to_link(view)
        self.page.goto(f"{self.address}/#{link}")
        self.page.wait_for_function("window.explorer?.painted.motion > 0")
        return self.settle()

    def settle(self):
        """Wait until no gesture is on its way and nothing is computed, nor about to be."""
        self.page.wait_for_function(
            "explorer.gestures.heard === explorer.gestures.sent"
            " && !document.querySelector('.plot.stale') && explorer.work.size === 0"
        )
        self.page.wait_for_timeout(100)
        return self

    def painted(self, task):
        return self.page.evaluate(f"explorer.painted.{task} ?? 0")

    def after(self, task, action):
        """Do something, and wait for a new piece of a task."""
        before = self.painted(task)
        action()
        self.page.wait_for_function(f"(explorer.painted.{task} ?? 0) > {before}")
        return self

    def model(self, name, expression):
        """Value of an expression of a model of Bokeh, which it calls ``it``."""
        return self.page.evaluate(
            f"(() => {{ const it = Bokeh.documents[0].get_model_by_name('{name}');"
            f" return {expression} }})()"
        )

    def field(self, label):
        return float(self.page.get_by_label(label).input_value())

    @property
    def link(self):
        """What the address says; under a slider it is written when the motion has been painted."""
        self.page.wait_for_function("!explorer.work.has('motion')")
        self.page.wait_for_timeout(100)
        return self.page.evaluate("location.hash.slice(1)")

    def place(self, pane, right, up):
        """A place in the frame of a pane, in pixels of the window."""
        box = self.page.evaluate(
            f"""(() => {{
              const figure = Bokeh.documents[0].get_model_by_name('{pane}');
              const {{ left, top, width, height }} = Bokeh.index.find_one(figure).frame.bbox;
              const plot = document.querySelector('[data-pane="{pane}"]').getBoundingClientRect();
              return [plot.left + left, plot.top + top, width, height];
            }})()"""
        )
        return box[0] + right * box[2], box[1] + (1.0 - up) * box[3]

    def drag(self, pane, begin, end):
        mouse = self.page.mouse
        mouse.move(*self.place(pane, *begin))
        mouse.down()
        mouse.move(*self.place(pane, *end), steps=6)
        mouse.up()


@pytest.fixture
def screen(chromium, server):
    """A fresh page; in the end nothing may have been said in the console of the browser."""
    context = chromium.new_context(
        viewport={"width": 1280, "height": 720},
        permissions=["clipboard-read", "clipboard-write"],
        accept_downloads=True,
    )
    made = Screen(context.new_page(), server.url.partition("/#")[0])
    yield made
    context.close()
    assert made.faults == []


@pytest.fixture
def mole():
    return replace(opening("moling"), **SMALL)


@pytest.fixture
def wall():
    return replace(opening("impact_oscillator"), **SMALL)
