"""`Surface`: a switching surface with a name, names for its sides, and what holds on it."""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.errors import ModelError, is_known, quote
from nonsmooth.system.parts import Text
from nonsmooth.system.text.grammar import is_name, why_no_name

__all__ = ["Surface"]


@dataclass(frozen=True, slots=True)
class Surface:
    """A named switching surface, on which motion may slide.

    Surfaces are found in the texts without being declared: every ``sign``, ``abs``, ``max`` and
    so on has one. To declare one gives it a name that stands for its function in all texts,
    names its sides in phase words, and says what else holds on it.

    Where the field jumps so that both sides point at the surface, motion slides on it by
    Filippov's convex combination of the two fields: ``sign`` of the surface takes the value
    between -1 and 1 with which the motion stays, until that value reaches -1 or 1, or
    ``hold`` times that.

    Parameters
    ----------
    function : str
        Expression that is zero on the surface.
    below, on, above : str, optional
        Names of the cells with a negative, zero and positive function, for phase words. A cell is
        called by them where each of its surfaces has a name for its side; where one has none it is
        called by signs, as in ``flow[+-]``. `Mode` names such cells by ``cells``.
    hold : str or float, optional
        How much the surface holds, beside what it does while motion passes: static over kinetic
        friction, dimensionless, 1 or more. Motion that arrives stays while it can be held.
    on_nonunique : {"below", "above"}, optional
        Side to which motion leaves a start from which both sides lead away. Without it such a
        run ends with the status ``nonunique``.

    Examples
    --------
    A block on a belt, with static friction above kinetic friction:

    >>> import nonsmooth as ns
    >>> belt = ns.System(
    ...     states=["x", "v"],
    ...     parameters={"v_b": 0.3, "F_k": 0.4, "F_s": 0.6},
    ...     equations={"x": "v", "v": "-x - F_k*sign(slip)"},
    ...     surfaces={
    ...         "slip": ns.Surface("v - v_b", below="lag", on="stick", above="lead", hold="F_s/F_k")
    ...     },
    ... )
    >>> ns.phase_word(ns.simulate(belt, {"x": 0.2, "v": 0.3}, t_end=10))
    ('stick', 'lag', 'stick', 'lag')
    """

    function: Text
    below: str | None = None
    on: str | None = None
    above: str | None = None
    hold: Text | None = None
    on_nonunique: str | None = None

    def __post_init__(self) -> None:
        if isinstance(self.function, bool) or not isinstance(self.function, str | int | float):
            raise ModelError(
                f"Surface: {quote(self.function)} is no expression; give what is zero on the"
                " surface, such as 'v - v_b'"
            )
        if isinstance(self.hold, bool) or not isinstance(self.hold, str | int | float | None):
            raise ModelError(
                f"Surface: hold={quote(self.hold)} is no expression; give static over kinetic"
                " friction, such as 'F_s/F_k', or leave it out"
            )
        for label in ("below", "on", "above"):
            value = getattr(self, label)
            if value is not None and not (isinstance(value, str) and is_name(value)):
                raise ModelError(
                    f"Surface: {label}={quote(value)} is not a name; use ASCII letters, digits and"
                    f" _, not a reserved word{why_no_name(value)}"
                )
        names = [name for name in (self.below, self.on, self.above) if name is not None]
        for name in names:
            if names.count(name) > 1:
                raise ModelError(
                    f"Surface: two of below, on and above are called {name!r}; give each side a"
                    " name of its own, for phase words are made of them"
                )
        if self.on_nonunique is not None and not is_known(self.on_nonunique, ("below", "above")):
            raise ModelError(
                f"Surface: on_nonunique={quote(self.on_nonunique)} is not known; give 'below' or"
                " 'above', or leave it out"
            )
