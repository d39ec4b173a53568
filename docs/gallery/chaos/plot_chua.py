"""
Chua's double scroll
====================

A circuit with a piecewise linear resistor: three linear pieces, each solved in closed form and
drawn in its colour. Dashed lines are where they meet.
"""

import numpy as np

import nonsmooth as ns

run = ns.simulate(ns.models.chua(), {"x": 0.1}, times=np.linspace(0, 150, 15_001))
ax = ns.plot.phase_portrait(run, "x", "z", phases=True, surfaces=True, time_range=(30, 150))
for curve in ax.get_lines():
    curve.set_linewidth(0.5)
