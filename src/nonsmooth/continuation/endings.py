"""What a branch says at its end, and what to try."""

from __future__ import annotations

from nonsmooth.continuation.corrector import Node
from nonsmooth.continuation.options import Options

__all__ = ["message_of"]


def message_of(ended: str, node: Node, options: Options, reason: str) -> str:
    """A sentence for the end of a branch."""
    where = f"at p = {node.p:.10g}"
    why = f" ({reason})" if reason else ""
    smallest = f"smallest_step = {options.smallest:g}"
    return {
        "bound": _bound(node, options),
        "steps": f"{options.steps} steps were taken, up to p = {node.p:.10g}; allow more with"
        " steps=, or longer ones with largest_step=",
        "closed": "the branch came back to its start: it is a closed curve",
        "domain": f"the residual has no finite value beyond p = {node.p:.10g}{why}: the branch ends"
        f" there to within {smallest}",
        "singular": f"the derivatives are singular {where}{why}: no single smooth curve goes on; if"
        " branches cross there, branch_directions says where they go",
        "smallest_step": f"no step from {smallest} on was taken {where}{why}: the curve has a"
        " corner or a jump there, or derivatives that are given are wrong; try a smaller"
        " smallest_step=, more max_newton=, a larger tolerance= for a residual that is not good"
        " to 1e-9, or no derivatives",
    }[ended]


def _bound(node: Node, options: Options) -> str:
    """Which parameter came to its bound; the last unknown has one only where it is a parameter."""
    first = float(node.u[-1])
    if first in options.unknown_bounds:
        return (
            f"the first parameter reached its bound {first:.10g}, where the second one is"
            f" {node.p:.10g}"
        )
    return f"the branch reached the bound at p = {node.p:.10g}"
