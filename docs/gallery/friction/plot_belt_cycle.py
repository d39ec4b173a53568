"""
Stick-slip on a belt
====================

A mass on a spring stands on a moving belt, which takes it along until the spring is stronger
than static friction; then it slips back. Kinetic friction falls with the speed of slip here,
which makes the oscillation grow by itself: a bowed string, a squealing brake.
"""

import nonsmooth as ns

bow = ns.models.belt_oscillator(law="falling", F_s=1, v_b=0.2)
run = ns.simulate(bow, {"x": 1.05}, t_end=60)
ax = ns.plot.phase_portrait(run, "x", "v", phases=True, surfaces=True)
