"""Cutting motions: contours, paths, their timing, the joint reference that follows them."""
