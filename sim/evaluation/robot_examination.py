"""Examination of a robot model, with verdicts: geometry, limits, drives, masses, modes, poses."""

from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from armside import kinematics
from armside.arrays import Array
from armside.kinematics.rotation import from_quaternion

from ..cell import Cell, ToolPose, tool_at
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
from .usual_ranges import POSSIBLE, USUAL, Usual

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
_RADIAN, _STARTS = 0.3, 8
"""[m] that a radian counts where no pose within the limits is reached, and starts. ESTIMATE."""
ROUNDING = 5e-5
"""Of ranges [rad] and speeds [rad/s], which stand in the files with four decimals."""


def _rounded(pose: ToolPose) -> ToolPose:
    """The pose as a person would type it."""
    (x, y, z), (w, a, b, c) = ([round(v, 4) for v in q] for q in (pose.position, pose.quaternion))
    return ToolPose((x, y, z), (w, a, b, c))


@dataclass(frozen=True)
class Reachable:
    """A pose within the limits, as near as one was found to a pose that is not."""

    pose: ToolPose
    distance: float
    """[m], from the pose that was asked for."""
    angle: float
    """[rad]; 0 where the orientation is free."""

    def __str__(self) -> str:
        shown = _rounded(self.pose)
        position, quaternion = list(shown.position), list(shown.quaternion)
        off = f"{1e3 * self.distance:.4g} mm and {np.rad2deg(self.angle):.3g} deg off"
        return f"nearest reachable, {off}: position = {position}, quaternion = {quaternion}"


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
    nearest: Reachable | None = None
    """Of a pose that is not reached."""


@dataclass(frozen=True)
class _Still:
    position: Array
    quaternion: Array


def named_poses(cell: Cell) -> list[NamedPose]:
    """All poses of a cell, in the order of its file."""
    found = list[NamedPose]()
    for name, pose in cell.poses.items():
        try:
            phi = _motor_angles(cell, pose)
            found.append(NamedPose(name, phi, "", _dexterity(cell, phi)))
        except ValueError as error:
            found.append(NamedPose(name, None, str(error), np.nan, _nearest(cell, pose)))
    return found


def checks_of(found: list[NamedPose]) -> list[Check]:
    """Verdicts; each names the pose that is worst off."""
    missed = [one for one in found if one.motor_angle is None]
    what = "named poses out of reach or limits"
    if missed:
        others = "".join(f"; {one.name}" for one in missed[1:])
        what += f" ({missed[0].name}: {missed[0].problem}; {missed[0].nearest}{others})"
    checks = [_check(what, len(missed), high=0.0)]
    if len(found) > len(missed):
        worst = min(found, key=lambda one: np.nan_to_num(one.dexterity, nan=np.inf))
        far = f"least over greatest singular value of the Jacobian, pose {worst.name}"
        checks.append(_check(far, worst.dexterity, low=LEAST_DEXTERITY))
    return checks


def _motor_angles(cell: Cell, pose: ToolPose) -> Array:
    """(n,) [rad], as of a cut at the pose. Raises ValueError where it is not reached."""
    still = _Still(np.array([pose.position]), np.array([pose.quaternion]))
    free, home = cell.free_rotation, cell.home
    (phi,) = joint_reference(still, cell.robot, cell.limits, start=home, free_rotation=free)
    return phi


