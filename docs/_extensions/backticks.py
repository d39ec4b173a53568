"""Texts of docstrings: single backticks, and where their first sentence ends.

Backticks are a link where they name something public, and code elsewhere.
"""

from __future__ import annotations

from types import ModuleType

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.ext import autosummary
from sphinx.util.docutils import SphinxRole

import nonsmooth

PACKAGE = "nonsmooth."


def public_names() -> dict[str, str]:
    """Full names of all that users can import, and of the modules that hold it, with their pages.

    A class that has a short name beside that of its module has the page of the module.
    """
    names, places = {}, {}
    for name in nonsmooth.__all__:
        names[PACKAGE + name] = PACKAGE + name
        thing = getattr(nonsmooth, name)
        if isinstance(thing, ModuleType):
            for inner in thing.__all__:
                full = f"{PACKAGE}{name}.{inner}"
                names[full] = full
                places[id(getattr(thing, inner))] = full
    for name in nonsmooth.__all__:
        thing = getattr(nonsmooth, name)
        if isinstance(thing, type) and id(thing) in places:
            names[PACKAGE + name] = places[id(thing)]
    return names


class PublicName(SphinxRole):
    """`simulate` is a link to `nonsmooth.simulate`; `omega` is code."""

    names = public_names()

    def run(self) -> tuple[list[nodes.Node], list[nodes.system_message]]:
        """Node for the text."""
        code = nodes.literal(self.rawtext, self.text)
        target = self.target()
        if target is None:
            return [code], []
        link = pending_xref(
            self.rawtext,
            code,
            refdomain="py",
            reftype="obj",
            reftarget=target,
            refdoc=self.env.docname,
            refwarn=True,
        )
        return [link], []

    def target(self) -> str | None:
        """Full name meant by the text; that of the package goes before that of a module."""
        here = self.env.ref_context.get("py:module") or "nonsmooth"
        text = self.text.removeprefix("ns.").removesuffix("()")
        for full in (text, PACKAGE + text, f"{here}.{text}"):
            if full in self.names:
                return self.names[full]
        return None


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the role, which conf.py makes the default one."""
    app.add_role("public", PublicName())
    autosummary.WELL_KNOWN_ABBREVIATIONS += ("Eq.", "Eqs.", "Fig.", "Figs.")  # no ends of sentences
    return {"parallel_read_safe": True, "parallel_write_safe": True}
