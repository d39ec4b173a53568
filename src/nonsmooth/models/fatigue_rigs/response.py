r"""The fatigue rig while both masses press all the time: statics and steady motion, closed form."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from nonsmooth.errors import ModelError, OptionError, quote
from nonsmooth.models.fatigue_rig import fatigue_rig
from nonsmooth.system.system import System

__all__ = ["FullContact", "full_contact", "is_cracked", "rig_values"]


@dataclass(frozen=True)
class FullContact:
    r"""Rest and steady motion in Phase (i), Z of :math:`\mathrm{Im}(Z e^{i\eta\tau})`."""

    static1: float
    static2: float
    gamma: float
    X1: complex
    X3: complex
    X4: complex
    contact1: complex
    contact2: complex

    @property
    def load(self) -> complex:
        """Amplitude of the load on the specimen."""
        return self.contact1 - self.contact2


def rig_values(system: System) -> dict[str, float]:
    """Parameters of a fatigue rig by name, that of a specimen without a crack included."""
    if not isinstance(system, System) or system.name != "fatigue_rig":
        raise OptionError(
            f"{quote(getattr(system, 'name', system))} is not the two-mass fatigue rig; give"
            " nonsmooth.models.fatigue_rig(...), or system() of a FatigueRig"
        )
    values = {name: float(value) for name, value in system.parameter_values.items()}
    needed = set(fatigue_rig().parameters)
    if missing := sorted(needed - set(values)):
        raise OptionError(
            f"the system has no parameter {', '.join(missing)}; give one without ties"
        )
    return values


def is_cracked(p: Mapping[str, float]) -> bool:
    """Whether the specimen has a crack that changes its stiffness."""
    return p.get("open_stiffness", 1.0) != 1.0


def full_contact(p: Mapping[str, float]) -> FullContact:
    """Rest and steady motion while both masses press, each force independent of the other's sign.

    A crack must stay open or shut all the time; where it breathes the motion has no closed form.
    """
    ratio = p.get("open_stiffness", 1.0)
    at_rest = p["theta"] ** 2 * (ratio if p["f1"] > p["f2"] else 1.0)
    gamma = (p["f1"] - p["f2"]) / (2.0 + at_rest * (1.0 + p["eps"]))
    found = _motion(p, gamma, at_rest)
    if is_cracked(p) and abs(found.X3) > abs(gamma):
        raise ModelError(
            f"the crack breathes: the deflection at rest is {gamma:.4g} and its amplitude"
            f" {abs(found.X3):.4g}, so the motion is not linear and has no closed form; raise the"
            " difference of f1 and f2, leave out open_stiffness, or simulate the rig"
        )
    return found


def _motion(p: Mapping[str, float], gamma: float, stiffness: float) -> FullContact:
    eta, eps = p["eta"], p["eps"]
    sides = [
        complex(
            1.0 + p[f"lambda{i}"] ** 2 - eta**2,
            2.0 * eta * (p["xi_Ls"] + p[f"xi_p{i}"] * p[f"lambda{i}"]),
        )
        for i in (1, 2)
    ]
    # each mass on its contact spring, as the specimen feels it: no difference of near numbers
    first, second = (side / (1.0 + eps * side) for side in sides)
    pushes = [eta**2 / (1.0 + eps * side) for side in sides]
    specimen = complex(stiffness, 2.0 * eta * p["theta"] * p["xi_s"])
    deflection = sum(pushes) / (specimen + first + second)
    contact1 = pushes[0] - first * deflection
    contact2 = second * deflection - pushes[1]
    return FullContact(
        static1=(p["f1"] - gamma) / (1.0 + eps),
        static2=(p["f2"] + gamma) / (1.0 + eps),
        gamma=gamma,
        X1=deflection + eps * contact1,
        X3=deflection,
        X4=deflection - eps * contact2,
        contact1=contact1,
        contact2=contact2,
    )
