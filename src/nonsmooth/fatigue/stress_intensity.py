r"""Stress intensity of a three-point bend beam with an edge crack: Irwin's and handbook formulas.

Each function gives the shape Y in :math:`K = \frac{P}{B\sqrt W} Y`, which has no dimension, over
the crack ratio :math:`\alpha = a/W` for a span ratio :math:`\beta = L/W`. The nominal stress is
that of beam theory, :math:`1.5 P L/(B W^2)`.

======= ======================================================== ========================== ======
name    source                                                   holds for                  stated
======= ======================================================== ========================== ======
irwin   derivative of the compliance (32)                        all ratios, span from 2.5
guinea  Guinea, Pastor, Planas and Elices, Int. J. Fracture 89   all ratios, span from 2.5  0.5 %
        (1998) 103-116
tada    Tada, Paris and Irwin, The Stress Analysis of Cracks     all ratios, pure bending   0.5 %
        Handbook: an edge crack in pure bending
srawley J.E. Srawley, Int. J. Fracture 12 (1976) 475-476         all ratios, span 4         0.5 %
======= ======================================================== ========================== ======

What they differ by, over crack ratios from 0 to 0.99: guinea from irwin 0.2 % for every span, so
Eq. (32) and the formula are one piece of work; tada from guinea for long spans 2 % about a ratio
of 0.3, where it lies below the handbook's own polynomial for short cracks too; srawley from guinea
1 % from a ratio of 0.2 on. A short crack sees the stress at the edge, which three points make
smaller than beam theory has it by a part 0.177 W/L (Seewald, von Karman); guinea follows that, and
srawley does not.
"""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.errors import OptionError, quote
from nonsmooth.fatigue.checks import Array
from nonsmooth.fatigue.compliance import crack_part_rate

__all__ = ["FORMULAS", "guinea_shape", "irwin_shape", "shape_of", "srawley_shape", "tada_shape"]

FORMULAS = ("irwin", "guinea", "tada", "srawley")
_SRAWLEY_SPAN = 4.0


def shape_of(formula: str, ratio: Array, ligament: Array, span_ratio: float) -> Array:
    """Shape by the name of its formula."""
    if formula == "irwin":
        return irwin_shape(ratio, ligament, span_ratio)
    if formula == "guinea":
        return guinea_shape(ratio, ligament, span_ratio)
    if formula == "tada":
        return tada_shape(ratio, ligament, span_ratio)
    if formula == "srawley":
        return srawley_shape(ratio, ligament, span_ratio)
    raise OptionError(f"formula = {quote(formula)}: give one of {', '.join(FORMULAS)}")


def irwin_shape(ratio: Array, ligament: Array, span_ratio: float) -> Array:
    """Irwin's K^2 = E' P^2/(2B) dC/da in plane stress, where E' is the modulus E of Eq. (32)."""
    return np.sqrt(0.5 * crack_part_rate(ratio, ligament, span_ratio))


def guinea_shape(ratio: Array, ligament: Array, span_ratio: float) -> Array:
    """Formula of Guinea et al. for any span, from those for a span of 4 and for pure bending."""
    at_four = 1.9 + ratio * (0.41 + ratio * (0.51 - 0.17 * ratio))
    pure = 1.99 + ratio * (0.83 + ratio * (-0.31 + 0.14 * ratio))
    mixed = pure + 4.0 / span_ratio * (at_four - pure)
    return 1.5 * span_ratio * np.sqrt(ratio) * mixed / (ligament**1.5 * (1.0 + 3.0 * ratio))


def tada_shape(ratio: Array, ligament: Array, span_ratio: float) -> Array:
    """Handbook formula for pure bending; a load on three points lowers K by some per cent."""
    # sin and cos of half a right angle times the ratio, of which the cosine vanishes at one
    sine, cosine = np.sin(0.5 * math.pi * ratio), np.sin(0.5 * math.pi * ligament)
    bracket = 0.923 + 0.199 * (1.0 - sine) ** 4
    return 1.5 * span_ratio * np.sqrt(2.0 * sine / cosine) * bracket / cosine


def srawley_shape(ratio: Array, ligament: Array, span_ratio: float) -> Array:
    """Formula of the standard specimen, whose span is four times its width."""
    if not math.isclose(span_ratio, _SRAWLEY_SPAN, rel_tol=1e-9):
        raise OptionError(
            f"formula = 'srawley' holds for span/width = 4 only and this specimen has"
            f" {span_ratio:g}; take 'guinea'"
        )
    bracket = 1.99 - ratio * ligament * (2.15 + ratio * (-3.93 + 2.7 * ratio))
    return 6.0 * np.sqrt(ratio) * bracket / ((1.0 + 2.0 * ratio) * ligament**1.5)
