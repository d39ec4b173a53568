"""
Multipliers along a branch
==========================

How a perturbation is multiplied in one turn of an orbit, while a parameter changes. Without
contact the multipliers of the soft impact oscillator run around on a circle that the damping
alone gives; with the first contact they leave it at once, one of them through -1.
"""

import nonsmooth as ns

branch = ns.continue_orbit(
    ns.models.soft_impact(omega=0.7), "omega", (0.55, 0.95), step=0.002, largest_step=0.01
)
ax = ns.plot.multipliers(branch)
