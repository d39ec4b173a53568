r"""The chapter's fatigue-testing rig: two masses on a bending specimen."""

from __future__ import annotations

from nonsmooth.system.parts import Mode, Text
from nonsmooth.system.system import System

__all__ = ["fatigue_rig"]

_LABELS = {
    "time": "time [1/omega_Ls]",
    "X1": "displacement of mass 1 [A_b]",
    "X2": "velocity of mass 1 [A_b omega_Ls]",
    "X3": "displacement of the specimen [A_b]",
    "X4": "displacement of mass 2 [A_b]",
    "X5": "velocity of mass 2 [A_b omega_Ls]",
    "deflection": "deflection of the specimen [A_b]",
    "load": "load on the specimen [k_Ls A_b]",
    "contact1": "contact force of mass 1 [k_Ls A_b]",
    "contact2": "contact force of mass 2 [k_Ls A_b]",
    "pneumatic1": "dynamic force of cylinder 1 [k_Ls A_b]",
    "pneumatic2": "dynamic force of cylinder 2 [k_Ls A_b]",
    "acceleration1": "relative acceleration of mass 1 [A_b omega_Ls^2]",
    "acceleration2": "relative acceleration of mass 2 [A_b omega_Ls^2]",
    "absolute1": "acceleration of mass 1 [A_b omega_Ls^2]",
    "absolute2": "acceleration of mass 2 [A_b omega_Ls^2]",
    "base": "acceleration of the base [A_b omega_Ls^2]",
    "eta": "frequency of the base over omega_Ls",
    "lambda1": "natural frequency on cylinder 1 over omega_Ls",
    "lambda2": "natural frequency on cylinder 2 over omega_Ls",
    "theta": "natural frequency on the specimen over omega_Ls",
    "eps": "stiffness of a leaf spring over that of a contact",
    "f1": "force on mass 1 downward, weight included [k_Ls A_b]",
    "f2": "force on mass 2 upward, weight taken off [k_Ls A_b]",
    "xi_Ls": "damping ratio of a leaf spring",
    "xi_s": "damping ratio of the specimen",
    "xi_p1": "damping ratio of cylinder 1",
    "xi_p2": "damping ratio of cylinder 2",
}


def fatigue_rig(
    eta: Text = 3.0,
    lambda1: Text = 2.0,
    lambda2: Text = 2.0,
    theta: Text = 7.828,
    eps: Text = 0.002012,
    f1: Text = 3.75,
    f2: Text = 3.75,
    xi_Ls: Text = 0.00255,
    xi_s: Text = 0.002,
    xi_p1: Text = 0.4,
    xi_p2: Text = 0.4,
) -> System:
    r"""Two-mass fatigue-testing rig, dimensionless."""
    parameters = {
        "eta": eta,
        "lambda1": lambda1,
        "lambda2": lambda2,
        "theta": theta,
        "eps": eps,
        "f1": f1,
        "f2": f2,
        "xi_Ls": xi_Ls,
        "xi_s": xi_s,
        "xi_p1": xi_p1,
        "xi_p2": xi_p2,
    }
    return System(
        name="fatigue_rig",
        states=["X1", "X2", "X3", "X4", "X5"],
        period="2*pi/eta",
        parameters=parameters,
        require={
            "eta > 0": "the base must shake",
            "theta > 0": "the specimen needs a stiffness",
            "eps > 0": "the contacts need a stiffness",
            "xi_s > 0": "the specimen has no mass, so without damping it has no rate",
            "xi_Ls >= 0": "negative damping would feed energy in",
            "xi_p1 >= 0": "negative damping would feed energy in",
            "xi_p2 >= 0": "negative damping would feed energy in",
            "f1 > (f1 - f2)/(2 + theta**2*(1 + eps))": "at rest mass 1 must press on the specimen; raise f1",
            "f2 > (f2 - f1)/(2 + theta**2*(1 + eps))": "at rest mass 2 must press on the specimen; raise f2",
        },
        describe=_LABELS,
        definitions={
            "gamma": "(f1 - f2)/(2 + theta**2*(1 + eps))",
            "Delta1": "eps*(f1 - gamma)/(1 + eps)",
            "Delta2": "-eps*(f2 + gamma)/(1 + eps)",
            "delta1": "gamma + Delta1",
            "delta2": "gamma + Delta2",
            "shaking": "eta**2*sin(eta*t)",
            "R1": "max(X1 - X3 + Delta1, 0)/eps",
            "R2": "max(X3 - X4 - Delta2, 0)/eps",
            "P1": "lambda1**2*X1 + 2*xi_p1*lambda1*X2",
            "P2": "lambda2**2*X4 + 2*xi_p2*lambda2*X5",
        },
        outputs={
            "deflection": "X3 + gamma",
            "load": "R1 - R2",
            "contact1": "R1",
            "contact2": "R2",
            "pneumatic1": "P1",
            "pneumatic2": "P2",
            "acceleration1": "rate(X2)",
            "acceleration2": "rate(X5)",
            "absolute1": "rate(X2) - shaking",
            "absolute2": "rate(X5) - shaking",
            "base": "-shaking",
        },
        modes={
            "rig": Mode(
                {
                    "X1": "X2",
                    "X2": "-X1 - 2*xi_Ls*X2 - P1 - R1 - delta1 + f1 + shaking",
                    "X3": "(R1 - R2)/(2*theta*xi_s) - theta*(X3 + gamma)/(2*xi_s)",
                    "X4": "X5",
                    "X5": "-X4 - 2*xi_Ls*X5 - P2 + R2 - delta2 - f2 + shaking",
                },
                cells={"++": "i", "-+": "ii", "+-": "iii", "--": "iv"},
            )
        },
    )
