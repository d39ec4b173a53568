"""
Regions of a snubber ring
=========================

A rotor inside a ring on four preloaded springs. Where its centre stands tells which springs are
at work: I none, II the ring within both preloads, III and IV beyond one of them, V beyond both.
On top, the path of the rotor at one speed.
"""

import nonsmooth as ns

curves = ns.models.snubber_boundaries(delta_x=0.1, delta_y=0.1)
ax = ns.plot.contact_regions(curves)

run = ns.simulate(ns.models.rotor(delta_x=0.1, delta_y=0.1, eta=2.4), periods=140)
settled = run.isel(time=slice(120 * 100, None))
ax.plot(settled["x"], settled["y"], color="black", linewidth=0.5)
