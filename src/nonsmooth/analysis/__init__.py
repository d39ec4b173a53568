"""What trajectories tell: maps, diagrams, measures of chaos. One file per verb."""
