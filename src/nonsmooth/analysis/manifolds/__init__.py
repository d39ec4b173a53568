"""Helpers of `manifold`: the saddle, the map beside it, growth of curves, borders, the dataset."""
