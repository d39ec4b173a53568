"""Units of the fatigue rig and of its reductions to one mass."""

from __future__ import annotations

import math

from nonsmooth.models.rigs.units import Unit, Units

__all__ = ["ONE_MASS", "TWO_MASSES", "one_mass_units", "two_mass_units"]

# what each parameter of a model stands for in a machine
TWO_MASSES = {
    "eta": "frequency of the base",
    "lambda1": "natural frequency on cylinder 1",
    "lambda2": "natural frequency on cylinder 2",
    "theta": "natural frequency on the specimen",
    "eps": "stiffness of a leaf spring over that of a contact",
    "f1": "force on mass 1 downward, weight included",
    "f2": "force on mass 2 upward, weight taken off",
    "xi_Ls": "damping ratio of a leaf spring",
    "xi_s": "damping ratio of the specimen",
    "xi_p1": "damping ratio of cylinder 1",
    "xi_p2": "damping ratio of cylinder 2",
    "open_stiffness": "stiffness of the specimen with its crack open over that closed",
}
ONE_MASS = {
    "xi": "damping ratio",
    "eta": "frequency of the base",
    "d": "static load",
    "crack": "crack length",
    "s": "scale of the specimen's stiffness",
    "kappa": "stiffness of the specimen",
    "kappa_open": "stiffness of the specimen with the crack open",
    "kappa_closed": "stiffness of the specimen with the crack closed",
    "share": "displacement of the specimen over that of the masses",
    "gamma": "deflection at rest",
}
_ACCELERATIONS = ("acceleration1", "acceleration2", "absolute1", "absolute2",
                  "acceleration", "absolute", "base")  # fmt: skip
_SYMBOLS = ("A_b", "omega_Ls", "k_Ls", "omega_M", "k_M")
_TEXT = "mm; mm/s for velocities"


def _quantities(
    length: float, rate: float, force: float, lengths: tuple[str, ...], velocities: tuple[str, ...],
    forces: tuple[str, ...],
) -> dict[str, Unit]:  # fmt: skip
    return {
        **dict.fromkeys(lengths, Unit(length, "mm")),
        **dict.fromkeys(velocities, Unit(length * rate, "mm/s")),
        **dict.fromkeys(forces, Unit(force, "N")),
        **dict.fromkeys(_ACCELERATIONS, Unit(1e-3 * length * rate**2, "m/s^2")),
    }


def two_mass_units(length: float, rate: float, stiffness: float) -> Units:
    """Units of `fatigue_rig`: A_b in mm, omega_Ls in rad/s, k_Ls in N/m."""
    force = 1e-3 * stiffness * length
    hertz = Unit(rate / (2.0 * math.pi), "Hz")
    parameters = {
        **dict.fromkeys(TWO_MASSES, Unit()),
        **dict.fromkeys(("eta", "lambda1", "lambda2", "theta"), hertz),
        **dict.fromkeys(("f1", "f2"), Unit(force, "N")),
    }
    quantities = _quantities(
        length,
        rate,
        force,
        ("X1", "X3", "X4", "deflection"),
        ("X2", "X5"),
        ("load", "contact1", "contact2", "pneumatic1", "pneumatic2"),
    )
    return Units(length, 1.0 / rate, force, parameters, TWO_MASSES, quantities, _TEXT, _SYMBOLS)


def one_mass_units(length: float, rate: float, stiffness: float) -> Units:
    """Units of `breathing_crack` and `one_mass`: A_b in mm, omega_M in rad/s, k_M in N/m."""
    force = 1e-3 * stiffness * length
    parameters = {
        **dict.fromkeys(ONE_MASS, Unit()),
        "eta": Unit(rate / (2.0 * math.pi), "Hz"),
        "d": Unit(force, "N"),
        "crack": Unit(1.0, "mm"),
        "gamma": Unit(length, "mm"),
        **dict.fromkeys(("kappa", "kappa_open", "kappa_closed"), Unit(stiffness, "N/m")),
    }
    quantities = _quantities(
        length, rate, force, ("u", "y", "deflection"), ("v",), ("load", "force")
    )
    return Units(length, 1.0 / rate, force, parameters, ONE_MASS, quantities, _TEXT, _SYMBOLS)
