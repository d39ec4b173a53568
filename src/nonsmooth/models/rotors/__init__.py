"""What models of the rotor share: its texts, and what it is measured in."""
