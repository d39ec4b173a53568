"""
A free decay ends for good
==========================

Pulled aside and let go, the mass swings around one of two centres: right of the middle while it
moves back, left of it while it moves forth. Each half turn loses twice the friction limit, and
the mass stays at the first turning point at which friction can hold it (dot).
"""

import nonsmooth as ns

decay = ns.simulate(ns.models.friction_oscillator(f=0.1, a=0), {"x": 1.05}, t_end=20)
ax = ns.plot.phase_portrait(decay, "x", "v", phases=True, surfaces=True)
ax.plot(decay["x"][-1], decay["v"][-1], "o", color=ns.plot.mode_colours(decay)["stick"])

# %%
# The turning points:
print(decay["state_after"].sel(state="x").values.round(12))
