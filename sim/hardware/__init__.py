"""Virtual hardware of a robot file: masses, drives, gears and structure, written as an MJCF.

A robot file that names no MJCF has its hardware in tables of its own, or leaves it to estimates:
each number that is not given follows from those that are, by a rule, and is reported. The model is
the same text each time, in a cache folder.

SI units. Forces, springs, dampers and friction are on the arm side of the gear: [N m], [N m/rad],
[N m s/rad], or [N], [N/m], [N s/m] for a prismatic axis, whose gear ratio is in [rad/m].
"""

from .build import Built as Built
from .build import build as build
from .description import Hardware as Hardware
from .estimate import Taken as Taken
from .reading import TABLES as TABLES
from .reading import read_hardware as read_hardware
