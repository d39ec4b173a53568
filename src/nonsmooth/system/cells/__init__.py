"""Cells of a mode: between its switching surfaces, on them where motion slides, at rest."""
