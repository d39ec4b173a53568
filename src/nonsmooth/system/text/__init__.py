"""Texts of equations: expressions as trees, the grammar that reads them, their values."""
