"""Lives under chaotic and harmonic shaking: what is stated where the chapter gives no data.

The chapter says neither which Duffing oscillator drove the shaker, nor by what measure the power
was equal, nor how the rig is damped. Stated here: Ueda's oscillator, its displacement as base
acceleration, equal mean square of the base acceleration (what drives the shaker), and the rig of
Fig. 25 reduced to one mass. What else may be is looked at over `WAVES`, `RIGS`, `DAMPINGS` and
`MEASURES`.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import xarray as xr

from nonsmooth.excitation import (
    Excitation,
    ShakenSpecimen,
    duffing,
    equal_power,
    harmonic,
    lives_under_shaking,
    spread_of_life_ratio,
)
from nonsmooth.fatigue import (
    FittedLaw,
    LoadBlock,
    LoadTable,
    Specimen,
    Walker,
    chapter_tests,
    count_cycles,
    fit_law,
    life,
    published_laws,
)
from nonsmooth_chapter.fatigue.crack_motions import ETA, K_CLOSED, XI
from nonsmooth_chapter.fatigue.rig_claims import rig_of_fig_25

__all__ = [
    "CRACKS",
    "DAMPINGS",
    "FREQUENCY",
    "MEANS",
    "MEASURES",
    "RIGS",
    "STATED",
    "WAVES",
    "curves",
    "fitted_law",
    "scaled_records",
    "shaken",
    "sine",
    "spread",
    "stated_lives",
    "wave",
]

FREQUENCY, AMPLITUDE = 20.0, 100.0  # Hz; N of the harmonic load at the first length
DURATION, TRANSIENT = 12.0, 4.0  # s
CRACKS = (6.4, 9.0, 11.5, 14.0)  # mm
MEANS = (0.0, 150.0)  # N, of Figs. 21 and 22
MEASURES = ("acceleration", "load")
STATED = "Ueda, displacement"
WAVES: dict[str, dict[str, Any]] = {
    STATED: {},
    "Ueda, velocity": {"variable": "v"},
    "Ueda, acceleration": {"variable": "acceleration"},
    "two wells, displacement": {"alpha": -1.0, "beta": 1.0, "delta": 0.25, "gamma": 0.4},
}
RIGS = ("Fig. 25", "Fig. 29")
DAMPINGS = (XI, 0.392)  # of Fig. 29, and what the data of Fig. 25 reduce to
_LAW = "walker 2024-T3"


@lru_cache(maxsize=8)
def wave(name: str = STATED) -> Excitation:
    """Chaotic base acceleration, its strongest line at 20 Hz.

    Parameters
    ----------
    name : str, optional
        One of `WAVES`.

    Returns
    -------
    Excitation
        With a root mean square of 1 m/s^2.
    """
    return duffing(FREQUENCY, duration=DURATION, **WAVES[name])


@lru_cache(maxsize=1)
def sine() -> Excitation:
    """Harmonic base acceleration.

    Returns
    -------
    Excitation

    Examples
    --------
    >>> sine().dominant_frequency
    20.0
    """
    return harmonic(FREQUENCY, duration=DURATION, samples_per_period=32)


def shaken(rig: str = RIGS[0], mean: float = 0.0, damping: float | None = None) -> ShakenSpecimen:
    """One mass on the chapter's specimen with a crack.

    Parameters
    ----------
    rig : str, optional
        Whose natural frequency and stiffness: of Fig. 25 in SI units, or of Fig. 29 at 20 Hz.
    mean : float, optional
        Mean load in N.
    damping : float, optional
        Damping ratio; that of the rig if left out.

    Returns
    -------
    ShakenSpecimen

    Examples
    --------
    >>> round(shaken().natural_frequency, 1), round(shaken().damping, 3)
    (34.3, 0.392)
    """
    s = Specimen()
    if rig == "Fig. 29":
        data = {"natural_frequency": FREQUENCY / ETA, "damping": XI, "closed_ratio": K_CLOSED}
    else:
        one = rig_of_fig_25().one_mass_data()
        data = {
            "natural_frequency": one.natural_frequency,
            "damping": one.damping_ratio,
            "closed_ratio": one.specimen_stiffness / one.stiffness,
        }
    if damping is not None:
        data["damping"] = damping
    return ShakenSpecimen(s.stiffness, s.closed_stiffness, mean_load=mean, **data)


@lru_cache(maxsize=4)
def stated_lives(mean: float) -> xr.Dataset:
    """Lives of the stated case at a mean load.

    Parameters
    ----------
    mean : float
        Mean load in N.

    Returns
    -------
    xarray.Dataset
        Result of `nonsmooth.excitation.lives_under_shaking`.
    """
    return lives_under_shaking(
        shaken(mean=mean), sine(), wave(), Specimen().stress_intensity, published_laws()[_LAW],
        load_amplitude=AMPLITUDE, cracks=CRACKS, transient=TRANSIENT,
    )  # fmt: skip


@lru_cache(maxsize=8)
def spread(
    rig: str, waves: tuple[str, ...] = tuple(WAVES), dampings: tuple[float, ...] = DAMPINGS
) -> xr.Dataset:
    """Ratios of lives over the unknowns, for one rig.

    Parameters
    ----------
    rig : str
        One of `RIGS`.
    waves : tuple of str, optional
        Some of `WAVES`.
    dampings : tuple of float, optional
        Damping ratios.

    Returns
    -------
    xarray.Dataset
        Result of `nonsmooth.excitation.spread_of_life_ratio`.
    """
    laws = {"published": published_laws()[_LAW], "fitted": fitted_law()}
    return spread_of_life_ratio(
        shaken(rig), sine(), {name: wave(name) for name in waves}, Specimen().stress_intensity,
        laws, mean_loads=MEANS, dampings=dampings, measures=MEASURES, load_amplitude=AMPLITUDE,
        cracks=CRACKS, transient=TRANSIENT,
    )  # fmt: skip


@lru_cache(maxsize=1)
def fitted_law() -> FittedLaw:
    """Walker's law fitted to the eight lives of Table 3, in sample.

    Returns
    -------
    FittedLaw

    Examples
    --------
    >>> fitted_law().in_sample
    True
    """
    law = published_laws()[_LAW]
    assert isinstance(law, Walker)
    return fit_law(chapter_tests(), Specimen().stress_intensity, law, free=("C", "m", "gamma"))


def scaled_records(mean: float) -> tuple[Excitation, Excitation]:
    """The harmonic and the chaotic record of the stated case, as they shake the specimen.

    Parameters
    ----------
    mean : float
        Mean load in N.

    Returns
    -------
    harmonic, chaotic : Excitation
    """
    rms = float(stated_lives(mean).attrs["reference_rms"])
    first = sine().scaled(rms / sine().power() ** 0.5)
    return first, equal_power(wave(), first)


@lru_cache(maxsize=4)
def curves(mean: float) -> tuple[xr.Dataset, xr.Dataset]:
    """Crack over time of the stated case, harmonic and chaotic.

    Parameters
    ----------
    mean : float
        Mean load in N.

    Returns
    -------
    harmonic, chaotic : xarray.Dataset
        Results of `nonsmooth.fatigue.life`.
    """
    rig, found = shaken(mean=mean), []
    for record in scaled_records(mean):
        blocks = [
            LoadBlock.from_cycles(
                count_cycles(rig.load(record, crack, TRANSIENT), repeating=True, refine=True)
            )
            for crack in CRACKS
        ]
        found.append(
            life(
                Specimen().stress_intensity, published_laws()[_LAW], LoadTable(CRACKS, blocks),
                initial=CRACKS[0], final=CRACKS[-1],
            )
        )  # fmt: skip
    return found[0], found[1]
