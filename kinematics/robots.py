"""The IRB1400 and the large robot, with the source of each number.

Zero pose of both: upper arm vertical, forearm horizontal and forward, tool z-axis forward.
"""

from math import pi

import numpy as np

from .dh import Joint, Link, Robot
from .limits import CoupledRange, Limits, degrees

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
