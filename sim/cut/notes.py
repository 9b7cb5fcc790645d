"""Notes of a planned motion: limits that made it slower than programmed."""

from collections.abc import Iterator

from ..notes import Cause, Note
from .timing import PathLimits
from .tool_motion import ToolMotion


def motion_notes(motion: ToolMotion, limits: PathLimits | None = None) -> Iterator[Note]:
    """Notes of a planned motion. limits: of its planner; None where they are not known."""
    value = "the acceleration limit" if limits is None else f"{limits.acceleration:g} m/s^2"
    radius = f"{1e3 * motion.path.smallest_radius:.3g} mm"
    why = {
        "centripetal_acceleration": f"{value} across the path at a radius of {radius}",
        "joint_speed": "speed limit of axis {axis}",
    }
    causes = [why[name].format(axis=axis) for name, axis, _ in motion.limits_hit if name in why]
    if causes:
        asked, reached = 1e3 * motion.programmed_speed, 1e3 * motion.reached_speed
        lowered = f"the speed is lowered from {asked:.4g} to {reached:.4g} mm/s"
        yield Note(cause=Cause.SPEED, text=f"{lowered}: {'; '.join(causes)}")
    if any(name == "path_acceleration" for name, _, _ in motion.limits_hit):
        ramps = f"the ramps take longer: {value} along the path"
        yield Note(cause=Cause.ACCELERATION, text=ramps)
