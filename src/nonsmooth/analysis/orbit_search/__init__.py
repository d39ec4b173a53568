"""Helpers of the verbs that find and follow periodic orbits."""
