"""The fatigue rig written down a second and a third time: printed phases, and a cracked automaton.

Eqs. (38)-(41) as printed, with what the print lost put back: dots, "st" marks, and the balance at
rest, solved here as a linear system in fractions.
"""

from fractions import Fraction

from mpmath import mp, mpf

import nonsmooth as ns
from contract.rig import DIGITS
from reference.linear import LinearExit, LinearMode

FIGURE_25 = {"eta": 2.5, "lambda1": 4.36, "lambda2": 4.36, "f1": 5.44, "f2": 3.52}
STATES = ["X1", "X2", "X3", "X4", "X5"]
OTHER_NAMES = {"xi_Ls": "xi_L", "lambda1": "lambda_1", "lambda2": "lambda_2", "eps": "epsilon"}
PHASES = {"both": "i", "mass_2": "ii", "mass_1": "iii", "none": "iv"}


def other_names(parameters):
    """Parameters by the names of `contract.rig`."""
    return {OTHER_NAMES.get(name, name): value for name, value in parameters.items()}


def statics(p, number=Fraction):
    """delta1, delta2, Delta1, Delta2, gamma in fractions or any other exact numbers."""
    q = {name: number(value) for name, value in p.items()}
    stiffness = q["theta"] ** 2
    if q["f1"] > q["f2"]:
        stiffness *= q.get("open_stiffness", number(1))
    one, zero = number(1), number(0)
    rows = [
        [one, zero, 1 / q["eps"], zero, zero, q["f1"]],
        [zero, one, zero, 1 / q["eps"], zero, -q["f2"]],
        [zero, zero, 1 / q["eps"], 1 / q["eps"], -stiffness, zero],
        [one, zero, -one, zero, -one, zero],
        [zero, one, zero, -one, -one, zero],
    ]
    return eliminated(rows)


def eliminated(rows):
    """Gauss and Jordan, exact for exact numbers."""
    n = len(rows)
    for k in range(n):
        pivot = next(i for i in range(k, n) if rows[i][k] != 0)
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(n):
            if i != k:
                rows[i] = [a - rows[i][k] * b for a, b in zip(rows[i], rows[k], strict=True)]
    return [row[-1] for row in rows]


def printed_rates(phase, p, rest, x, t, sin):
    """Right-hand sides of Eqs. (38)-(41) in the phase named."""
    d1, d2, D1, D2, gamma = rest
    eps, theta, xi_s = p["eps"], p["theta"], p["xi_s"]
    X1, X2, X3, X4, X5 = x
    push = p["eta"] ** 2 * sin(p["eta"] * t)
    c1 = 2 * p["xi_Ls"] + 2 * p["xi_p1"] * p["lambda1"]
    c2 = 2 * p["xi_Ls"] + 2 * p["xi_p2"] * p["lambda2"]
    k1, k2 = 1 + p["lambda1"] ** 2, 1 + p["lambda2"] ** 2
    soft = 1 / (2 * eps * theta * xi_s)
    bend = theta / (2 * xi_s)
    if phase in ("i", "iii"):
        first = -(k1 + 1 / eps) * X1 - c1 * X2 + X3 / eps + push
    else:
        first = -k1 * X1 - c1 * X2 - d1 + p["f1"] + push
    if phase in ("i", "ii"):
        last = X3 / eps - (k2 + 1 / eps) * X4 - c2 * X5 + push
    else:
        last = -k2 * X4 - c2 * X5 - d2 - p["f2"] + push
    middle = {
        "i": soft * X1 - (2 * soft + bend) * X3 + soft * X4,
        "ii": -(soft + bend) * X3 + soft * X4 + D2 * soft - bend * gamma,
        "iii": soft * X1 - (soft + bend) * X3 + D1 * soft - bend * gamma,
        "iv": -bend * X3 - bend * gamma,
    }[phase]
    return [X2, first, middle, X5, last]


def compact_rates(p, rest, x, t, sin):
    """Right-hand sides of Eq. (43) with the switch functions (42)."""
    d1, d2, D1, D2, gamma = rest
    eps, theta, xi_s = p["eps"], p["theta"], p["xi_s"]
    X1, X2, X3, X4, X5 = x
    G3, G4 = int(X1 - (X3 - D1) > 0), int(-X4 + (X3 - D2) > 0)
    push = p["eta"] ** 2 * sin(p["eta"] * t)
    c1 = 2 * p["xi_Ls"] + 2 * p["xi_p1"] * p["lambda1"]
    c2 = 2 * p["xi_Ls"] + 2 * p["xi_p2"] * p["lambda2"]
    first = -(1 + p["lambda1"] ** 2) * X1 - c1 * X2 - G3 / eps * (X1 - X3 + D1) - d1 + p["f1"]
    last = -(1 + p["lambda2"] ** 2) * X4 - c2 * X5 - G4 / eps * (-X3 + X4 + D2) - d2 - p["f2"]
    middle = (G3 * (X1 - X3 + D1) + G4 * (-X3 + X4 + D2)) / (2 * eps * theta * xi_s)
    return [X2, first + push, middle - theta / (2 * xi_s) * (X3 + gamma), X5, last + push]


