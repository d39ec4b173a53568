"""Data and units of machines in SI, whatever the machine."""
