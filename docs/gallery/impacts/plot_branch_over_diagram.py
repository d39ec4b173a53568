"""
A branch over the diagram
=========================

The points are what a soft impact oscillator settles to. The curves are its orbits, stable or
not, followed over the amplitude of the base: the free motion touches its stop (grazing),
doubles its period at once (flip), and the doubled orbit carries on.
"""

import numpy as np

import nonsmooth as ns

soft = ns.models.soft_impact(a=0.4)
single = ns.continue_orbit(soft, "a", (0.4, 0.7))
flip = list(single["special_kind"].values).index("flip")
double = ns.continue_orbit(soft, "a", (0.4, 0.7), initial=single, special=flip)
diagram = ns.bifurcation_diagram(
    soft,
    "a",
    np.linspace(0.4, 0.7, 240),
    initial=single.isel(point=0),
    start="follow up",
    transient=400,
    record=40,
)
ax = ns.plot.branch({"period 1": single, "period 2": double}, "x", diagram=diagram)
ax.set(xlabel="amplitude of the base", ylabel="displacement at the strobe")