def _nearest(cell: Cell, pose: ToolPose) -> Reachable:
    """Least squares of position and orientation within the limits, the best of several starts;
    from there towards home until it is no singularity, so that it can be cut at."""
    from scipy.optimize import least_squares
    from scipy.spatial.transform import Rotation

    tool, limits = kinematics.compile(cell.robot).pose, cell.limits
    R, weight = from_quaternion(np.array(pose.quaternion)), 0.0 if cell.free_rotation else _RADIAN

    def miss(phi: Array) -> Array:
        T = tool(phi)
        turn = Rotation.from_matrix(T[:3, :3] @ R.T).as_rotvec()
        return np.r_[T[:3, 3] - pose.position, weight * turn]

    ends, (zero, *drawn) = (limits.lower, limits.upper), configurations(limits)[:_STARTS]
    first = np.clip(zero if cell.home is None else cell.home, *ends)
    found = [least_squares(miss, start, bounds=ends).x for start in (first, *drawn)]
    within = [phi for phi in found if limits.contain(phi)] or [first]
    best = min(within, key=lambda phi: float(np.linalg.norm(miss(phi))))
    for phi in best + np.linspace(0.0, 1.0, 51)[:, np.newaxis] * (first - best):
        with suppress(ValueError):
            there = _motor_angles(cell, _rounded(tool_at(cell.robot, phi)))
            if _dexterity(cell, there) >= LEAST_DEXTERITY:
                best = phi
                break
    off = miss(best)
    angle = np.linalg.norm(off[3:]) / weight if weight else 0.0
    return Reachable(tool_at(cell.robot, best), float(np.linalg.norm(off[:3])), float(angle))


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
class Beside:
    """Numbers of a robot beside their usual range for its reach."""

    usual: Usual
    values: Array
    range: tuple[float, float]

    @property
    def inside(self) -> bool:
        """True where every number is in the range; of a rigid arm without modes too."""
        low, high = self.range
        return bool(((self.values >= low) & (self.values <= high)).all())


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
        found, phi = [], self.configurations
        for site, robot in (("tool0", self.cell.robot), ("imu", self.cell.with_imu)):
            T, expected = site_poses(self.model, phi, site)[0], kinematics.compile(robot).pose(phi)
            position, rotation = between(T, expected)
            worst = int(np.argmax(position / POSITION + rotation / ROTATION))
            distance, angle = float(position.max()), float(rotation.max())
            found.append(Agreement(site=site, position=distance, rotation=angle, at=phi[worst]))
        return tuple(found)

    @cached_property
    def first_axis(self) -> int | None:
        """Axis, counted from 1, that moves the tool otherwise than the D-H model has it."""
        return first_axis(self.model, self.cell.robot)

    @cached_property
    def _tool(self) -> tuple[Array, Array]:
        return site_poses(self.model, self.configurations)

    @property
    def opening(self) -> float:
        """Widest opening of a closed chain [m]; 0 for an open one."""
        return float(self._tool[1].max())

    @property
    def reach(self) -> float:
        """Greatest distance of the tool from the base's origin in the configurations [m]."""
        return float(np.linalg.norm(self._tool[0][:, :3, 3], axis=1).max())

    @property
    def horizontal_reach(self) -> float:
        """Greatest distance of the tool from the base's z-axis [m], as data sheets have it."""
        return float(np.linalg.norm(self._tool[0][:, :2, 3], axis=1).max())

    @cached_property
    def holding(self) -> Array:
        """(n,), greatest torque of gravity over the torque limit of each drive."""
        still, drives = np.zeros_like(self.configurations), self.model.drives
        statics = Statics(self.model)
        torque = statics.motor_torque(statics.rigid_forces(self.configurations, still, still))
        return np.abs(torque).max(axis=0) / np.abs(drives.gear) / drives.torque_limit

    @cached_property
    def acceleration(self) -> Array:
        """(n,) [rad/s^2], of each axis alone at home by the peak torque of its drive, without
        gravity and friction; [m/s^2] of a prismatic axis."""
        n, drives, statics = self.cell.robot.n_joints, self.model.drives, Statics(self.model)
        phi = np.tile(np.zeros(n) if self.cell.home is None else self.cell.home, (n + 1, 1))
        still, moved = np.zeros_like(phi), np.vstack((np.zeros(n), np.eye(n)))
        torque = statics.motor_torque(statics.rigid_forces(phi, still, moved))
        inertia = np.abs(np.diag(torque[1:] - torque[0]))
        return np.abs(drives.gear) * drives.torque_limit / inertia

    @cached_property
    def usual(self) -> list[Beside]:
        """Numbers of the robot beside the usual ranges of arms of its reach."""
        turning = ~np.array(self.cell.robot.slides)
        values = {
            "reach": [self.horizontal_reach],
            "mass": [self.mass],
            "holding": [self.holding.max()],
            "acceleration": self.acceleration[turning],
            "lowest_mode": self.locked_modes[:1],
            "gear": np.abs(self.model.drives.gear)[turning],
        }
        return [
            Beside(USUAL[name], np.array(own), USUAL[name].range(self.horizontal_reach))
            for name, own in values.items()
        ]

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
        modes = (natural_frequencies(self.model, p, locked=False) for p in self.configurations)
        return float(max(each[-1] for each in modes))

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
        """Verdicts, each with its number and band; of accelerations, on the axis whose drive is
        furthest from what arms of this reach have."""
        faster = np.max(np.array(self.cell.limits.speed) - self.model.drives.speed_limit)
        low, high = USUAL["acceleration"].range(self.horizontal_reach)
        axis = int(np.argmax(np.abs(np.log(self.acceleration / np.sqrt(low * high)))))
        torque = f"peak torque over inertia, axis {axis + 1} [1/s^2]"
        margin, fastest = np.rad2deg(self.margins.min()), self.highest_mode * self.model.timestep
        stops = "hard stops beyond the controller's limits [deg]"
        found = list[Check]()
        for one in self.agreements:
            off, angle = f"site {one.site} off the D-H model", 1e6 * one.rotation
            found.append(_check(f"{off} [um]", 1e6 * one.position, high=1e6 * POSITION))
            found.append(_check(f"{off} [urad]", angle, high=1e6 * ROTATION))
        found += [
            _check("closed chains: opening [um]", 1e6 * self.opening, high=1e6 * LARGEST_GAP),
            _check(stops, margin, low=-float(np.rad2deg(ROUNDING))),
            _check("controller's speed above the drive's [rad/s]", faster, high=ROUNDING),
            _check("torque of gravity over the drive's limit", self.holding.max(), high=1.0),
            _check(torque, self.acceleration[axis], low / POSSIBLE, high * POSSIBLE),
            _check("bodies with an impossible inertia", len(self.impossible_inertias), high=0.0),
            _check("highest mode of the springs times time step", fastest, high=HIGHEST_MODE),
        ]
        if len(self.locked_modes):
            lowest = self.locked_modes[0]
            found.append(_check("lowest mode, motors locked [Hz]", lowest, low=LOWEST_MODE))
        return found + checks_of(self.poses)


def _check(what: str, value: float, low: float | None = None, high: float | None = None) -> Check:
    return Check("", what, "", float(value), low, high)
