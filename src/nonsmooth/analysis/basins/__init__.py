"""Attractors and their basins: how they are found, labelled and told as datasets."""
