"""Denavit-Hartenberg robots: symbolic, generated and inverse kinematics.

Units are SI and radians. phi are motor angles on the arm side of the gearbox; joint variables are
coupling @ phi + offset. Six-vectors are (v, omega) in base axes, quaternions have w first, and
T_a_b takes coordinates in frame b to frame a: p_a = T_a_b @ p_b. SymPy and numba are imported
only when a function needs them.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
