"""What the rotors are measured in."""
