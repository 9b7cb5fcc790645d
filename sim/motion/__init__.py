"""Motion: geometric paths, jerk-limited timing, tool motions and the joint references they need.

SI units, base axes, quaternions w first (base to tool). Arc length s [m] starts at 0 where the
motion starts. A limit that shaped a motion is named as (limit, axis, first time [s]): axis 1..6 is
a motor, axis 0 the tool on its path.
"""

from ..cut.path import Circle as Circle
from ..cut.path import CuttingPath as CuttingPath
from ..cut.path import Plane as Plane
from ..cut.reference import joint_reference as joint_reference
from ..cut.reference import plan_cut as plan_cut
from ..cut.timing import PathLimits as PathLimits
from ..cut.tool_motion import ToolMotion as ToolMotion
from ..cut.tool_motion import cut as cut
