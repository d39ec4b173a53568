"""Flaws of records: what is looked for, and how it is told from a clean motion."""
