"""Systems of every kind with an orbit each, and the equations of orbits that were found."""

import numpy as np

import nonsmooth as ns
from nonsmooth.periodic_orbits.equations import OrbitEquations
from nonsmooth.periodic_orbits.legs import Legs
from nonsmooth.periodic_orbits.restart import guess_of_dataset
from nonsmooth.periodic_orbits.search import is_autonomous
from periodic_orbits.systems import rigid_wall


def van_der_pol(speed: float = 1.0) -> ns.System:
    """A smooth cycle in one mode; ``speed`` multiplies the rates."""
    return ns.System(
        name="van_der_pol",
        states=["x", "v"],
        parameters={"mu": 1.0, "speed": speed},
        modes={"all": ns.Mode({"x": "speed*v", "v": "speed*(mu*(1 - x**2)*v - x)"})},
        initial={"x": 2.0},
    )


def relay() -> ns.System:
    """A cycle between two modes, nothing drives it."""
    return ns.System(
        name="relay",
        states=["x", "v"],
        parameters={"zeta": 0.1, "h": 0.2},
        modes={
            "push": ns.Mode(
                {"x": "v", "v": "1 - 2*zeta*v - x"}, exits=[ns.Exit("h - x", to="pull", name="top")]
            ),
            "pull": ns.Mode(
                {"x": "v", "v": "-1 - 2*zeta*v - x"},
                exits=[ns.Exit("h + x", to="push", name="bottom")],
            ),
        },
    )


# name -> system, options of find_orbit, the parameter that is varied
KINDS = {
    "mole": (ns.models.moling(), {}, "b"),
    "soft impact": (ns.models.soft_impact(a=0.5), {"initial": {"x": -0.5}, "transient": 300}, "a"),
    "rigid wall": (rigid_wall(omega=2.0), {"transient": 300}, "omega"),
    "trilinear": (ns.models.trilinear(), {}, "omega"),
    "Duffing": (ns.models.duffing(), {}, "omega"),
    "rotor": (ns.models.rotor(eta=1.5), {}, "eta"),
    "gear": (ns.models.gear_pair(), {}, "Omega"),
    "rig": (ns.models.fatigue_rig(), {}, "eta"),
    "van der Pol": (van_der_pol(), {}, "mu"),
    "relay": (relay(), {"initial": {"x": 0.1, "v": 0.5}, "mode": "push", "transient": 5}, "h"),
}


def found_equations(system: ns.System, orbit, parameter: str = ""):
    """Equations of an orbit that was found, and its unknowns."""
    legs = Legs(system, (parameter,) if parameter else ())
    legs.set_values(system.parameter_values)
    guess = guess_of_dataset(system, orbit)
    equations = OrbitEquations(
        legs,
        guess.word,
        period=int(orbit.attrs["period"]),
        phase=float(orbit.attrs["phase_of_period"]),
        autonomous=is_autonomous(legs),
        origin=guess.turn.states[0],
        reference=guess.turn.states[0].copy(),
    )
    return equations, equations.pack(guess.turn)


def is_among(value: complex, values: np.ndarray, tolerance: float) -> bool:
    """Whether one of some values is near a number."""
    return bool(np.min(np.abs(np.asarray(values) - value)) <= tolerance)
