"""What the two-mass fatigue rig consists of, behind its public functions."""
