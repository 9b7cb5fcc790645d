"""Robots by name: those of the thesis, and those that public measurements exist of."""

from collections.abc import Mapping

from .measured_arms import AUBO_I5, AUBO_I5_LIMITS, IRB120, IRB120_LIMITS, UR10, UR10_LIMITS
from .robot_file import Arm
from .robots import IRB1400, IRB1400_IMU, IRB1400_LIMITS, LARGE_ROBOT, LARGE_ROBOT_LIMITS

CATALOGUE: Mapping[str, Arm] = {
    "irb1400": Arm(IRB1400, IRB1400_LIMITS),
    "irb1400-imu": Arm(IRB1400_IMU, IRB1400_LIMITS),
    "large": Arm(LARGE_ROBOT, LARGE_ROBOT_LIMITS),
    "ur10": Arm(UR10, UR10_LIMITS),
    "irb120": Arm(IRB120, IRB120_LIMITS),
    "aubo_i5": Arm(AUBO_I5, AUBO_I5_LIMITS),
}
"""Robot and limits by the name of the command line."""
