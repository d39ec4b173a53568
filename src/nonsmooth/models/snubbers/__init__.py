"""Statics of the snubber ring, behind its public functions."""
