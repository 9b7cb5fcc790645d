"""Robots by name, each with the source of its numbers.

The IRB1400 and the large robot are those of the thesis: in the zero pose of both the upper arm is
vertical, the forearm horizontal and forward, and the tool's z-axis forward. Public measurements
exist of the UR10, the IRB120 and the AUBO i5.
"""

from collections.abc import Mapping
from math import pi

import numpy as np

from .dh import CoupledRange, Joint, Limits, Link, Robot, degrees
from .robot_file import Arm

# Universal Robots, "DH parameters for calculations of kinematics and dynamics", UR10 (CB3).
UR10 = Robot(
    (
        Link(d=0.1273, alpha=pi / 2),
        Link(a=-0.612),
        Link(a=-0.5723),
        Link(d=0.163941, alpha=pi / 2),
        Link(d=0.1157, alpha=-pi / 2),
        Link(d=0.0922),
    ),
    name="UR10",
)
# Data sheet of the UR10: +-360 deg on each joint; 120 deg/s base and shoulder, 180 deg/s others.
UR10_LIMITS = Limits(
    lower=degrees(*[-360] * 6),
    upper=degrees(*[360] * 6),
    speed=degrees(120, 120, 180, 180, 180, 180),
)

# ABB IRB120-3/0.6: lengths of the product specification 3HAC035960. No parallelogram.
IRB120 = Robot(
    (
        Link(d=0.290, alpha=-pi / 2),
        Link(a=0.270),
        Link(a=0.070, alpha=-pi / 2),
        Link(d=0.302, alpha=pi / 2),
        Link(alpha=-pi / 2),
        Link(d=0.072),
    ),
    offset=[0, -pi / 2, 0, 0, 0, pi],
    name="IRB120",
)
# Working ranges and axis speeds: product specification 3HAC035960.
IRB120_LIMITS = Limits(
    lower=degrees(-165, -110, -110, -160, -120, -400),
    upper=degrees(165, 110, 70, 160, 120, 400),
    speed=degrees(250, 250, 250, 320, 320, 420),
)

# AUBO i5: fergujm2/ContinuousRobotCalibration, the table of the measurements of this arm.
AUBO_I5 = Robot(
    (
        Link(d=0.0985, alpha=pi / 2),
        Link(d=0.1405, a=0.408, alpha=pi),
        Link(d=0.1215, a=0.376, alpha=pi),
        Link(d=0.1025, alpha=pi / 2),
        Link(d=0.1025, alpha=-pi / 2),
        Link(d=0.094),
    ),
    offset=[0, pi / 2, 0, pi / 2, 0, pi],
    name="AUBO i5",
)
# Data sheet of the AUBO i5: +-175 deg; 150 deg/s joints 1-3, 180 deg/s joints 4-6.
AUBO_I5_LIMITS = Limits(
    lower=degrees(*[-175] * 6),
    upper=degrees(*[175] * 6),
    speed=degrees(150, 150, 150, 180, 180, 180),
)


# Motor 3 sits at the foot and drives link 3 through a parallelogram: theta_3 = phi_3 - phi_2.
# Thesis (4.10).
_PARALLELOGRAM = np.eye(6)
_PARALLELOGRAM[2, 1] = -1
_ZERO_POSE = [0, -pi / 2, 0, 0, 0, pi]  # thesis (4.9)

# Thesis Table 4.2, from the blueprint of the ABB IRB1400 (5 kg, 1.44 m).
_IRB1400_LINKS = (
    Link(d=0.475, a=0.15, alpha=-pi / 2),
    Link(a=0.6),
    Link(a=0.12, alpha=-pi / 2),
    Link(d=0.72, alpha=pi / 2),
    Link(alpha=-pi / 2),
    Link(d=0.085),
)
IRB1400 = Robot(_IRB1400_LINKS, coupling=_PARALLELOGRAM, offset=_ZERO_POSE, name="IRB1400")

# Thesis Table 5.1: two constant links take the tool frame to the inertial measurement unit,
# (32, -26, 90) mm from TCP0 along the base axes of the zero pose.
IMU_LINKS = (
    Link(theta=pi, d=0.032, a=0.09, alpha=pi / 2, joint=Joint.FIXED),
    Link(theta=pi / 2, d=-0.026, alpha=pi / 2, joint=Joint.FIXED),
)
IRB1400_IMU = Robot(
    (*_IRB1400_LINKS, *IMU_LINKS), _PARALLELOGRAM, offset=_ZERO_POSE, name="IRB1400 with IMU"
)

# Joint limits and speeds of the IRB1410, the same arm: 4rtur1t0/ARTE robots/ABB/IRB1410.
# Its J3 is the absolute angle of link 3, which is motor angle phi_3.
IRB1400_LIMITS = Limits(
    lower=degrees(-170, -70, -65, -150, -115, -300),
    upper=degrees(170, 70, 70, 150, 115, 300),
    speed=degrees(120, 120, 120, 280, 280, 280),
    # The parallelogram collapses at +-90 deg; ESTIMATE: 20 deg of transmission angle are kept.
    coupled=(
        CoupledRange(coefficients=(0, -1, 1, 0, 0, 0), lower=degrees(-70)[0], upper=degrees(70)[0]),
    ),
)

# ABB IRB6600-175/2.55 with the tool centre point at the bare flange. Lengths:
# ros-industrial/abb irb6600_225_255_macro.xacro, the same in ARTE's IRB6640. No parallelogram.
LARGE_ROBOT = Robot(
    (
        Link(d=0.780, a=0.320, alpha=-pi / 2),
        Link(a=1.075),
        Link(a=0.200, alpha=-pi / 2),
        Link(d=1.142, alpha=pi / 2),
        Link(alpha=-pi / 2),
        Link(d=0.200),
    ),
    offset=_ZERO_POSE,
    name="LARGE_ROBOT",
)
# Limits and speeds: ros-industrial/abb irb6600_225_255_macro.xacro.
LARGE_ROBOT_LIMITS = Limits(
    lower=degrees(-180, -65, -180, -300, -120, -300),
    upper=degrees(180, 80, 60, 300, 120, 300),
    speed=degrees(100, 90, 90, 150, 120, 190),
)


CATALOGUE: Mapping[str, Arm] = {
    "irb1400": Arm(IRB1400, IRB1400_LIMITS),
    "irb1400-imu": Arm(IRB1400_IMU, IRB1400_LIMITS),
    "large": Arm(LARGE_ROBOT, LARGE_ROBOT_LIMITS),
    "ur10": Arm(UR10, UR10_LIMITS),
    "irb120": Arm(IRB120, IRB120_LIMITS),
    "aubo_i5": Arm(AUBO_I5, AUBO_I5_LIMITS),
}
"""Robot and limits by the name of the command line."""
