"""Section 1 of the chapter: piecewise-smooth systems and their global solutions."""
