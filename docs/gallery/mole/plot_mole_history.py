"""
The mole digs
=============

A mass under a static and a harmonic force strikes a slider, which dry friction holds. Colours
are the phases of the motion: the mass flies, is in contact with the slider, and pushes it on.
"""

import nonsmooth as ns

run = ns.simulate(ns.models.moling(b=0.15), periods=8)
ax = ns.plot.phases(run, ["x", "z"])
ax.set_ylabel("displacement")

# %%
# Progression per period, once the motion has settled:
settled = ns.simulate(ns.models.moling(b=0.15), periods=200, samples_per_period=1)
print(float(ns.models.progression(settled, periods=50)["per_period"]))
