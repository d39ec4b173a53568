"""Averages, periods and fits of series of numbers."""
