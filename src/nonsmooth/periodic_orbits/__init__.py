"""Periodic orbits as unknowns of equations; the verbs that use them are in `analysis`."""
