"""Normal forms of the special points of branches of orbits."""
