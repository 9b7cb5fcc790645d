"""Examination of a robot model, with verdicts: geometry, limits, drives, masses, modes, poses."""

from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from armside import kinematics
from armside.arrays import Array

from ..cell import Cell, ToolPose
from ..motion.tool_motion import joint_reference
from ..robot.kinematics_check import (
    POSITION,
    ROTATION,
    between,
    configurations,
    first_axis,
    site_poses,
)
from ..robot.linkage import LARGEST_GAP
from ..robot.model import RobotModel
from ..robot.statics import Statics, natural_frequencies
from .check import Check

LEAST_DEXTERITY = 0.005
"""Of a named pose. ESTIMATE: the poses of thesis (9.3), near a wrist singularity, have 0.016 and
more."""
_ZERO = 1e-9
"""Singular values that count as none [m/rad]."""
HIGHEST_MODE = 0.3
"""Largest product of frequency [Hz] and time step [s], beyond which an explicit integrator is
unstable."""
LOWEST_MODE = 1.0
"""[Hz], motors locked; an arm that is softer has a spring without stiffness. ESTIMATE."""
ROUNDING = 5e-5
"""Of ranges [rad] and speeds [rad/s], which stand in the files with four decimals."""


@dataclass(frozen=True)
class NamedPose:
    """A named pose as the controller reaches it from the home pose."""

    name: str
    motor_angle: Array | None
    """(n,) [rad], arm side; None where it is not reached."""
    problem: str
    """Why it is not reached: reach, or axis and limit."""
    dexterity: float
    """Least over greatest singular value of the Jacobian of what a contour sets: the tool's pose,
    or its position where the orientation is free. 0 at a singularity, NaN where not reached."""


@dataclass(frozen=True)
class _Still:
    position: Array
    quaternion: Array


def named_poses(cell: Cell) -> list[NamedPose]:
    """All poses of a cell, in the order of its file."""
    return [_found(cell, name, pose) for name, pose in cell.poses.items()]


def checks_of(found: list[NamedPose]) -> list[Check]:
    """Verdicts; each names the pose that is worst off."""
    missed = [one for one in found if one.motor_angle is None]
    what = "named poses out of reach or limits"
    if missed:
        what += f" ({missed[0].name}: {missed[0].problem})"
    checks = [_check(what, len(missed), high=0.0)]
    reached = [one for one in found if one.motor_angle is not None]
    if reached:
        worst = min(reached, key=lambda one: one.dexterity)
        far = f"least over greatest singular value of the Jacobian, pose {worst.name}"
        checks.append(_check(far, worst.dexterity, low=LEAST_DEXTERITY))
    return checks


def _found(cell: Cell, name: str, pose: ToolPose) -> NamedPose:
    still = _Still(np.array([pose.position]), np.array([pose.quaternion]))
    free = cell.free_rotation
    try:
        (phi,) = joint_reference(
            still, cell.robot, cell.limits, start=cell.home, free_rotation=free
        )
    except ValueError as error:
        return NamedPose(name, None, str(error), float("nan"))
    return NamedPose(name, phi, "", _dexterity(cell, phi))


def _dexterity(cell: Cell, phi: Array) -> float:
    """Of the directions that the robot has in other configurations."""
    rows = slice(3) if cell.free_rotation else slice(6)
    jacobian = kinematics.compile(cell.robot).jacobian
    elsewhere = np.linalg.matrix_rank(jacobian(configurations(cell.limits))[:, rows], _ZERO)
    S = np.linalg.svd(jacobian(phi)[rows], compute_uv=False)
    return float(S[elsewhere.max() - 1] / S[0])


@dataclass(frozen=True, kw_only=True)
class Agreement:
    """Greatest difference between one site of the MJCF and the last frame of its D-H model."""

    site: str
    position: float
    """[m]."""
    rotation: float
    """[rad]."""
    at: Array
    """(n,) [rad], motor angles of the greatest difference."""


