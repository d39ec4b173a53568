"""
Cycles of a chaotic load
========================

A specimen is shaken by a chaotic record, and its load is taken apart into closed cycles by
rainflow counting: how many there are of each range and mean.
"""

import nonsmooth as ns

specimen = ns.fatigue.Specimen()
rig = ns.excitation.ShakenSpecimen(
    specimen.stiffness, specimen.closed_stiffness, damping=0.1, mean_load=150.0
)
wave = ns.excitation.duffing(20.0, duration=60.0)
cycles = ns.fatigue.count_cycles(rig.load(wave.scaled(2.0), crack=8.0))
ax = ns.plot.load_cycles(cycles, kind="matrix")
