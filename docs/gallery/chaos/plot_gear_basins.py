"""
Gears that rattle, or not
=========================

A pair of gears with backlash has two settled motions at this speed: the teeth stay in mesh, or
they separate in every period. Which one it comes to depends on the start.
"""

import numpy as np

import nonsmooth as ns

region = {"x": np.linspace(-3, 4, 160), "v": np.linspace(-2, 2, 120)}
basins = ns.basins_of_attraction(ns.models.gear_pair(Omega=0.5), region, samples=200)
ax = ns.plot.basins(basins)
