"""Tool paths of the run."""

LINE = "laser"
DRAWN = "circles.png"
