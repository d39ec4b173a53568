"""
Two masses on a specimen
========================

The rig's masses press a specimen from above and below while the base shakes; where one of them
lifts off, the phase changes. From rest all four phases come: both in contact (i), one of them
(ii, iii), none (iv).
"""

import nonsmooth as ns

run = ns.simulate(ns.models.fatigue_rig(), periods=3, samples_per_period=400)
ax = ns.plot.phases(run, "X3")
