"""Robots from files: TOML, URDF and MJCF, and the virtual hardware of a robot file as an MJCF.

A robot file that names no MJCF has its hardware in tables of its own, or leaves it to estimates:
each number that is not given follows from those that are, by a rule, and is reported. The model is
the same text each time, in a cache folder.

SI units. Forces, springs, dampers and friction are on the arm side of the gear: [N m], [N m/rad],
[N m s/rad], or [N], [N/m], [N s/m] for a prismatic axis, whose gear ratio is in [rad/m].
"""

from .find import KnownRobot as KnownRobot
from .find import find_cell as find_cell
from .find import load_robot as load_robot
from .find import read_cell as read_cell
