"""
Den Hartog's resonance curves
=============================

A mass on a spring rubs on a table and is driven by a harmonic force. Den Hartog (1931) solved
the motion that does not stop within a half turn in closed form: the lines. The dots are settled
motions of the system, which know nothing of that formula. Below the dashed line friction can
hold the mass at its turning points; it stops there for a while, and the dots go on where the
lines end. Friction f is that over the amplitude of the force.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns


def den_hartog(omega, f):
    """Amplitude of the motion without stops; nan where friction can hold the mass."""
    half = np.pi / omega
    without = 1 / (1 - omega**2)
    loss = np.sin(half) / (omega * (1 + np.cos(half)))
    square = without**2 - (f * loss) ** 2
    amplitude = np.sqrt(np.maximum(square, 0))
    return np.where(amplitude * omega**2 > f, amplitude, np.nan)


def settled_amplitude(omega, f):
    """Largest displacement in the last of 150 periods."""
    system = ns.models.friction_oscillator(omega=omega, f=f, zeta=1e-3)
    return float(abs(ns.simulate(system, periods=150)["x"][-101:]).max())


fine = np.concatenate([np.linspace(0.3, 0.99, 500), np.linspace(1.01, 2.0, 500)])
coarse = np.concatenate([np.linspace(0.1, 0.9, 33), np.linspace(1.1, 2.0, 19)])
figure, ax = plt.subplots(figsize=(4.6, 3.5), dpi=150, layout="constrained")
for f, colour in zip((0.2, 0.5, 0.7), ns.plot.PALETTE.values()):
    ax.plot(fine, den_hartog(fine, f), color=colour, label=f"f = {f}")
    found = [settled_amplitude(omega, f) for omega in coarse]
    ax.plot(coarse, found, "o", color=colour, markersize=3)
    ax.plot(fine, f / fine**2, "--", color=colour, linewidth=0.8)
ax.set(xlabel="frequency of the force over the natural one", ylabel="amplitude over the static one")
ax.set(xlim=(0.1, 2.0), ylim=(0, 4))
ax.legend()
