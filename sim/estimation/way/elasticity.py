"""Constants of the springs in an arm: gears with lost motion, and the structure in series."""

from dataclasses import dataclass, replace

import numpy as np

from armside.arrays import Array

from ...robot.effects import Effect, available
from ...robot.mjcf import numeric
from ...robot.model import RobotModel
from ..nominal import NominalArm


@dataclass(frozen=True, eq=False)
class Elasticity:
    """n elastic degrees of freedom, a of them gears."""

    stiffness: Array
    """(n,) [N m/rad], of the wound gear and of the structure."""
    damping: Array
    """(n,) [N m s/rad]."""
    axes: np.ndarray
    """(a,) the gears among them."""
    softening: Array
    """(n,) in [0, 1): fraction of the stiffness that is missing within the lost motion."""
    lost_motion: Array
    """(n,) [rad], half width of the soft range."""

    def scaled(
        self, stiffness: Array, gear_damping: float, structure_damping: float, lost_motion: float
    ) -> "Elasticity":
        """With factors on stiffness (n,), damping, and the width of the soft range."""
        damping = np.full(len(self.damping), structure_damping)
        damping[self.axes] = gear_damping
        return replace(
            self,
            stiffness=self.stiffness * stiffness,
            damping=self.damping * damping,
            lost_motion=self.lost_motion * lost_motion,
        )


def nominal_elasticity(robot: RobotModel, arm: NominalArm) -> Elasticity:
    """Assumed gears of an arm, its structure, and the lost motion that the robot's file states.

    A file without lost motion has gears of linear springs.
    """
    mj, n, joints = arm.mj, arm.n_free, arm.motion.joints
    stiffness, damping = mj.jnt_stiffness.ravel()[joints], mj.dof_damping.ravel()[joints]
    stiffness[arm.axes], damping[arm.axes] = np.diag(arm.stiffness), arm.damping
    softening, lost = np.zeros(n), np.zeros(n)
    if Effect.LOST_MOTION in available(robot):
        a = robot.n_axes
        whole = [float(robot.mj.joint(f"flex_{i + 1}").stiffness.flat[0]) for i in range(a)]
        softening[arm.axes] = 1.0 - numeric(robot.mj, "gear_soft_stiffness", a) / whole
        lost[arm.axes] = numeric(robot.mj, "gear_lost_motion", a)
    return Elasticity(stiffness, damping, arm.axes, softening, lost)
