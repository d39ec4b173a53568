"""Texts of the chapter's rotor in its snubber ring, on which other models build."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nonsmooth.system.parts import Exit, Mode, Text

__all__ = ["first_guess", "rotor_words"]

# signs of the surfaces s - delta and s + delta along an axis
_WITHIN, _BEYOND = ("-+",), ("+.", "--")
_LABELS = {
    "x": "displacement of the rotor in x",
    "y": "displacement of the rotor in y",
    "vx": "velocity of the rotor in x",
    "vy": "velocity of the rotor in y",
    "sx": "displacement of the ring in x",
    "sy": "displacement of the ring in y",
    "mu": "multiplier of the contact",
    "ring_vx": "velocity of the ring in x",
    "ring_vy": "velocity of the ring in y",
    "force_x": "force on the ring in x",
    "force_y": "force on the ring in y",
    "force": "force on the ring",
    "contact_angle": "direction of the contact [rad]",
    "gap": "gap between rotor and ring",
    "energy": "elastic energy of the ring",
    "eta": "speed over the natural frequency",
    "nu1": "damping ratio of the rotor",
    "nu2": "damping of the ring",
    "K": "stiffness of the ring over that of the rotor",
    "eta_m": "unbalance mass over the mass of the rotor",
    "rho": "radius of the unbalance",
    "eps_x": "eccentricity in x",
    "eps_y": "eccentricity in y",
    "delta_x": "preload in x",
    "delta_y": "preload in y",
    "phi0": "phase of the unbalance [rad]",
}


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


def rotor_words(values: Mapping[str, Text], *, relaxes: bool = True) -> dict[str, Any]:
    """What `System` takes for the rotor, by values of its parameters; for models built on it."""
    drive = {
        "x": "vx",
        "y": "vy",
        "vx": "eta_m*rho*eta**2*cos(eta*t + phi0) - 2*nu1*vx - (x - eps_x) - Fx",
        "vy": "eta_m*rho*eta**2*sin(eta*t + phi0) - 2*nu1*vy - (y - eps_y) - Fy",
    }
    require = {
        "eta > 0": "the rotor must turn",
        "nu1 >= 0": "negative damping would feed energy in",
        "nu2 > 0": "an undamped ring is back at once; for that, see ring='returns'",
        "K > 0": "the ring is held by springs",
        "delta_x >= 0": "springs with a negative preload leave the ring loose",
        "delta_y >= 0": "springs with a negative preload leave the ring loose",
    }
    if not relaxes:
        del require["nu2 > 0"]
    return {
        "name": "rotor",
        "states": ["x", "y", "vx", "vy", "sx", "sy", "mu"],
        "period": "2*pi/eta",
        "parameters": {name: value for name, value in values.items() if name != "nu2" or relaxes},
        "require": require,
        "describe": {name: _LABELS[name] for name in _LABELS if name != "nu2" or relaxes},
        "definitions": {
            "reach": "sqrt(x**2 + y**2)",
            "nx": "x - sx",
            "ny": "y - sy",
            "springs_x": "where(sx > delta_x, 1, where(sx < -delta_x, 1, 2))",
            "springs_y": "where(sy > delta_y, 1, where(sy < -delta_y, 1, 2))",
            "preload_x": "where(sx > delta_x, delta_x, where(sx < -delta_x, -delta_x, 0))",
            "preload_y": "where(sy > delta_y, delta_y, where(sy < -delta_y, -delta_y, 0))",
            "pull_x": "springs_x*sx + preload_x",
            "pull_y": "springs_y*sy + preload_y",
            "Fx": "K*pull_x" + (" + 2*nu2*springs_x*rate(sx)" if relaxes else ""),
            "Fy": "K*pull_y" + (" + 2*nu2*springs_y*rate(sy)" if relaxes else ""),
            "size": "sqrt(Fx**2 + Fy**2)",
            "stored": "0.5*K*(springs_x*sx**2 + 2*preload_x*sx - preload_x**2*(2 - springs_x)"
            " + springs_y*sy**2 + 2*preload_y*sy - preload_y**2*(2 - springs_y))",
        },
        "outputs": {
            "ring_vx": "rate(sx)",
            "ring_vy": "rate(sy)",
            "force_x": "Fx",
            "force_y": "Fy",
            "force": "size",
            "contact_angle": "atan2(ny, nx)",
            "gap": "1 - sqrt(nx**2 + ny**2)",
            "energy": "stored",
        },
        "modes": {"free": _free(drive, relaxes), "contact": _contact(drive)},
    }


def first_guess(gap: str, mu: str) -> dict[str, str]:
    """First guess of the ring's place on contact: where it stands within its preload.

    From a displaced ring Newton's method could find a place where the energy is largest.
    """
    return {"sx": f"x*(1 - {gap}/reach)", "sy": f"y*(1 - {gap}/reach)", "mu": mu}


def _free(drive: dict[str, str], relaxes: bool) -> Mode:
    """The rotor away from the ring, which relaxes or is back already."""
    contact = Exit(
        "1 - nx**2 - ny**2",
        to="contact",
        reset=first_guess("1", "2*(reach - 1)"),
        name="contact",
    )
    no_force = {"Fx": "0", "Fy": "0", "size": "0"}
    if not relaxes:
        away = {"sx": "0", "sy": "0", "mu": "0"}
        return Mode(drive, slaved=away, definitions=no_force | {"stored": "0"}, exits=[contact])
    return Mode(
        drive
        | {
            "sx": "-K/(2*nu2)*(sx + preload_x)",
            "sy": "-K/(2*nu2)*(sy + preload_y)",
        },
        slaved={"mu": "0"},
        definitions=no_force,
        exits=[contact],
        cells=dict.fromkeys(_cells(), "free"),
    )


def _contact(drive: dict[str, str]) -> Mode:
    """The ring at its least energy on the rotor."""
    return Mode(
        drive,
        slaved={"sx": "pull_x = mu*nx", "sy": "pull_y = mu*ny", "mu": "nx**2 + ny**2 = 1"},
        exits=[Exit("nx*Fx + ny*Fy", to="free", reset={"mu": "0"}, name="release")],
        cells=_cells(),
    )
