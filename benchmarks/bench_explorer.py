"""How long a visitor of the page waits, in a real browser, beside what was promised.

`python benchmarks/bench_explorer.py [--moves N]`, on a machine that does nothing else. It needs
Chromium and playwright. Times run from the gesture to the paint: a slider's from its event to the
frame after the curves came; those of diagrams and basins until their pieces were painted.
"""

import argparse
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from nonsmooth.explorer.links import to_link
from nonsmooth.explorer.openings import opening

try:
    from playwright.sync_api import Page, sync_playwright
except ImportError:
    sys.exit("playwright drives the browser: pip install playwright")

PORT = 5123
FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run")
PATIENCE = 120_000  # milliseconds
SLID = {"moling": "b", "rotor": "eta"}
QUIET = "explorer.work.size === 0 && !document.querySelector('.plot.stale')"


class Wait(NamedTuple):
    """What was waited for, how long, and how long that may be; both in milliseconds."""

    name: str
    took: float
    limit: float


@contextmanager
def served() -> Iterator[str]:
    """Address of a page that the command serves, in a process of its own as users have it."""
    words = ["explore", "moling", "--no-browser", "--port", str(PORT)]
    command = subprocess.Popen([sys.executable, "-m", "nonsmooth", *words], stderr=subprocess.PIPE)
    try:
        assert command.stderr is not None
        command.stderr.readline()  # the command says that the page is there
        yield f"http://127.0.0.1:{PORT}"
    finally:
        command.terminate()
        command.communicate()


def ready(page: Page) -> float:
    """Milliseconds from the command to the painted motion, the browser being open."""
    began = time.perf_counter()
    with served() as address:
        page.goto(f"{address}/", wait_until="commit")
        page.wait_for_function("window.explorer?.painted.motion > 0", polling="raf")
        return 1e3 * (time.perf_counter() - began)


def slides(page: Page, address: str, model: str, moves: int) -> tuple[float, float]:
    """Median and 95th percentile of the times from a slider to the portrait."""
    open_page(page, address, to_link(opening(model)))
    page.evaluate("explorer.timings.length = 0")
    for k in range(moves):
        page.evaluate(
            """(name) => {
              const slider = document.getElementById(`p-${name}`);
              slider.stepUp();
              slider.dispatchEvent(new Event('input'));
            }""",
            SLID[model],
        )
        page.wait_for_function(f"explorer.timings.length > {k}", polling="raf")
    times = page.evaluate("explorer.timings")
    return float(np.median(times)), float(np.percentile(times, 95))


def open_page(page: Page, address: str, link: str) -> None:
    page.goto("about:blank")
    page.goto(f"{address}/#{link}")
    page.wait_for_function("window.explorer?.painted.plane > 0", timeout=PATIENCE)
    page.wait_for_function(QUIET, timeout=PATIENCE)


def pieces(page: Page, task: str, script: str) -> tuple[float, float]:
    """Milliseconds from a gesture to the first and to the last piece of a task."""
    before = page.evaluate(f"explorer.painted.{task}")
    began = time.perf_counter()
    page.evaluate(script)
    page.wait_for_function(f"explorer.painted.{task} > {before}", polling="raf")
    first = time.perf_counter()
    page.wait_for_function(f"!explorer.work.has('{task}')", polling="raf", timeout=PATIENCE)
    last = time.perf_counter()
    page.wait_for_function(QUIET, timeout=PATIENCE)
    return 1e3 * (first - began), 1e3 * (last - began)


def choose(selector: str, value: str) -> str:
    return (
        f"(() => {{ const it = document.querySelector('{selector}'); it.value = '{value}';"
        " it.dispatchEvent(new Event('change')); })()"
    )


def gestures(page: Page, address: str, moves: int) -> list[Wait]:
    """The waits for sliders, diagrams and a basin."""
    waits = []
    for model in SLID:
        middle, high = slides(page, address, model, moves)
        waits.append(Wait(f"{model}: slider to portrait, median", middle, 100.0))
        waits.append(Wait(f"{model}: slider to portrait, 95 %", high, 200.0))
    for model in SLID:
        open_page(page, address, to_link(opening(model)))
        coarse, fine = pieces(page, "diagram", choose('[data-between="0"]', "0.05"
                              if model == "moling" else "1.6"))  # fmt: skip
        waits.append(Wait(f"{model}: diagram of 400 columns, coarse", coarse, 500.0))
        waits.append(Wait(f"{model}: diagram of 400 columns, fine", fine, 3000.0))
    open_page(page, address, to_link(opening("moling")))
    _, basin = pieces(page, "plane", "document.getElementById('whole-region').click()")
    waits.append(Wait("moling: basin of 10,000 starts", basin, 2000.0))
    return waits


def measure(moves: int) -> list[Wait]:
    """All waits."""
    program = shutil.which("chromium") or shutil.which("google-chrome")
    if program is None:
        sys.exit("no Chromium was found")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        page.set_default_timeout(PATIENCE)
        waits = [Wait("page ready after the command", ready(page), 3000.0)]
        with served() as address:
            waits += gestures(page, address, moves)
        browser.close()
    return waits


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--moves", type=int, default=60, help="moves of each slider")
    options = parser.parse_args(arguments)
    waits = measure(options.moves)
    for wait in waits:
        mark = "" if wait.took <= wait.limit else "  over the limit"
        print(f"{wait.name:42s} {wait.took:8.0f} ms   of {wait.limit:6.0f} ms{mark}")
    return int(any(wait.took > wait.limit for wait in waits))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
