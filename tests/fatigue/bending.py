"""What the tests of lives take from handbooks: a bent beam, and Table 3 of the chapter."""

import numpy as np
import xarray as xr

WIDTH, THICKNESS, SPAN = 20.0, 10.0, 270.0  # mm


def bent_beam(load, crack, lib=np):
    """Tada, Paris and Irwin: an edge crack under pure bending, MPa sqrt(m)."""
    angle = lib.pi * crack / (2 * WIDTH)
    stress = 3 * load * SPAN / (2 * THICKNESS * WIDTH**2)
    shape = (0.923 + 0.199 * (1 - lib.sin(angle)) ** 4) / lib.cos(angle)
    return stress * lib.sqrt(lib.pi * crack / 1000 * lib.tan(angle) / angle) * shape


def plate(load, crack):
    """Wide plate with one MPa per 10 N and a constant geometry factor of 1.12."""
    return 0.112 * load * np.sqrt(np.pi * crack * 1e-3)


def table_3():
    names = ("hl0(78.5)", "hl0(100)", "hl0(273.5)", "hl100(100)", "hl150(50)", "hl150(100)",
             "hl200(50)", "hl200(100)")  # fmt: skip
    return xr.Dataset(
        {
            "mean_load": ("test", [0.0, 0.0, 0.0, 100.0, 150.0, 150.0, 200.0, 200.0]),
            "load_amplitude": ("test", [78.5, 100.0, 273.5, 100.0, 50.0, 100.0, 50.0, 100.0]),
            "life": ("test", [39801.0, 9191.0, 1319.0, 1628.0, 2288.0, 547.0, 2037.0, 331.0]),
        },
        {"test": list(names)},
    )
