"""Motions on the border of two basins."""
