"""
The orbit of a rotor
====================

The path of the shaft in the plane, the path of the ring, and the clearance within which they do
not touch. A dot stands where the shaft is once per revolution: two dots are a motion that
repeats after two.
"""

import nonsmooth as ns

run = ns.simulate(ns.models.rotor(eta=3.0), periods=260, samples_per_period=200)
period = run.attrs["period"]
last = (240 * period, 260 * period)
ax = ns.plot.orbit(run, ring=("sx", "sy"), clearance=1.0, time_range=last)
