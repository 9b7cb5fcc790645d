"""Calibration of the large robot: its free parameters, and the targets they are chosen by."""
