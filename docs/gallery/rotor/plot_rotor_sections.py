"""
A rotor once per revolution
===========================

Strobes of a rotor in its ring at a speed where its motion does not repeat. The colour tells the
contact regime in which the rotor was met.
"""

import nonsmooth as ns

points = ns.stroboscopic_map(ns.models.rotor(eta=2.442), transient=300, record=6000)
ax = ns.plot.section(points, "x", "vx", phases=True)
