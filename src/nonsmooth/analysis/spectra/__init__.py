"""Spectra of records, of one side and of both."""
