"""Runs: start, loop, records, datasets."""
