"""Draw the pictures of the pages anew: ``python docs/pictures.py tutorials case-studies``.

The blocks of each page run in a folder of their own, and what they save under the name of a picture
on the page replaces that picture. Nothing else is written. A page whose blocks are of ``py``, which
need ROSS, is drawn where it is named itself: ``python docs/pictures.py how-to/from-ross.md``.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shutil
import sys
import tempfile
from pathlib import Path

DOCS = Path(__file__).parent.resolve()


def _language(text: str) -> str:
    return "python" if "```python\n" in text else "py"


def draw(page: Path) -> list[Path]:
    """Run the blocks of Python of a page and keep the pictures that it shows."""
    import matplotlib

    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    text = page.read_text(encoding="utf-8")
    targets = [
        (page.parent / link).resolve() for link in re.findall(r"!\[[^]]*\]\(([^)]+)\)", text)
    ]
    names: dict[str, object] = {}
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        with contextlib.redirect_stdout(io.StringIO()):
            for block in re.findall(rf"```{_language(text)}\n(.*?)```", text, re.S):
                exec(compile(block, page.name, "exec"), names)
        plt.close("all")
        for target in targets:
            target.parent.mkdir(exist_ok=True)
            shutil.copyfile(target.name, target)
        os.chdir(DOCS)
    return targets


def main(arguments: list[str]) -> None:
    """Draw the pictures of pages, or of all pages of folders, named below ``docs``."""
    places = [DOCS / name for name in arguments]
    found = [[place] if place.suffix else sorted(place.glob("*.md")) for place in places]
    # the picture of a page without code is one of a browser: docs/screens.py draws it
    found = [
        [page for page in pages if len(pages) == 1 or "```python" in page.read_text("utf-8")]
        for pages in found
    ]
    for page in (page for pages in found for page in pages):
        for target in draw(page):
            print(target.relative_to(DOCS))


if __name__ == "__main__":
    main(sys.argv[1:])
