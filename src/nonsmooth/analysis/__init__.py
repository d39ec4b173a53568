"""What is asked of trajectories: one file per public verb."""
