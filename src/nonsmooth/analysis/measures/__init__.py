"""What the measures of basins and of sets of points share."""
