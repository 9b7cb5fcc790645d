"""A robot of numbers as compiled functions of its motor angles: kinematics, dynamics, sensors."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array, check_out, finite_array, real_array

from .cache import native_function
from .dh import Robot
from .equations.inertial_model import InertialModel

CompiledFunction = Callable[..., Array]
"""Function of vectors, and of `out=`; a batch of N has a leading axis in arguments and result."""


@dataclass(frozen=True, eq=False)
class CompiledRobot:
    """Numeric kinematics of one robot; see `compile`. Each function is built on first use.

    Functions accept anything array-like; C-contiguous float64 arrays take the fast path. They
    return `out` when it is given, else a new array; `out` may overlap the arguments. NaN in an
    argument gives NaN in every element that depends on it, no error. A process that receives the
    pickled object loads the functions from the cache folder.
    """

    robot: Robot
    cache: Path | str | None = None

    def __post_init__(self) -> None:
        refuse_symbols("compile", self.robot.name, self.robot.free_symbols)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.robot, self.cache)

    @cached_property
    def pose(self) -> CompiledFunction:
        """pose(phi): T_base_tool, shape (4, 4). Thesis (3.26)."""
        return self._function("pose", 1, (4, 4))

    @cached_property
    def jacobian(self) -> CompiledFunction:
        """jacobian(phi): shape (6, n), (v, omega) of the tool origin in base axes for motor rates.

        Thesis (3.39), with (4.10): J_phi = J_theta coupling.
        """
        return self._function("jacobian", 1, (6, self.robot.n_joints))

    @cached_property
    def jacobian_rate(self) -> CompiledFunction:
        """jacobian_rate(phi, phi_dot): shape (6, n), dJ/dt. Thesis (4.5)."""
        return self._function("jacobian_rate", 2, (6, self.robot.n_joints))

    @cached_property
    def acceleration(self) -> CompiledFunction:
        """acceleration(phi, phi_dot, phi_ddot): shape (6,), classical (v_dot, omega_dot) of the
        tool origin in base axes, without gravity. Thesis (3.57).
        """
        return self._function("acceleration", 3, (6,))

    def _function(self, name: str, arguments: int, shape: tuple[int, ...], *frame: int) -> Any:
        def program() -> Any:
            from .equations import forward_kinematics

            return getattr(forward_kinematics, name)(self.robot, *frame)

        sizes = (self.robot.n_joints,) * arguments
        module = "_".join([name, *map(str, frame)])
        return native_function(module, self.robot.key, program, sizes, shape, self.cache)


def compile(robot: Robot, *, cache: Path | str | None = None) -> CompiledRobot:
    """Compiled pose, Jacobian and acceleration of a robot.

    cache: folder for generated code; the platform's cache folder by default. Raises ValueError if a
    D-H parameter is symbolic.
    """
    return CompiledRobot(robot, cache)


def compile_frame_pose(
    robot: Robot, frame: int, *, cache: Path | str | None = None
) -> CompiledFunction:
    """pose(phi): T_base_frame, shape (4, 4). Thesis (3.22).

    frame: 0 is the base, k the frame of the k-th link, constant links counted.

    Raises ValueError for another frame, or a symbolic parameter.
    """
    return CompiledRobot(robot, cache)._function("pose", 1, (4, 4), frame)


def compile_frame_jacobian(
    robot: Robot, frame: int, axes: int = 0, *, cache: Path | str | None = None
) -> CompiledFunction:
    """jacobian(phi): shape (6, n), (v, omega) of the origin of a frame for motor rates.

    frame: 0 is the base, k the frame of the k-th link, constant links counted.
    axes: frame whose axes v and omega are in; the base's by default, the frame's own if equal.

    Raises ValueError for another frame, or a symbolic parameter.
    """
    return CompiledRobot(robot, cache)._function("jacobian", 1, (6, robot.n_joints), frame, axes)


@dataclass(frozen=True, eq=False)
class CompiledDynamics:
    """Numeric dynamics of one inertial model; see `compile_dynamics`. Built on first use.

    Torques are those of the motors on the arm side of the gear. Thesis (2.15).
    """

    model: InertialModel
    cache: Path | str | None = None

    def __post_init__(self) -> None:
        refuse_symbols("compile_dynamics", self.model.robot.name, self.model.free_symbols)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.model, self.cache)

    @cached_property
    def mass_matrix(self) -> CompiledFunction:
        """mass_matrix(phi): D, shape (n, n), rotor inertia included."""
        return self._function("mass_matrix", 1, 2)

    @cached_property
    def gravity_torque(self) -> CompiledFunction:
        """gravity_torque(phi): g, shape (n,)."""
        return self._function("gravity_torque", 1)

    @cached_property
    def bias_torque(self) -> CompiledFunction:
        """bias_torque(phi, phi_dot): C phi_dot + g + f, shape (n,)."""
        return self._function("bias_torque", 2)

    @cached_property
    def coriolis_matrix(self) -> CompiledFunction:
        """coriolis_matrix(phi, phi_dot): C, shape (n, n), with dD/dt - 2 C skew. Thesis (2.16)."""
        return self._function("coriolis_matrix", 2, 2)

    @cached_property
    def inverse_dynamics(self) -> CompiledFunction:
        """inverse_dynamics(phi, phi_dot, phi_ddot): tau, shape (n,), friction included."""
        return self._function("inverse_dynamics", 3)

    @cached_property
    def forward_dynamics(self) -> CompiledFunction:
        """forward_dynamics(phi, phi_dot, tau): phi_ddot, shape (n,)."""
        return self._function("forward_dynamics", 3)

    def _function(self, name: str, arguments: int, axes: int = 1) -> Any:
        def program() -> Any:
            from .equations import dynamics

            return getattr(dynamics, name)(self.model)

        n = self.model.robot.n_joints
        sizes, shape = (n,) * arguments, (n,) * axes
        return native_function(name, self.model.key, program, sizes, shape, self.cache)

    @cached_property
    def rigid_rate(self) -> CompiledFunction:
        """rigid_rate(x, tau): x', x = (phi, phi_dot), shape (2 n,)."""
        return self._rate("rigid_rate", 2)

    @cached_property
    def flexible_rate(self) -> CompiledFunction:
        """flexible_rate(x, tau): x', x = (phi_arm, phi_motor, rates), shape (4 n,). K12."""
        return self._rate("flexible_rate", 4)

    @cached_property
    def rigid_rate_jacobian(self) -> CompiledFunction:
        """rigid_rate_jacobian(x, tau): dx'/dx, shape (2 n, 2 n)."""
        return self._rate_jacobian("rigid_rate", 2)

    @cached_property
    def flexible_rate_jacobian(self) -> CompiledFunction:
        """flexible_rate_jacobian(x, tau): dx'/dx, shape (4 n, 4 n)."""
        return self._rate_jacobian("flexible_rate", 4)

    def _rate(self, name: str, parts: int, along: bool = False) -> Any:
        """x' of a state of so many parts, or its derivative along a change of the state."""

        def program() -> Any:
            from .equations import state_equations

            rate = getattr(state_equations, name)(self.model)
            return state_equations.rate_tangent(rate) if along else rate

        n = self.model.robot.n_joints
        sizes = (parts * n, n, parts * n) if along else (parts * n, n)
        module = f"{name}_tangent" if along else name
        return native_function(module, self.model.key, program, sizes, sizes[:1], self.cache)

    def _rate_jacobian(self, name: str, parts: int) -> CompiledFunction:
        n = self.model.robot.n_joints
        along, size = self._rate(name, parts, along=True), parts * n

        def function(x: ArrayLike, tau: ArrayLike, /, out: Array | None = None) -> Array:
            x, tau = real_array("x", x), real_array("tau", tau)
            if out is not None:
                check_out(out, (size, size))
            if x.shape != (size,) or tau.shape != (n,):
                given = f"got {x.shape} and {tau.shape}"
                raise ValueError(f"x must be ({size},) and tau ({n},), {given}")
            return derivatives(along, out, x, tau)

        return function


