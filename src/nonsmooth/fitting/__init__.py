"""Fits of systems to measured records: parameters with intervals, from motions and derivatives."""
