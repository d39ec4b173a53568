"""From equations to what the engine runs: forms of modes, code for series, arrays."""
