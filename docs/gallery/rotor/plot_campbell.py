"""
Campbell diagram of a shaft
===========================

A shaft with two discs in oil films, whose stiffness differs in x and y. Discs make forward whirl
faster and backward whirl slower as the speed grows. Circles are critical speeds, at which the speed
or twice the speed is a natural frequency.
"""

import numpy as np

import nonsmooth as ns

parts = ns.structures
rotor = parts.shaft(
    [parts.Beam(0.125, 0.06)] * 12,
    discs=[
        parts.Disc.from_geometry(3, 0.07, 0.35, 0.06),
        parts.Disc.from_geometry(7, 0.09, 0.45, 0.06),
    ],
    bearings=[
        parts.Bearing([f"{node}x", f"{node}y"], [[4e7, 0], [0, 2e7]], 5e3) for node in (0, 10)
    ],
)
diagram = ns.structures.campbell(rotor, np.linspace(0.0, 1000.0, 41), count=6, harmonics=(1, 2))
ax = ns.plot.campbell(diagram, units="rpm")
