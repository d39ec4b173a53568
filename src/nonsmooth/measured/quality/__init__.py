"""Flaws of records: what is looked for, how it is told from a clean motion, and what becomes of it."""
