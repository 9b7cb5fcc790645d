"""Estimation of the tool's path from motor angles and an IMU, and laws built on the estimate."""
