"""Accelerations of a periodic motion integrated twice: a Fourier series beside a drift."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError
from nonsmooth.runs.options import finite_number, whole_number

__all__ = ["FourierIntegral"]

_MOST = 100  # harmonics by default; what is beyond is divided by its square
_MEMORY = 3 * 10**7  # numbers of a matrix
_WHOLE = 1e-6  # of a period that may lack
_MOST_DRIFT = 5

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class FourierIntegral:
    """Fit of harmonics and of a polynomial to samples."""

    angle: Floats  # of the fundamental at the samples
    rate: float  # angular frequency of the fundamental
    harmonics: int
    drift: int  # degree
    edge: int = 0

    @classmethod
    def design(
        cls, count: int, step: float, period: Any, highest: Any, drift: Any
    ) -> FourierIntegral:
        """Fit for some number of samples."""
        length = finite_number("period", period)
        if length <= 0.0:
            raise OptionError(f"period = {length:g} must be positive")
        periods = count * step / length
        if periods < 1.0 - _WHOLE:
            raise OptionError(
                f"period = {length:g} is longer than the data, {count * step:g}; give lowest= for a"
                " motion that does not repeat, or take a longer record"
            )
        degree = (1 if periods >= 2.0 - _WHOLE else 0) if drift is None else drift
        if degree not in range(_MOST_DRIFT + 1):
            raise OptionError(f"drift = {drift!r:.60} must be a whole number from 0 to 5")
        if degree and periods < 2.0 - _WHOLE:
            raise OptionError("drift: it cannot be told from a motion in less than two periods")
        fastest = math.ceil(0.5 * length / step * (1.0 - 1e-9)) - 1  # below half the sample rate
        if fastest < 1:
            raise OptionError(
                f"period = {length:g} holds {length / step:.3g} samples; sample faster"
            )
        wanted = min(fastest, _MOST)
        if highest is not None:
            wanted = math.floor(finite_number("highest", highest) * length * (1.0 + 1e-9))
            if not 1 <= wanted <= fastest:
                raise OptionError(
                    f"highest = {highest:g} must be from 1 / period = {1 / length:g} to below half"
                    f" the sample rate, {0.5 / step:g}"
                )
        if count * (2 * wanted + degree + 1) > _MEMORY:
            raise OptionError(
                f"{wanted} harmonics in {count} samples are too many to fit; give a lower highest=,"
                " or a part of the data"
            )
        angle = 2.0 * math.pi / length * step * np.arange(count, dtype=np.float64)
        angle -= 0.5 * angle[-1]
        return cls(angle, 2.0 * math.pi / length, whole_number("harmonics", wanted), int(degree))

    @property
    def noise_gains(self) -> tuple[float, float]:
        """Of white noise in the acceleration this is left in displacement and velocity."""
        frequencies = self.rate * np.arange(1, self.harmonics + 1)
        share = 2.0 / self.angle.size
        x, v = (math.sqrt(share * float((frequencies**-power).sum())) for power in (4.0, 2.0))
        return x, v

    @cached_property
    def _fit(self) -> tuple[Floats, Floats, npt.NDArray[np.complex128]]:
        """Q and R of what is fitted, and the harmonics at the samples."""
        turns = np.exp(1j * np.outer(self.angle, np.arange(1, self.harmonics + 1)))
        place = self.angle / max(float(np.abs(self.angle).max()), 1e-300)
        drifts = np.polynomial.legendre.legvander(place, self.drift)
        q, r = np.linalg.qr(np.hstack([drifts, turns.real, turns.imag]))
        return q, r, turns

    def __call__(self, values: Floats) -> tuple[Floats, Floats, dict[str, Any]]:
        """Displacement and velocity at the samples."""
        from scipy.linalg import solve_triangular

        q, r, turns = self._fit
        orders = np.arange(1, self.harmonics + 1)
        shares = values @ q
        left = values - q @ shares
        found = solve_triangular(r, shares)
        real, imaginary = np.split(found[self.drift + 1 :], 2)
        amplitude = (real - 1j * imaginary) / (1j * self.rate * orders)  # of the velocity
        velocity = (turns @ amplitude).real
        displacement = (turns @ (amplitude / (1j * self.rate * orders))).real
        words = {
            "period": 2.0 * math.pi / self.rate,
            "harmonics": self.harmonics,
            "residual": float(np.sqrt(np.mean(left * left))),
        }
        return displacement, velocity, words
