"""The data of a system, what follows from them, checks of both, and other ways to write it."""
