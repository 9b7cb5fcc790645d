"""Clocks, mountings and frames of a recording's sensors, aligned with the encoders.

Constants are found by least squares against the motion of the nominal robot. SI units, base axes;
gravity points along -z of a level base.
"""
