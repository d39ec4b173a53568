r"""The chapter's Jeffcott rotor inside a preloaded snubber ring."""

from __future__ import annotations

from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.system import System

__all__ = ["rotor"]

# signs of the surfaces s - delta and s + delta along an axis
_WITHIN, _BEYOND = ("-+",), ("+.", "--")


def _cells() -> dict[str, str]:
    """Contact regimes by the signs of sx - delta_x, sy - delta_y, sy + delta_y, sx + delta_x."""
    regimes = {
        "II": (_WITHIN, _WITHIN),
        "III": (_BEYOND, _WITHIN),
        "IV": (_WITHIN, _BEYOND),
        "V": (_BEYOND, _BEYOND),
    }
    return {
        x[0] + y + x[1]: regime
        for regime, (along_x, along_y) in regimes.items()
        for x in along_x
        for y in along_y
    }


def rotor(
    eta: Text = 2.442,
    nu1: Text = 0.125,
    nu2: Text = 0.002,
    K: Text = 30.0,
    eta_m: Text = 0.0017,
    rho: Text = 70.0,
    eps_x: Text = 0.9,
    eps_y: Text = 0.0,
    delta_x: Text = 0.1,
    delta_y: Text = 0.1,
    phi0: Text = 0.0,
) -> System:
    r"""Jeffcott rotor in a preloaded snubber ring, dimensionless, chapter section 4.

    Parameters
    ----------
    eta, nu1, nu2, K, eta_m, rho, eps_x, eps_y, delta_x, delta_y, phi0 : float or str
        Dimensionless parameters.

    Returns
    -------
    System
        States ``x y vx vy`` of the rotor, ``sx sy`` of the ring, ``mu``.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ns.models.rotor().name
    'rotor'
    """
    drive = {
        "x": "vx",
        "y": "vy",
        "vx": "eta_m*rho*eta**2*cos(eta*t + phi0) - 2*nu1*vx - (x - eps_x) - Fx",
        "vy": "eta_m*rho*eta**2*sin(eta*t + phi0) - 2*nu1*vy - (y - eps_y) - Fy",
    }
    return System(
        name="rotor",
        states=["x", "y", "vx", "vy", "sx", "sy", "mu"],
        period="2*pi/eta",
        parameters={
            "eta": eta,
            "nu1": nu1,
            "nu2": nu2,
            "K": K,
            "eta_m": eta_m,
            "rho": rho,
            "eps_x": eps_x,
            "eps_y": eps_y,
            "delta_x": delta_x,
            "delta_y": delta_y,
            "phi0": phi0,
        },
        require={
            "eta > 0": "the rotor must turn",
            "nu1 >= 0": "negative damping would feed energy in",
            "nu2 > 0": "the ring needs damping to return by",
            "K > 0": "the ring is held by springs",
            "delta_x >= 0": "a spring with negative preload would be slack",
            "delta_y >= 0": "a spring with negative preload would be slack",
        },
        definitions={
            "nx": "x - sx",
            "ny": "y - sy",
            "springs_x": "where(sx > delta_x, 1, where(sx < -delta_x, 1, 2))",
            "springs_y": "where(sy > delta_y, 1, where(sy < -delta_y, 1, 2))",
            "preload_x": "where(sx > delta_x, delta_x, where(sx < -delta_x, -delta_x, 0))",
            "preload_y": "where(sy > delta_y, delta_y, where(sy < -delta_y, -delta_y, 0))",
            "pull_x": "springs_x*sx + preload_x",
            "pull_y": "springs_y*sy + preload_y",
            "decay": "K/(2*nu2)",
            "Fx": "K*pull_x + 2*nu2*springs_x*rate(sx)",
            "Fy": "K*pull_y + 2*nu2*springs_y*rate(sy)",
            "size": "sqrt(Fx**2 + Fy**2)",
            "stored": "0.5*K*(springs_x*sx**2 + 2*preload_x*sx - preload_x**2*(2 - springs_x)"
            " + springs_y*sy**2 + 2*preload_y*sy - preload_y**2*(2 - springs_y))",
        },
        outputs={
            "ring_vx": "rate(sx)",
            "ring_vy": "rate(sy)",
            "force_x": "Fx",
            "force_y": "Fy",
            "force": "size",
            "contact_angle": "atan2(ny, nx)",
            "gap": "1 - sqrt(nx**2 + ny**2)",
            "energy": "stored",
        },
        modes={
            "free": Mode(
                drive | {"sx": "-decay*(sx + preload_x)", "sy": "-decay*(sy + preload_y)"},
                slaved={"mu": "0"},
                definitions={"Fx": "0", "Fy": "0", "size": "0"},
                exits=[
                    Exit(
                        "1 - nx**2 - ny**2",
                        to="contact",
                        reset={"sx": "sx", "sy": "sy", "mu": "nx*pull_x + ny*pull_y"},
                        name="contact",
                    )
                ],
                cells=dict.fromkeys(_cells(), "I"),
            ),
            "contact": Mode(
                drive,
                slaved={
                    "sx": "pull_x = mu*nx",
                    "sy": "pull_y = mu*ny",
                    "mu": "nx**2 + ny**2 = 1",
                },
                exits=[Exit("nx*Fx + ny*Fy", to="free", reset={"mu": "0"}, name="release")],
                cells=_cells(),
            ),
        },
    )
