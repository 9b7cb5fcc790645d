"""Inverse kinematics: closed form, numeric, velocities."""
