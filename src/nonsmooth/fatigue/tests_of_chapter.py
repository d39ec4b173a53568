"""Tables 1-3 of the chapter: the alloy of the specimens, and the lives of eight of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["aluminium_2024_t351", "chapter_tests"]

_PAPER = (
    "C.H. Foong, M. Wiercigroch, E. Pavlovskaia, W.F. Deans, Nonlinear vibration caused by fatigue,"
    " J. Sound Vib. 303 (2007) 58-77"
)
_COMPOSITION = {
    "Al": 93.63, "Si": 0.09, "Fe": 0.21, "Cu": 4.06, "Mn": 0.47, "Mg": 1.37, "Cr": 0.01,
    "Zn": 0.14, "Ti": 0.02,
}  # fmt: skip
# name, mean load and load amplitude in N, R as printed, life in s
_TESTS = (
    ("hl0(78.5)", 0.0, 78.5, -1.0, 39801.0),
    ("hl0(100)", 0.0, 100.0, -1.0, 9191.0),
    ("hl0(273.5)", 0.0, 273.5, -1.0, 1319.0),
    ("hl100(100)", 100.0, 100.0, 0.0, 1628.0),
    ("hl150(50)", 150.0, 50.0, 0.5, 2288.0),
    ("hl150(100)", 150.0, 100.0, 0.2, 547.0),
    ("hl200(50)", 200.0, 50.0, 0.6, 2037.0),
    ("hl200(100)", 200.0, 100.0, 0.33, 331.0),
)
_FREQUENCY, _START = 20.0, 6.4  # Hz, mm


def aluminium_2024_t351() -> xr.Dataset:
    """The alloy of the specimens: Tables 1 and 2 of the chapter, as printed.

    Returns
    -------
    xarray.Dataset
        ``tensile_strength`` and ``yield_strength`` in MPa, ``youngs_modulus`` in GPa, ``density``
        in kg/m^3, and ``composition`` over ``element`` in per cent. The percentages are as printed,
        whatever their sum.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> alloy = ns.fatigue.aluminium_2024_t351()
    >>> float(alloy["youngs_modulus"]), alloy["youngs_modulus"].attrs["units"]
    (72.4, 'GPa')
    >>> float(alloy["composition"].sel(element="Cu"))
    4.06
    """
    import xarray as xr

    properties = {
        "tensile_strength": (454.0, "tensile strength", "MPa"),
        "yield_strength": (317.0, "yield strength", "MPa"),
        "youngs_modulus": (72.4, "Young's modulus", "GPa"),
        "density": (2780.0, "density", "kg/m^3"),
    }
    data = {
        name: ((), value, {"long_name": label, "units": units, "source": f"Table 1, from {_PAPER}"})
        for name, (value, label, units) in properties.items()
    }
    words = {"long_name": "composition", "units": "%", "source": f"Table 2, from {_PAPER}"}
    return xr.Dataset(
        data | {"composition": ("element", list(_COMPOSITION.values()), words)},
        coords={"element": list(_COMPOSITION)},
        attrs={"title": "aluminium alloy 2024-T351"},
    )


def chapter_tests() -> xr.Dataset:
    """Eight fatigue tests of the chapter's rig: Table 3, with what follows from it.

    Specimens of the size of `Specimen`, excited harmonically at 20 Hz. The life is the time from a
    crack of 6.4 mm, grown before the test, to fracture. Each line of the table is one specimen; the
    chapter gives no scatter. The names begin with hl as in the text; the table prints it as h1.

    Returns
    -------
    xarray.Dataset
        Over ``test``: ``mean_load``, ``load_amplitude``, ``life`` and ``printed_ratio`` as printed;
        ``minimum_load``, ``maximum_load``, ``load_ratio`` (the ratio R of these two) and ``cycles``
        computed from them. Attributes ``frequency`` in Hz and ``initial_crack`` in mm.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> tests = ns.fatigue.chapter_tests()
    >>> one = tests.sel(test="hl200(100)")
    >>> float(one["life"]), round(float(one["load_ratio"]), 4), float(one["printed_ratio"])
    (331.0, 0.3333, 0.33)
    """
    import xarray as xr

    names = [row[0] for row in _TESTS]
    mean, amplitude, printed, life = np.array([row[1:] for row in _TESTS]).T
    table = f"Table 3, from {_PAPER}"
    derived = "computed from Table 3"
    columns = {
        "mean_load": (mean, "mean load", "N", table),
        "load_amplitude": (amplitude, "load amplitude", "N", table),
        "printed_ratio": (printed, "load ratio R as printed", "1", table),
        "life": (life, "time to fracture", "s", table),
        "minimum_load": (mean - amplitude, "smallest load", "N", derived),
        "maximum_load": (mean + amplitude, "largest load", "N", derived),
        "load_ratio": ((mean - amplitude) / (mean + amplitude), "load ratio R", "1", derived),
        "cycles": (_FREQUENCY * life, "cycles to fracture", "1", derived),
    }
    return xr.Dataset(
        {
            name: ("test", values, {"long_name": label, "units": units, "source": source})
            for name, (values, label, units, source) in columns.items()
        },
        coords={"test": names},
        attrs={"frequency": _FREQUENCY, "initial_crack": _START, "title": "harmonic fatigue tests"},
    )
