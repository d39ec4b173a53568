"""
An unstable orbit, phase by phase
=================================

Equations for the durations of its phases give an orbit of any stability; no run stays on this
one. Each leg is drawn in the colour of its mode: free, and in contact with the second spring.
"""

import nonsmooth as ns

soft = ns.models.soft_impact(a=0.55)
orbit = ns.find_orbit(soft, word="free contact free")
ax = ns.plot.periodic_orbit(ns.orbit_samples(orbit), "x", "v")
ax.axvline(soft.parameter_values["e"], color="0.5", linestyle=":", linewidth=0.8)

# %%
# A perturbation is multiplied by these numbers in each turn. One is beyond -1: it flips sides and
# grows.
print(orbit["multipliers"].values.real.round(6), "stable:", bool(orbit["stable"]))
