"""Look for links of the built site that lead nowhere: ``python docs/links.py docs-output/html``.

Files and anchors within the site are looked up; addresses elsewhere are only counted.
"""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """Anchors of a page and what it links to."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.targets: set[str] = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Keep the attributes that name a place or lead to one."""
        for key, value in attrs:
            if value and key in ("id", "name"):
                self.anchors.add(value)
            elif value and key in ("href", "src"):
                self.targets.add(value)


def broken(site: Path) -> tuple[list[str], int]:
    """Links that lead nowhere, and how many addresses lie elsewhere."""
    # Below _static are templates of the theme, which are no pages.
    paths = [path for path in site.rglob("*.html") if "_static" not in path.parts]
    pages = {path: Page(path) for path in paths}
    faults, elsewhere = [], 0
    for path, page in pages.items():
        for target in sorted(page.targets):
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                elsewhere += parts.scheme != "data"
                continue
            there = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            there = there / "index.html" if there.is_dir() else there
            anchor = unquote(parts.fragment)
            missing = anchor and there in pages and anchor not in pages[there].anchors
            if not there.exists() or missing:
                faults.append(f"{path.relative_to(site)}: {target}")
    return faults, elsewhere


def main(site: Path) -> None:
    """Print the faults; the exit code says whether there are any."""
    faults, elsewhere = broken(site.resolve())
    print("\n".join(faults) or f"Every link within the site resolves; {elsewhere} lead elsewhere.")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
