"""Settled motions over a parameter, recorded in full."""
