"""Shaking: records of base acceleration of equal power, and a specimen that is shaken by them.

Accelerations are in m/s^2, times in s, frequencies in Hz; displacements in mm and loads in N.
"""

from __future__ import annotations

from nonsmooth.excitation.band_noise import band_noise
from nonsmooth.excitation.duffing_wave import duffing
from nonsmooth.excitation.equal_power import equal_power, power_ratio
from nonsmooth.excitation.harmonic import harmonic
from nonsmooth.excitation.lives_under_shaking import lives_under_shaking, spread_of_life_ratio
from nonsmooth.excitation.record import Excitation
from nonsmooth.excitation.shaken_specimen import ShakenSpecimen

__all__ = [
    "Excitation",
    "ShakenSpecimen",
    "band_noise",
    "duffing",
    "equal_power",
    "harmonic",
    "lives_under_shaking",
    "power_ratio",
    "spread_of_life_ratio",
]


def __dir__() -> list[str]:
    return sorted(__all__)
