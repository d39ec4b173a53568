"""
A Lyapunov spectrum settles
===========================

Both exponents of the chaotic soft impact oscillator, averaged up to each time, with bands of
two standard errors. Derivatives are carried through every impact, so their sum is that of the
damping, -2 zeta.
"""

import nonsmooth as ns

system = ns.models.soft_impact(omega=0.905)
spectrum = ns.lyapunov_spectrum(system, transient=500, record=2000)
ax = ns.plot.exponents(spectrum)
ax.set_ylim(-0.12, 0.12)

# %%
found = spectrum["lyapunov_exponent"].values
print(found.round(4), "sum", round(float(found.sum()), 9))
print("-2 zeta =", -2 * system.parameter_values["zeta"])
