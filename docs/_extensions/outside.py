"""Links of pages to files outside of the documentation, which are right on a forge only.

The README is the landing page of a forge, so a link to it leads to that of the site; of a link to
any other file the text is left, with the name of the file behind it.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

from sphinx.application import Sphinx

LINK = re.compile(r"\[([^\]]*)\]\((\.\./[^)#:]+)(?:#[^)]*)?\)")


def stay_inside(app: Sphinx, name: str, source: list[str]) -> None:
    """Replace the links of one page that lead out."""
    page = Path(app.env.doc2path(name))
    if page.suffix != ".md":
        return

    def replaced(link: re.Match[str]) -> str:
        target = Path(os.path.normpath(page.parent / link[2]))
        if target.is_relative_to(app.srcdir):
            return link[0]
        file = target.relative_to(Path(app.srcdir).parent).as_posix()
        return f"[{link[1]}](/index.md)" if file == "README.md" else f"{link[1]} (`{file}`)"

    source[0] = LINK.sub(replaced, source[0])


def setup(app: Sphinx) -> dict[str, bool]:
    """Look at every page before it is read."""
    app.connect("source-read", stay_inside)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
