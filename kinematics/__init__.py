"""Denavit-Hartenberg robots: symbolic, generated and inverse kinematics.

Units are SI and radians. phi are motor angles on the arm side of the gearbox; joint variables are
coupling @ phi + offset. Six-vectors are (v, omega) in base axes, quaternions have w first, and
T_a_b takes coordinates in frame b to frame a: p_a = T_a_b @ p_b. SymPy and numba are imported
only when a function needs them.
"""

from .compiled import CompiledRobot as CompiledRobot
from .compiled import compile as compile
from .compiled import compile_dynamics as compile_dynamics
from .compiled import compile_frame_jacobian as compile_frame_jacobian
from .compiled import compile_frame_pose as compile_frame_pose
from .compiled import compile_measurement as compile_measurement
from .dh import Convention as Convention
from .dh import CoupledRange as CoupledRange
from .dh import Joint as Joint
from .dh import Limits as Limits
from .dh import Link as Link
from .dh import Robot as Robot
from .equations.inertial_model import Body as Body
from .equations.inertial_model import InertialModel as InertialModel
from .equations.inertial_model import Motor as Motor
from .inverse.closed_form import Branches as Branches
from .inverse.closed_form import Singularity as Singularity
from .inverse.closed_form import UnreachableError as UnreachableError
from .inverse.closed_form import inverse_branches as inverse_branches
from .inverse.closed_form import inverse_nearest as inverse_nearest
from .inverse.closed_form import inverse_path as inverse_path
from .inverse.numeric import NotConvergedError as NotConvergedError
from .inverse.numeric import inverse_numeric as inverse_numeric
from .inverse.numeric import inverse_numeric_path as inverse_numeric_path
from .inverse.scara import scara_branches as scara_branches
from .inverse.seven_axes import elbow_angle as elbow_angle
from .inverse.seven_axes import seven_axis_branches as seven_axis_branches
from .inverse.six_axes import UnsolvableGeometryError as UnsolvableGeometryError
from .inverse.stanford import stanford_branches as stanford_branches
from .inverse.targets import Cause as Cause
from .regressor import compile_inverse_dynamics_jacobian as compile_inverse_dynamics_jacobian
from .robot_file import Arm as Arm
from .robot_file import GearTerm as GearTerm
from .robot_file import read_gear_error as read_gear_error
from .robot_file import read_robot as read_robot
from .robot_file import robot_toml as robot_toml
from .robots import AUBO_I5 as AUBO_I5
from .robots import AUBO_I5_LIMITS as AUBO_I5_LIMITS
from .robots import CATALOGUE as CATALOGUE
from .robots import IMU_LINKS as IMU_LINKS
from .robots import IRB120 as IRB120
from .robots import IRB120_LIMITS as IRB120_LIMITS
from .robots import IRB1400 as IRB1400
from .robots import IRB1400_IMU as IRB1400_IMU
from .robots import IRB1400_LIMITS as IRB1400_LIMITS
from .robots import LARGE_ROBOT as LARGE_ROBOT
from .robots import LARGE_ROBOT_LIMITS as LARGE_ROBOT_LIMITS
from .robots import UR10 as UR10
from .robots import UR10_LIMITS as UR10_LIMITS
from .urdf import UrdfArm as UrdfArm
from .urdf import read_urdf as read_urdf
