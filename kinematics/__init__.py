"""Denavit-Hartenberg robots: symbolic, generated and inverse kinematics."""
