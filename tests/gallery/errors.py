"""Errors of the run over its iterations."""

LINE = "laser"
DRAWN = "errors.png"
