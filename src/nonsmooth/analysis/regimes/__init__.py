"""What a motion settles to: windows, rules and evidence."""
