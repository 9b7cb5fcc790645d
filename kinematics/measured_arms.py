"""Robots that public measurements exist of: UR10, IRB120 and AUBO i5."""

from math import pi

from .dh import Link, Robot
from .limits import Limits, degrees

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
