"""Whether a declared symmetry holds, and what it does to states, modes and exits."""
