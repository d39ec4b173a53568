"""Analyses of systems: one file per verb."""
