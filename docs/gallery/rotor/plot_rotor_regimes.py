"""
Regimes over speed and preload
==============================

What a rotor settles to from rest, over its speed and the preload of its springs in both
directions. *Unsettled* is what could not be told within the periods that were given, and where
the run ends early the massless ring has no motion that goes on.
"""

import numpy as np

import nonsmooth as ns

rotor = ns.tie_parameters(ns.models.rotor(), {"delta_x": "delta", "delta_y": "delta"}, delta=0.05)
grid = {"eta": np.linspace(1.8, 3.2, 15), "delta": np.linspace(0.0, 0.06, 4)}
found = ns.regime_map(rotor, grid, transient=150, record=60, evidence=200, longest=300)
ax = ns.plot.regime_map(found)
ax.set_ylabel("preload in both directions")
