"""Response of the tool to a correction, by the nominal robot on identified springs.

    J phi'' = kp (v - phi) + kd (g v' - phi') - f phi' - K (phi - q) - D (phi' - q')
    M q'' + (S D S^T + D_s) q' + (S K S^T + G) q = S (K phi + D phi')

v is the correction after its delay and lag, phi and q are deviations of motors and arm from rest,
all on the arm side. Coulomb friction is left out: on a contour the motors slide.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array
from armside.ilc.models.system import Complex

from ..robot.model import RobotModel
from ..robot.virtual_robot import LOG_PERIOD
from .deflection import deflection
from .elasticity import Elasticity
from .linearised_arm import LinearisedArm
from .rigid_motion import RigidMotion, segments

PLACE = 0.15
"""Change of a motor angle within which one plant serves [rad]."""
LEVER = 0.2  # [m]: 1 mrad of tool rotation weighs as much as 0.2 mm of displacement. ESTIMATE


@dataclass(frozen=True, kw_only=True, eq=False)
class ArmPlant:
    """Response of the tool to corrections."""

    robot: RobotModel
    """The nominal robot with its servo."""
    arm: LinearisedArm
    period: float
    """Sample time of the correction [s]."""

    @property
    def input_size(self) -> Array:
        """(a,) [rad]: rotations of the axes that move the tool, or rotate its lever, alike."""
        J = self.arm.tool_jacobian[:, self.arm.axes]
        return 1.0 / np.sqrt(np.square(J[:3]).sum(axis=0) + np.square(LEVER * J[3:]).sum(axis=0))

    def response(self, omega: ArrayLike) -> Complex:
        """(M, 6, a): displacement [m] and rotation [rad] of the tool in base axes for u [rad].

        omega: (M,) [rad/sample].
        """
        arm = self._whole(omega)[:, self.robot.n_axes :]
        return np.asarray(self.arm.tool_jacobian @ arm, dtype=np.complex128)

    def motor_response(self, omega: ArrayLike) -> Complex:
        """(M, a, a): motor angles [rad], arm side, for u [rad]."""
        return self._whole(omega)[:, : self.robot.n_axes]

    def torque_response(self, omega: ArrayLike) -> Complex:
        """(M, a, a), diagonal: correction u [rad] whose torque on the motors is 1 N m, arm side."""
        inverse = 1.0 / np.diagonal(self._driven(self._s(omega)), axis1=1, axis2=2)
        return np.asarray(inverse[:, :, None] * np.eye(inverse.shape[1]), dtype=np.complex128)

    def _s(self, omega: ArrayLike) -> Complex:
        s = 1j * np.asarray(omega, dtype=np.float64)[:, None, None] / self.period
        return np.asarray(s, dtype=np.complex128)

    def _driven(self, s: Complex) -> Complex:
        """(M, a, a) [N m/rad], arm side: torque of the servos for a correction."""
        drives = self.robot.drives
        square = drives.gear**2
        kp, kd = np.diag(square * drives.kp), np.diag(square * drives.kd)
        servo = kp + s * kd * drives.velocity_feedforward
        lag = 1.0 + s / (2.0 * np.pi * drives.correction_lag)
        return servo * np.exp(-s * drives.correction_delay) / lag

    def _whole(self, omega: ArrayLike) -> Complex:
        """(M, a + n, a): angles of motors and arm for u [rad]."""
        s = self._s(omega)
        arm, drives = self.arm, self.robot.drives
        n, numbers = arm.n_free, range(1, self.robot.n_axes + 1)
        square = drives.gear**2
        picked = np.zeros((n, len(numbers)))
        picked[arm.axes, range(len(numbers))] = 1.0
        spring = np.diag(arm.stiffness) + s * np.diag(arm.damping)
        mj = self.robot.mj
        rotor = np.array([mj.joint(f"motor_{i}").armature[0] for i in numbers])
        axes = [mj.actuator(f"axis_{i}").id for i in numbers]
        viscous = np.diag(square * mj.actuator_damping[axes].reshape(len(axes), -1)[:, 0])
        kp, kd = np.diag(square * drives.kp), np.diag(square * drives.kd)
        motor = s**2 * np.diag(rotor) + kp + s * (kd + viscous) + spring
        free = s**2 * arm.mass + s * arm.damping_matrix + arm.spring_matrix
        # Motors and arm in one: [motor, -spring S^T; -S spring, free] (phi, q) = (servo v, 0)
        whole = np.block([[motor, -spring @ picked.T], [-picked @ spring, free]])
        right = np.concatenate((self._driven(s), np.zeros((len(s), n, len(numbers)))), axis=1)
        return np.asarray(np.linalg.solve(whole, right), dtype=np.complex128)


@dataclass(frozen=True, kw_only=True, eq=False)
class PathPlants:
    """Plants at places along a path."""

    plants: tuple[ArmPlant, ...]
    weights: Array
    """(N, S), of each plant at each sample; they fade from place to place."""
    lowest_mode: float = 0.0
    """[Hz], of these arms with their motors held, where the springs were identified; else 0."""
    excitation: float = 0.0
    """As of `RigidMotion`, where the springs were identified; else 0."""

    @property
    def middle(self) -> ArmPlant:
        return self.plants[len(self.plants) // 2]


def plants_along(
    robot: RobotModel,
    motion: RigidMotion,
    springs: Elasticity,
    *,
    identified: bool,
    excitation: float = 0.0,
) -> PathPlants:
    """Plants along a rigid motion. identified: the springs are no assumption.

    excitation: of that motion.
    """
    place, samples = places_along(motion.phi)
    angle = deflection(motion, springs).angle
    arms = [
        motion.linearised(int(motion.segment[at]), springs.mean_slope(angle[place == s]))
        for s, at in enumerate(samples)
    ]
    plants = tuple(ArmPlant(robot=robot, arm=arm, period=LOG_PERIOD) for arm in arms)
    mode = min(float(arm.locked_modes()[0]) for arm in arms) if identified else 0.0
    weights = fading(motion.time[samples], motion.time)
    return PathPlants(
        plants=plants,
        weights=weights,
        lowest_mode=mode,
        excitation=excitation if identified else 0.0,
    )


def places_along(phi: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(N,) the place of each sample of motor angles (N, a) [rad], and (S,) the sample in the middle
    of each place."""
    place = segments(phi, PLACE)
    middles = [int(np.flatnonzero(place == s).mean()) for s in range(place[-1] + 1)]
    return place, np.array(middles)


def fading(centres: Array, time: Array) -> Array:
    """(N, S) weights at times (N,) that fade linearly between centres (S,), ascending."""
    return np.stack([np.interp(time, centres, row) for row in np.eye(len(centres))], axis=1)
