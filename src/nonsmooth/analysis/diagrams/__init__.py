"""Columns of bifurcation diagrams."""
