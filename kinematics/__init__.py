"""Denavit-Hartenberg robots: symbolic, generated and inverse kinematics.

Units are SI and radians. phi are motor angles on the arm side of the gearbox; joint variables are
coupling @ phi + offset. Six-vectors are (v, omega) in base axes, quaternions have w first, and
T_a_b takes coordinates in frame b to frame a: p_a = T_a_b @ p_b. SymPy and numba are imported by
what needs them, not by this package.
"""

from .compiled import CompiledRobot as CompiledRobot
from .compiled import compile as compile
from .compiled import compile_dynamics as compile_dynamics
from .compiled import compile_measurement as compile_measurement
from .dh import Convention as Convention
from .dh import Joint as Joint
from .dh import Link as Link
from .dh import Robot as Robot
from .inverse import Branches as Branches
from .inverse import Singularity as Singularity
from .inverse import UnreachableError as UnreachableError
from .inverse import inverse_branches as inverse_branches
from .inverse import inverse_nearest as inverse_nearest
from .inverse import inverse_path as inverse_path
from .inverse_numeric import NotConvergedError as NotConvergedError
from .inverse_numeric import inverse_numeric as inverse_numeric
from .limits import CoupledRange as CoupledRange
from .limits import Limits as Limits
from .model import Body as Body
from .model import Motor as Motor
from .model import RobotModel as RobotModel
from .robots import IMU_LINKS as IMU_LINKS
from .robots import IRB1400 as IRB1400
from .robots import IRB1400_IMU as IRB1400_IMU
from .robots import IRB1400_LIMITS as IRB1400_LIMITS
from .robots import LARGE_ROBOT as LARGE_ROBOT
from .robots import LARGE_ROBOT_LIMITS as LARGE_ROBOT_LIMITS
from .wrist_arm import UnsolvableGeometryError as UnsolvableGeometryError
