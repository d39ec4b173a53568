"""Matrices of a rotor from arrays and files."""
