"""Expressions that share their parts: derivatives, linear forms, and comparison by numbers."""
