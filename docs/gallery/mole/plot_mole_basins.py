"""
Where the mole ends up
======================

Three motions of the mole under one forcing, and the starts that lead to each: position of the
mass and its velocity, the spring of the slider relaxed or just in contact. Boundaries are
interwoven, so a small change of the start may decide.
"""

import numpy as np

import nonsmooth as ns

mole = ns.models.moling(a=0.3, b=0.1, xi=0.1, omega=1.45)
plane = {"p": np.linspace(-3, 1, 90), "y": np.linspace(-1, 1, 60)}
basins = ns.basins_of_attraction(
    mole, plane, completion={"q": "max(0, p - g)"}, samples=100, record=2000
)
ax = ns.plot.basins(basins)
