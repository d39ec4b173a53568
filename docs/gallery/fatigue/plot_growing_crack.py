"""
A motion that changes as the crack grows
========================================

A beam with a breathing crack, which grows by an exponential law. Once per period of the
forcing, its deflection: the motion doubles its period, undoubles, jumps, and is chaotic for a
while, each at a length of its own.
"""

import nonsmooth as ns

growing = ns.models.breathing_crack(growth="5 + 1e-3*exp(t/54734 - 7.8)")
period = growing.period_value
run = ns.simulate(
    growing, t_start=163_000 * period, periods=8000, samples_per_period=1, events=False
)
late = run.isel(time=slice(300, None))
figure_axes = ns.plot.transient_section(late, "crack", "u")
