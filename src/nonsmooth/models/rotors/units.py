"""Units of the rotor's states, outputs and parameters."""

from __future__ import annotations

from nonsmooth.models.rigs.units import Unit, Units

__all__ = ["PARAMETERS", "rotor_units"]

_LENGTHS = ("x", "y", "sx", "sy", "gap")
_VELOCITIES = ("vx", "vy", "ring_vx", "ring_vy")
_FORCES = ("force_x", "force_y", "force", "normal_force")

# what each parameter of the model stands for in a machine
PARAMETERS = {
    "eta": "speed of the rotor",
    "nu1": "damping of the rotor",
    "nu2": "damping of the ring",
    "K": "stiffness of the ring",
    "eta_m": "unbalance mass",
    "rho": "radius of the unbalance mass",
    "eps_x": "eccentricity in x",
    "eps_y": "eccentricity in y",
    "delta_x": "preload in x",
    "delta_y": "preload in y",
    "phi0": "phase of the unbalance",
}


def rotor_units(length: float, time: float, force: float, parameters: dict[str, Unit]) -> Units:
    """Units of a rotor by its length in mm, time in s, force in N."""
    quantities = {
        **dict.fromkeys(_LENGTHS, Unit(length, "mm")),
        **dict.fromkeys(_VELOCITIES, Unit(length / time, "mm/s")),
        **dict.fromkeys(_FORCES, Unit(force, "N")),
        "energy": Unit(force * length, "mJ"),
        "contact_angle": Unit(1.0, "rad"),
        "mu": Unit(),
    }
    text = "mm; mm/s for velocities; 1 for mu"
    return Units(length, time, force, parameters, PARAMETERS, quantities, text)
