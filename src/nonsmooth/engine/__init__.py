"""Numba kernels: flow, first crossing, transition. See README.md for the array contract."""
