"""Accelerations integrated twice by least squares, with a displacement that stays near zero."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError
from nonsmooth.runs.options import finite_number

__all__ = ["RegularIntegral"]

_EDGE = 0.01  # of what an end does is left within the edge
_SLOWEST = 7e-5  # cycles per sample; below it rounding is felt
_REFINED = 3  # corrections of the solution
# integral of s^4/(1 + s^4)^2 from 0 to infinity; of s^6 over that it is three times as much
_NOISE = math.pi * math.sqrt(2.0) / 16.0

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class RegularIntegral:
    r"""Solution of :math:`\sum (D x - a)^2 + \omega_c^4 \sum x^2 = \min`, D second differences."""

    step: float
    corner: float  # omega_c
    lowest: float
    bias: float
    edge: int

    @classmethod
    def design(cls, count: int, step: float, lowest: float, bias: Any) -> RegularIntegral:
        """Integral that loses ``bias`` of a sine of the lowest frequency."""
        lost = finite_number("bias", bias)
        if not 0.0 < lost < 1.0:
            raise OptionError(f"bias = {lost:g} must lie between 0 and 1")
        if not 0.0 < lowest * step < 0.25:
            raise OptionError(
                f"lowest = {lowest:g} must be positive and below a quarter of the sample rate,"
                f" {0.25 / step:g}"
            )
        corner = 2.0 * math.pi * lowest * (lost / (1.0 - lost)) ** 0.25
        if corner * step < 2.0 * math.pi * _SLOWEST:
            raise OptionError(
                f"lowest = {lowest:g} with bias = {lost:g} is too low for {1 / step:g} samples per"
                " unit time; take every second sample or less after low_pass, or give a higher"
                " lowest= or more bias="
            )
        # what an end does fades as exp(-corner t / sqrt(2))
        edge = math.ceil(-math.log(_EDGE) * math.sqrt(2.0) / (corner * step))
        if count <= 2 * edge:
            raise OptionError(
                f"lowest = {lowest:g}: the data last {count * step:g}, and {2 * edge * step:.4g} of"
                " them are not sure at the ends; take a longer record, or give a higher lowest="
                " or more bias="
            )
        return cls(step, corner, lowest, lost, edge)

    @property
    def noise_gains(self) -> tuple[float, float]:
        """Of white noise in the acceleration this is left in displacement and velocity."""
        frequency, density = self.corner / (2.0 * math.pi), 2.0 * self.step
        x = math.sqrt(density * _NOISE / frequency**3) / (2.0 * math.pi) ** 2
        v = math.sqrt(density * 3.0 * _NOISE / frequency) / (2.0 * math.pi)
        return x, v

    def __call__(self, values: Floats) -> tuple[Floats, Floats, dict[str, Any]]:
        """Displacement and velocity at the samples."""
        from scipy.linalg import cho_solve_banded, cholesky_banded

        # an offset does nothing but at the ends, where it would be large
        away = values - values.mean()
        # Numerov: second differences of x are the means of its accelerations with 1, 10, 1
        wanted = self.step**2 / 12.0 * (away[:-2] + 10.0 * away[1:-1] + away[2:])
        weight = (self.corner * self.step) ** 4
        bands = _bands(values.size)
        bands[0] += weight
        factor = cholesky_banded(bands, lower=True)
        x = np.zeros(values.size)
        for _ in range(_REFINED):
            left = wanted - np.diff(x, 2)
            x += cho_solve_banded((factor, True), _transposed(left) - weight * x)
        v = np.gradient(x, self.step, edge_order=2)
        v[1:-1] -= self.step / 12.0 * (away[2:] - away[:-2])
        words = {"lowest": self.lowest, "bias": self.bias, "edge": self.edge * self.step}
        return x, v, words


def _bands(count: int) -> Floats:
    """D^T D of second differences, its diagonal and the two below."""
    bands = np.zeros((3, count))
    rows = np.ones(count - 2)
    for k, c in enumerate((1.0, -2.0, 1.0)):
        bands[0, k : k + count - 2] += c * c * rows
    for k in range(2):
        bands[1, k : k + count - 2] += -2.0 * rows
    bands[2, : count - 2] += rows
    return bands


def _transposed(values: Floats) -> Floats:
    """D^T of values."""
    found = np.zeros(values.size + 2)
    found[:-2] += values
    found[1:-1] -= 2.0 * values
    found[2:] += values
    return found
