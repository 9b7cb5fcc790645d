"""Kerf of a square, before learning and after five updates."""

LINE = "laser --shape square --size 20"
DRAWN = "kerf.png"
