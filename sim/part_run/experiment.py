"""A whole part before its first run: planned, placed in the cell, and loaded into the robot."""

from dataclasses import dataclass, field

import numpy as np

from armside.arrays import Array
from armside.kinematics import UnreachableError

from ..laser.rig import Rig, controlled, rig
from ..laser.setup import Setup
from ..laser.specification import plane_at
from ..motion.path import Plane
from ..motion.tool_motion import joint_reference
from ..part.chain import place
from ..part.motion import PartMotion
from ..part.part import Part
from ..part.plan import Cutting, Plan, plan
from ..robot.kinematics_check import cell_model
from ..robot.model import RobotModel
from ..robot.statics import Statics, anticipated_shift, smoothed
from ..robot.virtual_robot import LOG_PERIOD
from .joint_bounds import JointBounds
from .sequence import sequence

EXCESS = 0.01
"""Relative excess of a joint's speed limit between the places at which a plan looks at it."""


@dataclass(frozen=True, kw_only=True)
class Job:
    """A part, how it is cut, and the robot that cuts it. SI units."""

    part: Part = field(repr=False)
    cutting: Cutting = field(default_factory=Cutting)
    setup: Setup = field(default_factory=Setup)
    across_tool: bool = False
    """In the plane across the tool's axis instead of the base x-y plane."""

    @property
    def plane(self) -> Plane:
        """Plane of the sheet, its origin at the pose: the middle of the part."""
        return plane_at(self.setup, self.across_tool)


@dataclass(frozen=True, kw_only=True)
class PartExperiment(Rig):
    """Everything that is fixed before the first run."""

    job: Job
    plan: Plan
    motion: PartMotion = field(repr=False)

    @property
    def setup(self) -> Setup:
        """Robot and its state."""
        return self.job.setup

    @property
    def programmed(self) -> Array:
        """(N, 3) [m], positions of the tool."""
        return self.motion.position

    @property
    def turn_rate(self) -> float:
        """[turns/s], of the contour that is cut in the shortest time."""
        return max(1.0 / (end - begin) for begin, end in self._contour_times)

    @property
    def _contour_times(self) -> list[tuple[float, float]]:
        return [cut.contour_time for cut in self.motion.cuts]


def planned(job: Job) -> Plan:
    """Plan of a job, within the limits of its robot's joints and drives.

    Raises ValueError as `prepare` does.
    """
    setup = job.setup
    controller = Statics(controlled(setup, cell_model(setup.cell, setup.model)))
    bounds = JointBounds(setup, controller, job.plane, job.part.middle, job.cutting.speed)
    return plan(job.part, job.cutting, bounds.along)


def prepare(
    job: Job, made: Plan | None = None, *, seed: int = 0, nominal: RobotModel | None = None
) -> PartExperiment:
    """Plan a part, draw the robot individual, set up the tracker and load the motion.

    Args:
        made: plan of the part, where it was made already.
        seed, nominal: as of `armside.sim.laser.prepare`.

    Raises:
        ValueError: the part leaves the reach or the joint limits (where), the beam is too wide, or
            the robot cannot carry its payload.
    """
    sheet = planned(job) if made is None else made

    def motion_and_reference(controller: Statics) -> tuple[PartMotion, Array]:
        motion = sequence(job.setup, sheet, job.plane)
        return motion, reference(job.setup, controller, motion)

    motion, found = rig(job.setup, motion_and_reference, seed=seed, nominal=nominal)
    return PartExperiment(**vars(found), job=job, plan=sheet, motion=motion)


def reference(setup: Setup, controller: Statics, motion: PartMotion) -> Array:
    """(N, 6) [rad], inverse kinematics of the motion, shifted against the anticipated deflection.

    Raises ValueError where the part leaves the reach, joint ranges or joint speeds, with the place.
    """
    robot, limits = setup.cell.robot, setup.cell.limits
    try:
        phi = joint_reference(motion, robot, limits)
        _check_speed(phi, motion, np.array(limits.speed))
        shift = smoothed(anticipated_shift(controller, phi, LOG_PERIOD))
        return joint_reference(motion, robot, limits, start=phi[0], shift=shift)
    except UnreachableError as error:
        where = _where(motion, error.index)
        far = f"{1e3 * error.distance:.1f} mm outside the workspace of {robot.name}"
        raise ValueError(
            f"the part is out of reach at {where}: the wrist would lie {far}"
        ) from error


def _check_speed(phi: Array, motion: PartMotion, most: Array) -> None:
    use = np.abs(np.gradient(phi, LOG_PERIOD, axis=0)) / most
    if use.max() > 1.0 + EXCESS:
        sample, axis = np.unravel_index(int(use.argmax()), use.shape)
        where = _where(motion, int(sample))
        raise ValueError(f"axis {axis + 1} would be too fast at {where}")


def _where(motion: PartMotion, sample: int) -> str:
    """Place in the drawing of a sample of the motion."""
    in_plane = motion.plane.from_base(motion.position[sample])[:2]
    return place(in_plane + np.array(motion.middle))
