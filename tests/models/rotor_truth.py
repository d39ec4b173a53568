"""The rotor in its snubber ring by routes that share no code with the package.

`RUNS`: ten periods through all regimes to 25 digits, from `reference.rotor`.

`FLIPS`: where a multiplier of set A is -1, by the kernel of ``benchmarks/hand_rotor.py`` (DOP853 in
doubles at tolerance 1e-14): Newton's method for the orbit, its Jacobian by central differences of
order 6 of the strobe map with steps 2e-5, the zero of det(J + I) over eta by Brent's method. Steps
of 5e-5 at tolerance 1e-13 give the same eta to 1e-10. `python benchmarks/hand_rotor.py` finds them
again.
"""

import json
from pathlib import Path
from typing import Any, NamedTuple

RUNS: dict[str, dict[str, Any]] = json.loads(
    (Path(__file__).parents[1] / "reference" / "rotor_runs.json").read_text(encoding="utf-8")
)


class Flip(NamedTuple):
    """A multiplier -1. ``state`` is x, y, vx, vy at phase 0, with the ring in its centre."""

    delta: float
    period: int
    eta: float
    state: tuple[float, float, float, float]
    others: tuple[complex, complex, complex]


FLIPS = [
    Flip(
        0.0, 1, 2.2348432766,
        (0.6605918704924, -0.0198811183703, 0.0619094112399, -0.3264705544827),
        (-0.827327439, -0.599218403, -0.493771144),
    ),
    Flip(
        0.0, 2, 2.3826975247,
        (0.8503796787343, -0.0650560214421, 0.0637315790241, -0.3924379602374),
        (0.354915738 + 0.376332374j, 0.354915738 - 0.376332374j, -0.266517631),
    ),
    Flip(
        0.0, 2, 2.7166602311,
        (0.2274384823109, 0.0356470930277, 0.1359961742536, -0.3749939677144),
        (0.117334095 + 0.548512155j, 0.117334095 - 0.548512155j, -0.313594758),
    ),
    Flip(
        0.0, 2, 4.0849058193,
        (0.7381250964534, -0.0081860142150, 0.0728221611894, -0.5150559340791),
        (-0.736156103, -0.629545043, -0.462935992),
    ),
    Flip(
        0.1, 1, 2.2729618160,
        (0.6454875518923, -0.0190031702096, 0.0637075480766, -0.3295736513045),
        (-0.926074019, -0.544413499, -0.496671038),
    ),
    Flip(
        0.1, 2, 2.3850128951,
        (0.8001469570049, -0.0601108554996, 0.0576671639658, -0.3916743903460),
        (0.324524953 + 0.403387777j, 0.324524953 - 0.403387777j, -0.266299817),
    ),
    Flip(
        0.1, 2, 2.8217563216,
        (0.2166695491034, 0.0325213077229, 0.1332874152998, -0.3862312502808),
        (0.025763705 + 0.572588951j, 0.025763705 - 0.572588951j, -0.327064572),
    ),
    Flip(
        0.1, 4, 2.7559793810,
        (0.1213491685662, 0.0498421500124, 0.1320972585850, -0.3964430757167),
        (-0.309875701 + 0.078562766j, -0.309875701 - 0.078562766j, -0.101563238),
    ),
    Flip(
        0.1, 2, 4.1128345469,
        (0.7080624529540, -0.0078216285078, -0.0187152998221, -0.5179272505661),
        (-0.785773179, -0.592959647, -0.464937011),
    ),
]  # fmt: skip
