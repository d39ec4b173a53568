"""A point of a branch of orbits, and why a branch ends."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nonsmooth.continuation.point import Point
from nonsmooth.periodic_orbits.branch_tests import Looked, what_of
from nonsmooth.periodic_orbits.graze_pole import has_pole
from nonsmooth.periodic_orbits.multipliers import UNBOUNDED, Floquet, multipliers_at_touch
from nonsmooth.periodic_orbits.stretch import BranchStretch
from nonsmooth.periodic_orbits.symmetric import is_antisymmetric, reflection
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.system.model.value_checks import IS_REQUIRED

__all__ = [
    "OF_MULTIPLIERS",
    "BranchPart",
    "Followed",
    "ending_of_orbits",
    "is_critical",
    "kind_of",
    "kind_of_crossing",
    "part_of",
]


_OF_EQUATIONS = ("residual", "derivative", "test ", "matrix")  # reasons that tell of no orbit
_KINDS = {
    "graze": "grazing", "short": "grazing", "rate": "grazing", "leg": "lost",
    "gain": "gained", "over": "gained", "slide": "sliding",
    "enter": "sliding", "shrink": "hopf", "rest": "lost", "border": "boundary_equilibrium",
    "motion": "word_change",
}  # fmt: skip
OF_MULTIPLIERS = ("flip", "torus", "fold", "branch_point")
_NEAR_ONE = 1e-3  # the same at a fold or a crossing, which some orbits have only to half the digits
_CRITICAL = 1e-5  # distance from the unit circle of a multiplier that is on it


def ending_of_orbits(ended: str, message: str, parameter: str, value: float) -> str:
    """A sentence for the end of a branch of orbits.

    Branches of any equations speak of residuals, of ``p`` and of options that orbits have not;
    ``message`` is what they say, and stays where orbits have nothing else to say.
    """
    here = f"{parameter} = {value:.10g}"
    reason = _reason(message)
    if ended == "domain" and IS_REQUIRED in reason:
        return (
            f"the branch ends at {here}, beyond which the system refuses the parameters:"
            f" {reason[2:-1]}; correct this of require= if it should hold there"
        )
    again = "begin anew with an orbit beyond it, from find_orbit with other parameters="
    return {
        "bound": f"the branch reached the bound {here}",
        "closed": "the branch came back to its start: it is a closed curve",
        "domain": f"beyond {here} the legs of the orbit are not defined{reason}, as where a guard"
        " is no longer reached or a state leaves the domain of an equation; simulate a little"
        f" beyond to see what the motion does, and {again}",
        "singular": f"at {here} the equations of the orbit do not fix one curve, as where branches"
        " cross, motions of any amplitude repeat, or a state may be anywhere at the start;"
        f" {again}",
        "smallest_step": f"no step from smallest_step= on was taken at {here}{reason}: the branch"
        " has a corner or a jump there, or an event is nearly grazed; try a smaller"
        f" smallest_step=, or {again}",
    }.get(ended, message.replace("up to p = ", f"up to {parameter} = "))


def _reason(message: str) -> str:
    """What is said in brackets behind the value, with a blank before it."""
    _, bracket, rest = message.partition(" (")
    inside, closed, _ = rest.rpartition("):")
    said = bracket and closed and not any(word in inside for word in _OF_EQUATIONS)
    return f" ({inside})" if said else ""


@dataclass
class BranchPart:
    """A point of a branch of orbits; ``special`` says what happens there."""

    word: Word
    looked: Looked
    value: float
    arclength: float
    special: str = ""
    detail: str = ""
    test: str = ""  # what vanishes there, as `BranchTests` names it for this word
    way: float = 0.0  # of the parameter along the branch: its sign
    unbounded: bool = False  # whether a multiplier has no bound there, on one side at least


@dataclass(frozen=True)
class Followed:
    """Why a branch ended."""

    ended: str = ""
    message: str = ""


def kind_of(name: str) -> str:
    """What a test of the word is called where it ends a branch."""
    kind = what_of(name)
    return _KINDS.get(kind, kind)


def part_of(
    stretch: BranchStretch, looked: Looked, point: Point, along: float, special: str, detail: str
) -> BranchPart:
    """A point with what happens there."""
    if (
        special == "branch_point"
        and looked.reflection is not None
        and looked.reflection.later is None
    ):
        stretch.set_parameter(point.p)
        own = reflection(stretch.equations, looked.turn, at_crossing=True)
        looked = replace(looked, reflection=own)
    # of several directions that are critical at once some are antisymmetric, and others are not
    if (
        special == "branch_point"
        and count_at_one(looked) < 2
        and is_antisymmetric(stretch.equations, looked.turn, looked.reflection)
    ):
        special = "symmetry_breaking"
    test = point.special if special else ""
    way = float(np.sign(point.tangent_p))
    unbounded = False
    if special == "grazing":
        stretch.set_parameter(point.p)
        unbounded = has_pole(stretch.equations, looked.turn, point.special)
        if what_of(point.special) == "rate":
            looked = replace(looked, multipliers=_at_touch(stretch, looked, unbounded=unbounded))
    return BranchPart(
        stretch.equations.word, looked, point.p, along, special, detail, test, way, unbounded
    )


def _at_touch(stretch: BranchStretch, looked: Looked, *, unbounded: bool) -> Floquet:
    """Multipliers where an impact has no speed: one is infinite, or all of them have limits.

    Rounding has made a large one of any sign of the infinite one.
    """
    if not unbounded:
        return multipliers_at_touch(stretch.equations, looked.turn)
    values = looked.multipliers.multipliers.copy()
    if values.size and not abs(values[0]) <= UNBOUNDED:  # no number where there is no rate at all
        values[0] = np.inf
    return looked.multipliers._replace(multipliers=values)


def count_at_one(looked: Looked) -> int:
    """How many multipliers are 1, as far as rounding tells where branches cross."""
    values = looked.multipliers.multipliers
    return int(np.count_nonzero(np.abs(values - 1.0) <= _CRITICAL))


def kind_of_crossing(looked: Looked) -> str:
    """What happens where multipliers are on the unit circle; "" where none is."""
    kinds = ("flip", "torus", "branch_point")
    return next((kind for kind in kinds if is_critical(looked, kind)), "")


def is_critical(looked: Looked, kind: str) -> bool:
    """Whether a multiplier is at 1 or -1, or a pair of them on the unit circle."""
    values = looked.multipliers.multipliers
    if not values.size or not np.all(np.isfinite(values)):
        return kind in ("fold", "branch_point")
    if kind in ("fold", "branch_point"):
        return bool(np.any(np.abs(values - 1.0) <= _NEAR_ONE))
    if kind == "flip":
        return bool(np.any(np.abs(values + 1.0) <= _CRITICAL))
    near = np.abs(np.abs(values) - 1.0) <= _CRITICAL
    return bool(np.any(near & (np.abs(values.imag) > _CRITICAL)))
