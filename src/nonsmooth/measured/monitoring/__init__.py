"""Watching a machine: indicators over windows of a record, limits for them, how well they tell."""
