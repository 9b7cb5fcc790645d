"""Figures as PNG files, from arrays alone."""
