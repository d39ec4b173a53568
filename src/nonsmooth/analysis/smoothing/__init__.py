"""What smoothing does to a system, over widths: parts of `smoothing_report`."""
