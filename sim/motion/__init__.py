"""Motion: geometric paths, jerk-limited timing, tool motions and the joint references they need.

SI units, base axes, quaternions w first (base to tool). Arc length s [m] starts at 0 where the
motion starts. A limit that shaped a motion is named as (limit, axis, first time [s]): axis 1..6 is
a motor, axis 0 the tool on its path.
"""

from .joints import joint_reference as joint_reference
from .joints import plan_cut as plan_cut
from .path import Circle as Circle
from .path import CuttingPath as CuttingPath
from .path import Plane as Plane
from .program import ToolMotion as ToolMotion
from .program import cut as cut
from .timing import PathLimits as PathLimits
