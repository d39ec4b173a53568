"""Growth of small deviations along a motion."""
