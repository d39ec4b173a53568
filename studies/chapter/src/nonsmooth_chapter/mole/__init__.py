"""Section 2 of the chapter: the ground mole, its figures and claims."""
