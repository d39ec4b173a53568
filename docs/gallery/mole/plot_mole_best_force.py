"""
How hard to push
================

Progression per period over the static force. Dots: what a mole that starts from rest settles
to. Line: its orbit of period one, dashed where it is unstable. It comes to a fold, and the best
stable point (circle) lies shortly before. With more force the mole digs more slowly.
"""

import numpy as np

import nonsmooth as ns

mole = ns.models.moling()
branch = ns.continue_orbit(mole, "b", (0.06, 0.2))
best = ns.best_point(branch, "v_per_period")
diagram = ns.bifurcation_diagram(mole, "b", np.linspace(0.06, 0.2, 141), transient=200, record=40)
ax = ns.plot.branch(branch, "v_per_period", diagram=diagram)
ax.set(xlabel="static force b", ylabel="progression per period")
ax.plot(best["b"], best["best"], "o", markersize=6, markerfacecolor="none", color="black")

# %%
print("best force", round(best["b"].item(), 6), "progression", round(best["best"].item(), 4))
