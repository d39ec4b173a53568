"""Formulas as MathML, which browsers draw by themselves: no script and nothing to fetch."""

from __future__ import annotations

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator


def converted(tex: str, block: bool) -> str:
    """MathML of a formula; primes as the sign for them, not as the apostrophe of the source."""
    return tex2mathml(tex, as_block=block).replace("<mo>'</mo>", '<mo lspace="0">&prime;</mo>')


def visit_math(self: HTML5Translator, node: nodes.math) -> None:
    """Formula in a line."""
    self.body.append(converted(node.astext(), block=False))
    raise nodes.SkipNode


def visit_displaymath(self: HTML5Translator, node: nodes.math_block) -> None:
    """Formula that stands by itself."""
    self.body.append(f'<div class="formula">{converted(node.astext(), block=True)}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer, which conf.py chooses."""
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_displaymath, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
