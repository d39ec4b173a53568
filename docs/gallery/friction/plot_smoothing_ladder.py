"""
What smoothing costs
====================

Friction is often written with ``tanh(v/eps)`` in place of ``sign(v)``. Against the exact
motion, over a ladder of widths: the creep of a body that should rest goes to zero with the
width, the time in stick only with its root.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns

oscillator = ns.System(
    name="dry friction",
    states=["x", "v"],
    parameters={"mu": 0.6, "omega": 0.5},
    period="2*pi/omega",
    equations={"x": "v", "v": "cos(omega*t) - x - mu*sign(v)"},
)
report = ns.smoothing_report(
    oscillator,
    np.geomspace(1e-4, 1e-2, 7),
    initial={"x": 1},
    periods=12,
    transient=10,
    samples=20_000,
)
figure, axes = plt.subplots(1, 2, figsize=(7.0, 3.2), dpi=120, layout="constrained")
for ax, name in zip(axes, ("creep", "stick_time_error")):
    ns.plot.smoothing(report, name, ax=ax)
