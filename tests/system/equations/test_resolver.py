"""Resolvers are asked again and again, by texts that come and go."""

import pytest

from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.equations.equation import Equation
from nonsmooth.system.equations.mode_equations import ModeEquations
from nonsmooth.system.equations.resolve import Resolver
from nonsmooth.system.equations.switching import Undecided
from nonsmooth.system.text.expressions import to_text

KNOWN = {"x", "v", "d"}


def resolver(**definitions):
    read = {name: Equation.read(text, name, KNOWN) for name, text in definitions.items()}
    return Resolver(Graph(["x", "v"]), ModeEquations("m", read, {}, {}, ()), {})


def test_a_text_is_not_taken_for_one_that_is_gone():
    """A new tree may lie where one lay that was read before."""
    asked = resolver()
    for k in range(100):
        name = "xv"[k % 2]
        text = f"{name} + {k}"
        assert to_text(asked.tree(Equation.read(text, "text", KNOWN))) == text


def test_what_is_undecided_stays_so():
    asked = resolver(d="abs(x)")
    for _ in range(2):
        with pytest.raises(Undecided):
            asked.tree(Equation.read("d + 1", "text", KNOWN))
