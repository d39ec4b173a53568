"""
A ball comes to rest, and is thrown again
=========================================

A ball on a table that moves up and down. Each bounce gives back half of the speed, so
infinitely many of them are over within a period: the ball has come to rest and rides on the
table. It is let go where the table falls away faster than the ball can.
"""

import numpy as np

import nonsmooth as ns

run = ns.simulate(ns.models.bouncing_ball(Gamma=1.2, r=0.5), periods=3, samples_per_period=400)
ax = ns.plot.phases(run, ["y", "table"])
ax.set(xlabel="time", ylabel="height")

# %%
# Rest begins with an event *chatter*, behind all bounces, and ends at the phase arcsin(1/Gamma):
kinds = run["event_kind"].values
released = float(run["event_phase"][kinds == "release"][0])
print(f"chatter at {run['event_time'].values[kinds == 'chatter'].round(6)}")
print(f"release at the phase {released:.12f}, arcsin(1/1.2) is {np.arcsin(1 / 1.2):.12f}")