@dataclass(frozen=True)
class Examination:
    """Numbers of a robot model beside the cell whose D-H model its controller has."""

    model: RobotModel
    cell: Cell

    @cached_property
    def configurations(self) -> Array:
        """(K, n) [rad], the zero pose and random motor angles within the limits."""
        return configurations(self.cell.limits)

    @cached_property
    def agreements(self) -> tuple[Agreement, ...]:
        """Of tool and IMU."""
        return self._agreement("tool0", self.cell.robot), self._agreement("imu", self.cell.with_imu)

    def _agreement(self, site: str, robot: kinematics.Robot) -> Agreement:
        phi = self.configurations
        T, expected = site_poses(self.model, phi, site)[0], kinematics.compile(robot).pose(phi)
        position, rotation = between(T, expected)
        worst = int(np.argmax(position / POSITION + rotation / ROTATION))
        distance, angle = float(position.max()), float(rotation.max())
        return Agreement(site=site, position=distance, rotation=angle, at=phi[worst])

    @cached_property
    def first_axis(self) -> int | None:
        """Axis, counted from 1, that moves the tool otherwise than the D-H model has it."""
        return first_axis(self.model, self.cell.robot)

    @cached_property
    def opening(self) -> float:
        """Widest opening of a closed chain [m]; 0 for an open one."""
        return float(site_poses(self.model, self.configurations)[1].max())

    @cached_property
    def reach(self) -> float:
        """Greatest distance of the tool from the base's origin in the configurations [m]."""
        T, _ = site_poses(self.model, self.configurations)
        return float(np.linalg.norm(T[:, :3, 3], axis=1).max())

    @cached_property
    def holding(self) -> Array:
        """(n,), greatest torque of gravity over the torque limit of each drive."""
        still, drives = np.zeros_like(self.configurations), self.model.drives
        statics = Statics(self.model)
        torque = statics.motor_torque(statics.rigid_forces(self.configurations, still, still))
        return np.abs(torque).max(axis=0) / np.abs(drives.gear) / drives.torque_limit

    @cached_property
    def locked_modes(self) -> Array:
        """Natural frequencies in the zero pose with the motors held [Hz]."""
        return natural_frequencies(self.model, np.zeros(self.cell.robot.n_joints), locked=True)

    @cached_property
    def free_modes(self) -> Array:
        """Natural frequencies in the zero pose with the motors free, their own motion left out."""
        n = self.cell.robot.n_joints
        return natural_frequencies(self.model, np.zeros(n), locked=False)[n:]

    @cached_property
    def highest_mode(self) -> float:
        """Highest natural frequency in any of the configurations, motors free [Hz]."""
        highest = (
            natural_frequencies(self.model, phi, locked=False)[-1] for phi in self.configurations
        )
        return float(max(highest))

    @property
    def mass(self) -> float:
        """Of the whole robot, tool and base included [kg]."""
        return float(self.model.mj.body_mass.sum())

    @cached_property
    def impossible_inertias(self) -> tuple[str, ...]:
        """Bodies whose principal moments of inertia no mass distribution has."""
        mj = self.model.mj
        low, middle, high = np.sort(mj.body_inertia, axis=1).T
        wrong = np.flatnonzero((low < 0.0) | (high > (low + middle) * (1.0 + 1e-9)))
        return tuple(mujoco.mj_id2name(mj, mujoco.mjtObj.mjOBJ_BODY, int(i)) for i in wrong)

    @property
    def margins(self) -> Array:
        """(n,) [rad], from the controller's limits to the nearer hard stop; negative beyond it."""
        limits, stops = self.cell.limits, self.model.joint_range
        return np.minimum(limits.lower - stops[:, 0], stops[:, 1] - limits.upper)

    @cached_property
    def poses(self) -> list[NamedPose]:
        """Named poses of the cell, as its controller reaches them."""
        return named_poses(self.cell)

    def checks(self) -> list[Check]:
        """Verdicts, each with its number and band."""
        faster = np.max(np.array(self.cell.limits.speed) - self.model.drives.speed_limit)
        margin, fastest = np.rad2deg(self.margins.min()), self.highest_mode * self.model.timestep
        wrong = len(self.impossible_inertias)
        stops = "hard stops beyond the controller's limits [deg]"
        found = [
            _check(f"site {one.site} off the D-H model [{unit}]", 1e6 * value, high=1e6 * most)
            for one in self.agreements
            for unit, value, most in (
                ("um", one.position, POSITION),
                ("urad", one.rotation, ROTATION),
            )
        ]
        found += [
            _check("closed chains: opening [um]", 1e6 * self.opening, high=1e6 * LARGEST_GAP),
            _check(stops, margin, low=-float(np.rad2deg(ROUNDING))),
            _check("controller's speed above the drive's [rad/s]", faster, high=ROUNDING),
            _check("torque of gravity over the drive's limit", self.holding.max(), high=1.0),
            _check("bodies with an impossible inertia", wrong, high=0.0),
            _check("highest mode of the springs times time step", fastest, high=HIGHEST_MODE),
        ]
        if len(self.locked_modes):
            lowest = self.locked_modes[0]
            found.append(_check("lowest mode, motors locked [Hz]", lowest, low=LOWEST_MODE))
        return found + checks_of(self.poses)


def _check(what: str, value: float, low: float | None = None, high: float | None = None) -> Check:
    return Check("", what, "", float(value), low, high)
