"""MJCF models of the robots, as paths. Data only.

Both robots expose the same joint, actuator, site and sensor names: joints `motor_1..6` (arm-side
angle of the motor) and `flex_1..6` (arm minus motor), actuators `axis_1..6`, sites `tool0`, `imu`
and `tracker_target`, sensors `axis_i_pos`, `axis_i_torque`, `imu_acc`, `imu_gyro`, `tool0_pos`,
`tool0_quat`, keyframe `zero`.
"""

from pathlib import Path

_HERE = Path(__file__).parent

IRB1400_XML = _HERE / "irb1400.xml"
LARGE_ROBOT_XML = _HERE / "large_robot.xml"
