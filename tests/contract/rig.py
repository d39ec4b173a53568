"""The fatigue rig: read from its TOML file for the package, and as an automaton for the truth.

The two share nothing: the automaton is Eq. (43) of the chapter with switch functions, written
down a second time, with the balance at rest solved as a linear system.
"""

import tomllib
from pathlib import Path

from mpmath import mp, mpf

import nonsmooth as ns
from reference.linear import LinearExit, LinearMode

FILE = Path(__file__).parents[2] / "examples" / "fatigue_rig.toml"
DIGITS = 60
NAMES = {(1, 1): "both", (0, 1): "mass_2", (1, 0): "mass_1", (0, 0): "none"}


def rig(**parameters) -> ns.System:
    """The system of the file."""
    words = tomllib.loads(FILE.read_text(encoding="utf-8"))
    assert words.pop("format") == 1
    modes = {name: _mode(**mode) for name, mode in words.pop("modes").items()}
    system = ns.System(modes=modes, **words)
    return system.with_parameters(**parameters) if parameters else system


def _mode(flow, exits, **more):
    return ns.Mode(flow, exits=[ns.Exit(**each) for each in exits], **more)


@mp.workdps(DIGITS)
def automaton(p) -> dict[str, LinearMode]:
    """z = (X1, ..., X5, cos, sin, 1); p holds the parameters as doubles."""
    p = {k: mpf(v) for k, v in p.items()}
    eps, th = p["epsilon"], p["theta"]
    # unknowns delta_1, delta_2, Delta_1, Delta_2, gamma
    static = mp.lu_solve(
        mp.matrix(
            [
                [1, 0, 1 / eps, 0, 0],
                [0, 1, 0, 1 / eps, 0],
                [0, 0, 1 / eps, 1 / eps, -(th**2)],
                [1, 0, -1, 0, -1],
                [0, 1, 0, -1, -1],
            ]
        ),
        mp.matrix([p["f1"], -p["f2"], 0, 0, 0]),
    )
    h1 = [1, 0, -1, 0, 0, 0, 0, static[2]]
    h2 = [0, 0, 1, -1, 0, 0, 0, -static[3]]
    return {name: _phase(g3, g4, p, static, h1, h2) for (g3, g4), name in NAMES.items()}


def _phase(g3, g4, p, static, h1, h2) -> LinearMode:
    d1, d2, _, _, gamma = static
    eps, th, xi_s, w = p["epsilon"], p["theta"], p["xi_s"], p["eta"]
    k = 1 / (2 * eps * th * xi_s)
    rows = [[mpf(0)] * 8 for _ in range(8)]
    rows[0][1] = rows[3][4] = mpf(1)
    for row, x, ratio, xi, rest in (
        (1, 0, p["lambda_1"], p["xi_p1"], p["f1"] - d1),
        (4, 3, p["lambda_2"], p["xi_p2"], -p["f2"] - d2),
    ):
        rows[row][x], rows[row][x + 1] = -(1 + ratio**2), -2 * (p["xi_L"] + xi * ratio)
        rows[row][6], rows[row][7] = w**2, rest
    for j in range(8):
        rows[1][j] -= g3 * h1[j] / eps
        rows[4][j] += g4 * h2[j] / eps
        rows[2][j] += k * (g3 * h1[j] - g4 * h2[j])
    rows[2][2] -= th / (2 * xi_s)
    rows[2][7] -= th * gamma / (2 * xi_s)
    rows[5][6], rows[6][5] = -w, w
    exits = [
        LinearExit([x if g3 else -x for x in h1], NAMES[1 - g3, g4]),
        LinearExit([x if g4 else -x for x in h2], NAMES[g3, 1 - g4]),
    ]
    return LinearMode(rows, exits)
