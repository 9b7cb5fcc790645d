"""Motor logs of a real robot that repeats a path, beside the virtual robot on the same path.

Deviations are across the path at constant speed, of the tool by motor angles: neither robot's tool
is seen. SI units, base axes.
"""

from .beside_virtual import AtSpeed as AtSpeed
from .beside_virtual import PathComparison as PathComparison
from .beside_virtual import TimingErrors as TimingErrors
from .beside_virtual import compare_logs as compare_logs
from .beside_virtual import timing_errors as timing_errors
from .waypoint_path import PathScatter as PathScatter
from .waypoint_path import WaypointPath as WaypointPath
from .waypoint_path import path_scatter as path_scatter
from .waypoint_path import waypoint_path as waypoint_path
