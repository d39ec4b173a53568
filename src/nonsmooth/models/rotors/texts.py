"""Texts of the chapter's snubber ring and of its rotor, on which other models build."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from nonsmooth.system.parts import Exit, Mode, Text

__all__ = [
    "RingNames",
    "first_guess",
    "often_rides",
    "ring_modes",
    "ring_texts",
    "rotor_words",
    "with_flow",
]

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


class RingNames(NamedTuple):
    """What the texts call the data of a ring, and the velocity of the rotor there.

    A ring without damping is back at its centre as soon as it is free.
    """

    stiffness: str
    damping: str | None
    gap: str
    vx: str
    vy: str


# direction of the force on the ring: the normal, if there is no friction
_NORMAL = ("nx", "ny")


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


def ring_texts(ring: RingNames, along: tuple[str, str] = _NORMAL, *, rides: bool) -> dict[str, str]:
    """Definitions of springs, force and energy of a ring; `along` is the direction of its force."""
    k, c = ring.stiffness, ring.damping
    texts = {
        "reach": "sqrt(x**2 + y**2)",
        "nx": "x - sx",
        "ny": "y - sy",
        "springs_x": "where(sx > delta_x, 1, where(sx < -delta_x, 1, 2))",
        "springs_y": "where(sy > delta_y, 1, where(sy < -delta_y, 1, 2))",
        "preload_x": "where(sx > delta_x, delta_x, where(sx < -delta_x, -delta_x, 0))",
        "preload_y": "where(sy > delta_y, delta_y, where(sy < -delta_y, -delta_y, 0))",
        "pull_x": "springs_x*sx + preload_x",
        "pull_y": "springs_y*sy + preload_y",
        "Fx": f"{k}*pull_x",
        "Fy": f"{k}*pull_y",
        "size": "sqrt(Fx**2 + Fy**2)",
        "stored": f"0.5*{k}*(springs_x*sx**2 + 2*preload_x*sx - preload_x**2*(2 - springs_x)"
        " + springs_y*sy**2 + 2*preload_y*sy - preload_y**2*(2 - springs_y))",
    }
    if c is None:
        return texts
    texts["Fx"] += f" + {c}*springs_x*rate(sx)"
    texts["Fy"] += f" + {c}*springs_y*rate(sy)"
    if rides:
        px, py = (f"({text})" for text in along)
        # normal force over the gap of a rotor on a ring that its dampers hold back
        texts["push"] = (
            f"({c}*(nx*{ring.vx} + ny*{ring.vy}) + {k}*(nx*pull_x/springs_x + ny*pull_y/springs_y))"
            f"/(nx*{px}/springs_x + ny*{py}/springs_y)"
        )
    return texts


def first_guess(gap: str, mu: str) -> dict[str, str]:
    """First guess of the ring's place on contact: where it stands within its preload.

    From a displaced ring Newton's method could find a place where the energy is largest.
    """
    return {"sx": f"x*(1 - {gap}/reach)", "sy": f"y*(1 - {gap}/reach)", "mu": mu}


def ring_modes(
    ring: RingNames, along: tuple[str, str] = _NORMAL, *, rides: bool
) -> dict[str, Mode]:
    """Modes of a ring by its own rates and relations; `rides` asks for the third one, see there."""
    damped = ring.damping is not None
    square = "1" if ring.gap == "1" else f"{ring.gap}**2"
    touch = Exit(
        f"{square} - nx**2 - ny**2",
        to="contact",
        reset=first_guess(ring.gap, f"2*(reach/{ring.gap} - 1)"),
        name="contact",
    )
    no_force = {"Fx": "0", "Fy": "0", "size": "0"}
    rate = f"-{ring.stiffness}/({ring.damping})"
    free = Mode(
        {"sx": f"{rate}*(sx + preload_x)", "sy": f"{rate}*(sy + preload_y)"},
        slaved={"mu": "0"},
        definitions=no_force,
        exits=[touch],
        cells=dict.fromkeys(_cells(), "free"),
    )
    if not damped:
        away = {"sx": "0", "sy": "0", "mu": "0"}
        free = Mode({}, slaved=away, definitions=no_force | {"stored": "0"}, exits=[touch])
    after = "riding" if damped and rides else "free"
    px, py = (text if text in _NORMAL else f"({text})" for text in along)
    contact = Mode(
        {},
        slaved={
            "sx": f"pull_x = mu*{px}",
            "sy": f"pull_y = mu*{py}",
            "mu": f"nx**2 + ny**2 = {square}",
        },
        exits=[Exit("nx*Fx + ny*Fy", to=after, reset={"mu": "0"}, name="release")],
        cells=_cells(),
    )
    modes = {"free": free, "contact": contact}
    if after == "riding":
        modes["riding"] = _riding(ring, (px, py), square)
    return modes


def _riding(ring: RingNames, along: tuple[str, str], square: str) -> Mode:
    """The ring on the rotor, along which its dampers hold it back.

    Contact at the least energy leaves the dampers out of account where the ring moves along the
    rotor. Where such a contact ends, the free ring may therefore move into the rotor. Then the ring
    stays on it and follows its springs and dampers, until the rotor no longer pushes. The second
    exit keeps out starts away from the ring: a motion in contact never takes it.
    """
    k, c = ring.stiffness, ring.damping
    px, py = along
    return Mode(
        {
            "sx": f"(push*{px} - {k}*pull_x)/({c}*springs_x)",
            "sy": f"(push*{py} - {k}*pull_y)/({c}*springs_y)",
        },
        slaved={"mu": "0"},  # that of the least energy, of which there is none
        definitions={"Fx": f"push*{px}", "Fy": f"push*{py}"},
        exits=[
            Exit("push", to="free", name="release"),
            Exit(f"1e-9 - ((nx**2 + ny**2)/{square} - 1)**2", to="stop", name="apart"),
        ],
        cells=dict.fromkeys(_cells(), "riding"),
    )


def with_flow(modes: Mapping[str, Mode], flow: Mapping[str, Text]) -> dict[str, Mode]:
    """Modes of a ring with the rates of a rotor in front."""
    return {name: replace(mode, flow=dict(flow) | dict(mode.flow)) for name, mode in modes.items()}


def often_rides(preload_x: Text, preload_y: Text) -> bool:
    """Whether releases with these preloads often leave open what comes next: they are unequal."""
    try:
        return float(preload_x) != float(preload_y)
    except ValueError:  # texts of other parameters
        return False


def rotor_words(
    values: Mapping[str, Text],
    along: tuple[str, str] = _NORMAL,
    *,
    relaxes: bool = True,
    riding: bool = False,
) -> dict[str, Any]:
    """What `System` takes for the rotor, by values of its parameters; for models built on it."""
    ring = RingNames("K", "2*nu2" if relaxes else None, "1", "vx", "vy")
    drive: dict[str, Text] = {
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
        "definitions": ring_texts(ring, along, rides=riding),
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
        "modes": with_flow(ring_modes(ring, along, rides=riding), drive),
    }
