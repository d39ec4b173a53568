r"""Compliance of a three-point bend beam with an edge crack at midspan, Eqs. (30)-(32).

Everything here has no dimension: the crack ratio :math:`\alpha = a/W`, the ligament
:math:`\lambda = 1 - \alpha`, the span ratio :math:`\beta = L/W`, and compliances times EB. The
ligament is an argument, since :math:`1 - a/W` from a rounded a/W would cost digits near one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nonsmooth.fatigue.checks import Array

__all__ = ["LEAST_SPAN_RATIO", "TERMS", "beam_part", "crack_part", "crack_part_rate"]

LEAST_SPAN_RATIO = 2.5  # below it Eq. (32) was not fitted


class Term(NamedTuple):
    r"""One of c1, c2, c3: :math:`p \alpha^3 \ln\lambda + \alpha^2 N(\alpha)/(\lambda^n D(\alpha))`.

    Coefficients stand in the order of rising powers.
    """

    logarithm: float
    numerator: tuple[float, ...]
    power: int
    denominator: tuple[float, ...]


# G.V. Guinea, J.Y. Pastor, J. Planas, M. Elices, Int. J. Fracture 89 (1998) 103-116, as in (32)
TERMS = (
    Term(-0.378, (0.29, 1.39, -1.6), 0, (1.0, 0.54, -0.84)),
    Term(1.1, (-3.22, -16.4, 28.1, -11.4), 1, (1.0, 4.7, -4.0)),
    Term(-0.176, (8.91, -4.88, -0.435, 0.26), 2, (1.0, 2.9)),
)


def beam_part(span_ratio: float) -> float:
    """EB times the compliance of the beam without a crack, Eq. (31)."""
    return 0.25 * span_ratio**3


def crack_part(ratio: Array, ligament: Array, span_ratio: float) -> Array:
    """EB times the compliance that the crack adds, Eq. (32)."""
    logarithm = np.log(ligament)  # times the ratio it is small where it has lost digits
    total = np.zeros_like(ratio)
    for k, term in enumerate(TERMS):
        below = ligament**term.power * _polynomial(term.denominator, ratio)
        value = term.logarithm * ratio * logarithm + _polynomial(term.numerator, ratio) / below
        total = total + span_ratio**k * value
    return ratio**2 * total


def crack_part_rate(ratio: Array, ligament: Array, span_ratio: float) -> Array:
    """Derivative of `crack_part` by the crack ratio."""
    logarithm = np.log(ligament)
    total = np.zeros_like(ratio)
    for k, term in enumerate(TERMS):
        above = _polynomial(term.numerator, ratio)
        below = _polynomial(term.denominator, ratio)
        # of ln(N/(lambda^n D)), times N
        slope = _slope(term.numerator, ratio) + above * (
            term.power / ligament - _slope(term.denominator, ratio) / below
        )
        value = term.logarithm * ratio * (3.0 * logarithm - ratio / ligament)
        value = value + (2.0 * above + ratio * slope) / (ligament**term.power * below)
        total = total + span_ratio**k * value
    return ratio * total


def _polynomial(coefficients: tuple[float, ...], x: Array) -> Array:
    value = np.full_like(x, coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        value = coefficient + x * value
    return value


def _slope(coefficients: tuple[float, ...], x: Array) -> Array:
    return _polynomial(tuple(k * c for k, c in enumerate(coefficients) if k), x)
