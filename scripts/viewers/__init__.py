"""Viewers of runs: Rerun in the browser and on the desktop."""
