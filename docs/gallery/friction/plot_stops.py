"""
Motion that stops twice a period
================================

A mass on a spring rubs on a table under a harmonic force: it moves forth, is held, moves back,
and is held again. In stick the velocity is zero, not small, and friction is no longer at its
limit: it is what balances the spring and the force.
"""

import nonsmooth as ns

system = ns.models.friction_oscillator(omega=0.5, f=0.75)
run = ns.simulate(system, periods=30, samples_per_period=400)
period = run.attrs["period"]
ax = ns.plot.phases(run, ["v", "friction"], time_range=(28 * period, 30 * period))
ax.set_ylabel("velocity, friction force")

# %%
# The phase word names the pieces, and friction never exceeds its limit:
print(run.attrs["phase_word"], "| largest friction:", float(abs(run["friction"]).max().round(12)))
