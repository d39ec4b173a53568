"""Draw the pictures of the page in the browser anew: ``python docs/screens.py``.

It serves the page, opens it in Chromium, which playwright drives, and writes what is seen into
``images``. `docs/pictures.py` draws all other pictures.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

import nonsmooth as ns

IMAGES = Path(__file__).parent / "images"
FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run")
SIZE = {"width": 1280, "height": 720}
PATIENCE = 300_000  # milliseconds
# name of the picture: link of the view
SCREENS = {
    "explorer-mole": "model=moling&p.b=0.11&p.xi=0.1&p.omega=1.58&leave_out=100&length=12&drawn=x,v"
    "&portrait=p,y&over=omega&between=1.35,1.75&shown=y&plane=p,y&region=-3,1,-1,1"
}


def main() -> None:
    """Write all pictures."""
    program = shutil.which("chromium") or shutil.which("google-chrome")
    if program is None:
        sys.exit("no Chromium was found")
    served = ns.explore(browser=False)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
        page = browser.new_page(viewport=SIZE)
        for name, link in SCREENS.items():
            page.goto(f"{served.url.partition('#')[0]}#{link}")
            page.wait_for_function("window.explorer?.painted.plane > 1", timeout=PATIENCE)
            page.wait_for_function("explorer.work.size === 0", timeout=PATIENCE)
            page.screenshot(path=IMAGES / f"{name}.png")
            print(f"images/{name}.png")
        browser.close()
    served.stop()


if __name__ == "__main__":
    main()
