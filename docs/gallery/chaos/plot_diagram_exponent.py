"""
A diagram above its exponents
=============================

The soft impact oscillator over the frequency: points of the settled motion, and below them the
largest Lyapunov exponent of each. It is positive where the points smear out.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns

soft = ns.models.soft_impact()
frequencies = np.linspace(0.78, 0.96, 91)
diagram = ns.bifurcation_diagram(soft, "omega", frequencies, transient=400, record=80)
# of the motions above, be they long transients: confirm=0 does not run on to see what they become
exponents = [
    float(
        ns.lyapunov_spectrum(
            soft, parameters={"omega": omega}, transient=400, record=150, exponents=1, confirm=0
        )["lyapunov_exponent"][0]
    )
    for omega in frequencies
]

figure, (above, below) = plt.subplots(
    2, 1, figsize=(5.2, 4.2), dpi=150, sharex=True, layout="constrained"
)
ns.plot.bifurcation(diagram, "x", ax=above)
below.plot(frequencies, exponents, color=ns.plot.PALETTE["blue"], linewidth=0.9)
below.axhline(0, color="0.5", linewidth=0.6)
above.set(xlabel="", ylabel="displacement")
below.set(xlabel="frequency over the natural one", ylabel="largest exponent")
