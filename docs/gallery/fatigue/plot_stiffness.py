"""
A cracked specimen gets softer
==============================

Stiffness of the chapter's beam over the length of an open crack, by the two laws that the
chapter has. They are not alike: the cubic law bends the whole beam as if it were as thin as its
ligament.
"""

import numpy as np

import nonsmooth as ns

laws = ns.fatigue.compare_stiffness_laws(np.linspace(0.0, 19.0, 191))
ax = ns.plot.stiffness_laws(laws)
