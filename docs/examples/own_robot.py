"""Your own robot: a D-H table and an MJCF, held together, then cut with.

The robot here is the large one with a forearm 100 mm shorter. In your own MJCF keep the names of
assets/README.md: joints motor_1..6 and flex_1..6, actuators axis_1..6, sites tool0, imu,
tracker_target, and the numerics that its controller needs.
"""

from dataclasses import replace
from pathlib import Path

import mujoco

from armside import LARGE_CELL, Cell, Cut, kinematics, learn

SHORTER = 0.1  # m

# The D-H table: link 4 holds the length of the forearm.
links = list(kinematics.LARGE_ROBOT.links)
links[3] = replace(links[3], d=links[3].d - SHORTER)
robot = kinematics.Robot(links, offset=kinematics.LARGE_ROBOT.offset, name="SHORT_ROBOT")

# The MJCF: the wrist's body moves back along the forearm.
spec = mujoco.MjSpec.from_file(str(LARGE_CELL.xml))
spec.body("tilt").pos[0] -= SHORTER
spec.compile()
Path("short_robot.xml").write_text(spec.to_xml(), encoding="utf-8")

# They must agree: a cell whose MJCF has tool or IMU elsewhere than its D-H table is refused, with
# the first axis that differs.
cell = Cell(
    xml=Path("short_robot.xml"),
    robot=robot,
    with_imu=replace(robot, links=(*robot.links, *kinematics.IMU_LINKS)),
    limits=kinematics.LARGE_ROBOT_LIMITS,
    poses=LARGE_CELL.poses,
    programs={},
)
rms = [iteration.tool.rms for iteration in learn(Cut(robot=cell, pose="p1"), iterations=2)]
print("tool RMS [um]:", *(f"{1e6 * value:.0f}" for value in rms))
