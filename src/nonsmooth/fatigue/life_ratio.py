"""`life_ratio`: life under one load by that under another."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nonsmooth.fatigue.closure import NewmanClosure
from nonsmooth.fatigue.growth_laws import GrowthLaw
from nonsmooth.fatigue.growth_rate import Loads, StressIntensity, check_loads
from nonsmooth.fatigue.life import life

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["life_ratio"]


def life_ratio(
    stress_intensity: StressIntensity,
    law: GrowthLaw,
    reference: Loads,
    loads: Loads,
    *,
    initial: float,
    final: float,
    toughness: float | None = None,
    closure: str | float | NewmanClosure = "shut",
) -> xr.Dataset:
    """Life under a reference load by that under another one, of the same crack.

    Parameters
    ----------
    stress_intensity : callable
        As of `life`.
    law : Paris, Walker or Forman
        Law of growth.
    reference, loads : LoadBlock, LoadTable or callable
        The two loads, such as a harmonic and a chaotic one. That their power is equal is up to
        you; see `nonsmooth.excitation`.

    Other Parameters
    ----------------
    initial, final : float
        First and last length of the crack, in mm.
    toughness : float, optional
        Stress intensity at fracture; it ends both lives, each at its own length.
    closure : {"shut", "none"}, float or NewmanClosure, optional
        Part of a cycle that does no work.

    Returns
    -------
    xarray.Dataset
        ``ratio``, ``reference_life`` and ``life`` in s, ``reference_cycles`` and ``cycles``;
        the law, its source and how each life ended as attributes.

    Examples
    --------
    Twice the load under an exponent of 3 lives an eighth as long:

    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> def plate(load, crack):
    ...     return load / 10.0 * np.sqrt(np.pi * crack * 1e-3)
    >>> small, large = (
    ...     ns.fatigue.LoadBlock.constant_amplitude(0.0, size) for size in (100.0, 200.0)
    ... )
    >>> found = ns.fatigue.life_ratio(
    ...     plate, ns.fatigue.Paris(C=1e-7, m=3.0), small, large, initial=6.4, final=19.0
    ... )
    >>> round(float(found["ratio"]), 9)
    8.0
    """
    import xarray as xr

    options: dict[str, Any] = {"initial": initial, "final": final, "toughness": toughness,
                               "closure": closure}  # fmt: skip
    check_loads(reference, "reference")
    first = life(stress_intensity, law, reference, **options)
    second = life(stress_intensity, law, loads, **options)
    kept = ("law", "source", "closure", "initial", "final")
    attrs = {name: first.attrs[name] for name in kept}
    attrs |= {"reference_ended": first.attrs["ended"], "ended": second.attrs["ended"]}
    return xr.Dataset(
        {
            "ratio": ((), first.attrs["life"] / second.attrs["life"],
                      {"long_name": "reference life by life"}),
            "reference_life": ((), first.attrs["life"],
                               {"long_name": "life under the reference", "units": "s"}),
            "life": ((), second.attrs["life"], {"long_name": "life", "units": "s"}),
            "reference_cycles": ((), first.attrs["life_cycles"],
                                 {"long_name": "cycles under the reference"}),
            "cycles": ((), second.attrs["life_cycles"], {"long_name": "cycles"}),
        },
        attrs=attrs,
    )  # fmt: skip