def compile_dynamics(model: InertialModel, *, cache: Path | str | None = None) -> CompiledDynamics:
    """Compiled dynamics of an inertial model of numbers; for the cache see `compile`."""
    return CompiledDynamics(model, cache)


def derivatives(along: CompiledFunction, out: Array | None, x: Array, *others: Array) -> Array:
    """Jacobian by x, whose columns are derivatives along its axes, one batch for all."""
    units = np.eye(len(x))
    rows = along(*(np.tile(each, (len(x), 1)) for each in (x, *others)), units)
    if out is None:
        return np.ascontiguousarray(rows.T)
    out[...] = rows.T
    return out


@dataclass(frozen=True, eq=False)
class CompiledMeasurement:
    """Numeric measurement equations of one robot and IMU; see `compile_measurement`."""

    robot: Robot
    gravity: tuple[float, ...]
    frame: int | None
    cache: Path | str | None

    def __post_init__(self) -> None:
        refuse_symbols("compile_measurement", self.robot.name, self.robot.free_symbols)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.robot, self.gravity, self.frame, self.cache)

    @cached_property
    def reading(self) -> CompiledFunction:
        """reading(phi, phi_dot, phi_ddot): y, shape (n + 6,): motor angles, gyro, accelerometer."""
        return self._function("measurement", (self.robot.n_joints + 6,))

    @cached_property
    def jacobian(self) -> CompiledFunction:
        """jacobian(phi, phi_dot, phi_ddot): H = dy/d(phi, phi_dot, phi_ddot), (n + 6, 3 n)."""
        n = self.robot.n_joints
        return self._function("measurement_jacobian", (n + 6, 3 * n))

    def _function(self, name: str, shape: tuple[int, ...]) -> Any:
        imu = self.gravity, self.frame

        def program() -> Any:
            from .equations import imu_equations

            return getattr(imu_equations, name)(self.robot, *imu)

        key, sizes = repr((self.robot.key, imu)), (self.robot.n_joints,) * 3
        return native_function(name, key, program, sizes, shape, self.cache)


def compile_measurement(
    robot: Robot,
    gravity: Sequence[float] = (0.0, 0.0, -9.82),
    frame: int | None = None,
    *,
    cache: Path | str | None = None,
) -> CompiledMeasurement:
    """Compiled equations of the encoders and of an IMU at a frame of the robot. Row F01.

    Args:
        gravity: [m/s^2] in base axes.
        frame: link whose frame the IMU is fixed to, 1 to the number of links; the last by default.
    """
    g = finite_array("gravity", gravity)
    if g.shape != (3,):
        raise ValueError(f"gravity must have shape (3,), got {g.shape}")
    return CompiledMeasurement(robot, tuple(g.tolist()), frame, cache)


def refuse_symbols(function: str, name: str, symbols: frozenset[Any]) -> None:
    """Raise ValueError with the symbols of what a function needs as numbers."""
    if symbols:
        names = ", ".join(sorted(map(str, symbols)))
        raise ValueError(f"{function} needs a robot of numbers; {name} has symbols: {names}")