def printed_system(p):
    """The printed phases as modes with exits, for runs."""
    d1, d2, D1, D2, gamma = map(float, statics(p))
    text = {
        "push": "eta**2*sin(eta*t)",
        "c1": "2*xi_Ls + 2*xi_p1*lambda1",
        "c2": "2*xi_Ls + 2*xi_p2*lambda2",
        "soft": "1/(2*eps*theta*xi_s)",
        "bend": "theta/(2*xi_s)",
    }
    on1 = "-(1 + lambda1**2 + 1/eps)*X1 - c1*X2 + X3/eps + push"
    off1 = "-(1 + lambda1**2)*X1 - c1*X2 - d1 + f1 + push"
    on2 = "X3/eps - (1 + lambda2**2 + 1/eps)*X4 - c2*X5 + push"
    off2 = "-(1 + lambda2**2)*X4 - c2*X5 - d2 - f2 + push"
    middle = {
        "i": "soft*X1 - (1/(eps*theta*xi_s) + bend)*X3 + soft*X4",
        "ii": "-(soft + bend)*X3 + soft*X4 + D2*soft - bend*gamma",
        "iii": "soft*X1 - (soft + bend)*X3 + D1*soft - bend*gamma",
        "iv": "-bend*X3 - bend*gamma",
    }
    h1, h2 = "X1 - X3 + D1", "X3 - X4 - D2"
    away = {"i": ("ii", "iii"), "ii": ("i", "iv"), "iii": ("iv", "i"), "iv": ("iii", "ii")}
    modes = {
        phase: ns.Mode(
            {
                "X1": "X2",
                "X2": on1 if phase in ("i", "iii") else off1,
                "X3": middle[phase],
                "X4": "X5",
                "X5": on2 if phase in ("i", "ii") else off2,
            },
            exits=[
                ns.Exit(h1 if phase in ("i", "iii") else f"-({h1})", to=away[phase][0]),
                ns.Exit(h2 if phase in ("i", "ii") else f"-({h2})", to=away[phase][1]),
            ],
        )
        for phase in middle
    }
    rest = {"d1": d1, "d2": d2, "D1": D1, "D2": D2, "gamma": gamma}
    return ns.System(
        name="printed",
        states=STATES,
        period="2*pi/eta",
        parameters={**p, **rest},
        definitions=text,
        modes=modes,
    )


@mp.workdps(DIGITS)
def cracked_automaton(p):
    """Eight linear modes of the rig with a crack, z = (X1, ..., X5, cos, sin, 1), in `DIGITS`."""
    rest = statics(p, mpf)
    q = {name: mpf(value) for name, value in p.items()}
    _, _, D1, D2, gamma = rest
    h1 = [1, 0, -1, 0, 0, 0, 0, D1]
    h2 = [0, 0, 1, -1, 0, 0, 0, -D2]
    h3 = [0, 0, 1, 0, 0, 0, 0, gamma]
    modes = {}
    for phase, (g1, g2) in {"i": (1, 1), "ii": (0, 1), "iii": (1, 0), "iv": (0, 0)}.items():
        for side, ratio in (("+", q["open_stiffness"]), ("-", mpf(1))):
            modes[phase + side] = _mode(phase, side, ratio, q, rest, (h1, h2, h3), (g1, g2))
    return modes


def _mode(phase, side, ratio, q, rest, guards, closed):
    d1, d2 = rest[:2]
    h1, h2, h3 = guards
    g1, g2 = closed
    rows = [[mpf(0)] * 8 for _ in range(8)]
    rows[0][1] = rows[3][4] = mpf(1)
    rows[5][6], rows[6][5] = -q["eta"], q["eta"]
    rows[1][0], rows[4][3] = -(1 + q["lambda1"] ** 2), -(1 + q["lambda2"] ** 2)
    rows[1][1] = -2 * (q["xi_Ls"] + q["xi_p1"] * q["lambda1"])
    rows[4][4] = -2 * (q["xi_Ls"] + q["xi_p2"] * q["lambda2"])
    rows[1][6] = rows[4][6] = q["eta"] ** 2
    rows[1][7], rows[4][7] = q["f1"] - d1, -q["f2"] - d2
    slow = 2 * q["theta"] * q["xi_s"]
    for j in range(8):
        rows[1][j] -= g1 * h1[j] / q["eps"]
        rows[4][j] += g2 * h2[j] / q["eps"]
        rows[2][j] += (g1 * h1[j] - g2 * h2[j]) / (q["eps"] * slow)
        rows[2][j] -= ratio * q["theta"] ** 2 * h3[j] / slow
    one = {"i": "ii", "ii": "i", "iii": "iv", "iv": "iii"}
    two = {"i": "iii", "iii": "i", "ii": "iv", "iv": "ii"}
    exits = [
        LinearExit([x if g1 else -x for x in h1], one[phase] + side),
        LinearExit([x if g2 else -x for x in h2], two[phase] + side),
        LinearExit([x if side == "+" else -x for x in h3], phase + ("-" if side == "+" else "+")),
    ]
    return LinearMode(rows, exits)
