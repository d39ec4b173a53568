"""Truth computed apart from the package: see README.md in this folder."""
