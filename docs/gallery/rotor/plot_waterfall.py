"""
A cascade of spectra
====================

Spectra of x + iy over the speed, backward whirl on the left and forward whirl on the right.
Lines at half of the speed are motions of period two; where they are many, the motion is
chaotic.
"""

import numpy as np

import nonsmooth as ns

speeds = np.linspace(2.0, 4.0, 61)
spectra = ns.waterfall(
    ns.models.rotor(), "eta", speeds, ("x", "y"), start="follow up", transient=100
)
ax = ns.plot.waterfall(spectra, kind="map", over="harmonic")
