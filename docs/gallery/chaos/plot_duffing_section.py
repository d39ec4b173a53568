"""
A strange attractor
===================

Duffing's oscillator with two wells, once per period of its forcing: ten thousand points of one
motion on a set that is folded at all scales. Its equations are not linear, so the motion is
carried by Taylor series.
"""

import nonsmooth as ns

points = ns.stroboscopic_map(ns.models.duffing(), transient=100, record=10_000)
ax = ns.plot.section(points, "x", "v")
