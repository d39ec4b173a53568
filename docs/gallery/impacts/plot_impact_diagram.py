"""
Impact speeds over the frequency
================================

A mass on a spring, driven against a rigid wall. Each column of points holds the speeds of the
impacts once the motion has settled: one for a motion with one impact per turn, a smear for
chaos, gaps and jumps where an impact appears by grazing.
"""

import numpy as np

import nonsmooth as ns

diagram = ns.bifurcation_diagram(
    ns.models.impact_oscillator(),
    "omega",
    np.linspace(2.5, 3.4, 600),
    at="impact",
    side="before",
    transient=200,
    record=60,
)
ax = ns.plot.bifurcation(diagram, "v")
ax.set(xlabel="angular frequency of the force", ylabel="speed before an impact")
