"""Helpers of `return_map`: starts, images with derivatives, breaks, fixed points, reduction."""
