"""A robot of numbers as compiled functions of its motor angles: kinematics, dynamics, sensors."""

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array, check_out, finite_array, real_array

from .cache import native_function, native_module
from .dh import Robot
from .equations.inertial_model import InertialModel


class AngleFunction(Protocol):
    """A function of motor angles; a batch of N has a leading axis in arguments and result."""

    def __call__(self, phi: ArrayLike, /, out: Array | None = None) -> Array: ...


class RateFunction(Protocol):
    """A function of motor angles and their rates."""

    def __call__(self, phi: ArrayLike, rate: ArrayLike, /, out: Array | None = None) -> Array: ...


class MotionFunction(Protocol):
    """A function of motor angles, their rates, and accelerations or torques."""

    def __call__(
        self, phi: ArrayLike, phi_dot: ArrayLike, third: ArrayLike, /, out: Array | None = None
    ) -> Array: ...


class StateFunction(Protocol):
    """A function of a state x and motor torques tau."""

    def __call__(self, x: ArrayLike, tau: ArrayLike, /, out: Array | None = None) -> Array: ...


class CompiledRobot:
    """Numeric kinematics of one robot; see `compile`. Each function is built on first use.

    Functions accept anything array-like; C-contiguous float64 arrays take the fast path. They
    return `out` when it is given, else a new array; `out` may overlap the arguments. NaN in an
    argument gives NaN in every element that depends on it, no error. A process that receives the
    pickled object loads the functions from the cache folder.
    """

    def __init__(self, robot: Robot, cache: Path | str | None = None) -> None:
        refuse_symbols("compile", robot.name, robot.free_symbols)
        self.robot, self._cache = robot, cache

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.robot, self._cache)

    @cached_property
    def pose(self) -> AngleFunction:
        """pose(phi): T_base_tool, shape (4, 4). Thesis (3.26)."""
        return self._function("pose", 1, (4, 4))

    @cached_property
    def jacobian(self) -> AngleFunction:
        """jacobian(phi): shape (6, n), (v, omega) of the tool origin in base axes for motor rates.

        Thesis (3.39), with (4.10): J_phi = J_theta coupling.
        """
        return self._function("jacobian", 1, (6, self.robot.n_joints))

    @cached_property
    def jacobian_rate(self) -> RateFunction:
        """jacobian_rate(phi, phi_dot): shape (6, n), dJ/dt. Thesis (4.5)."""
        return self._function("jacobian_rate", 2, (6, self.robot.n_joints))

    @cached_property
    def acceleration(self) -> MotionFunction:
        """acceleration(phi, phi_dot, phi_ddot): shape (6,), classical (v_dot, omega_dot) of the
        tool origin in base axes, without gravity. Thesis (3.57).
        """
        return self._function("acceleration", 3, (6,))

    def _function(self, name: str, arguments: int, shape: tuple[int, ...]) -> Any:
        def program() -> Any:
            from .equations import forward_kinematics

            return getattr(forward_kinematics, name)(self.robot)

        module = native_module(name, self.robot.key, program, self._cache)
        return native_function(module, (self.robot.n_joints,) * arguments, shape)


def compile(robot: Robot, *, cache: Path | str | None = None) -> CompiledRobot:
    """Compiled pose, Jacobian and acceleration of a robot.

    cache: folder for generated code; the platform's cache folder by default. Raises ValueError if a
    D-H parameter is symbolic.
    """
    return CompiledRobot(robot, cache)


class CompiledDynamics:
    """Numeric dynamics of one inertial model; see `compile_dynamics`. Built on first use.

    Torques are those of the motors on the arm side of the gear. Thesis (2.15).
    """

    def __init__(self, model: InertialModel, cache: Path | str | None = None) -> None:
        refuse_symbols("compile_dynamics", model.robot.name, model.free_symbols)
        self.model, self._n, self._cache = model, model.robot.n_joints, cache

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.model, self._cache)

    @cached_property
    def mass_matrix(self) -> AngleFunction:
        """mass_matrix(phi): D, shape (n, n), rotor inertia included."""
        return self._function("mass_matrix", (self._n,), (self._n, self._n))

    @cached_property
    def gravity_torque(self) -> AngleFunction:
        """gravity_torque(phi): g, shape (n,)."""
        return self._function("gravity_torque", (self._n,), (self._n,))

    @cached_property
    def bias_torque(self) -> RateFunction:
        """bias_torque(phi, phi_dot): C phi_dot + g + f, shape (n,)."""
        return self._function("bias_torque", (self._n,) * 2, (self._n,))

    @cached_property
    def coriolis_matrix(self) -> RateFunction:
        """coriolis_matrix(phi, phi_dot): C, shape (n, n), with dD/dt - 2 C skew. Thesis (2.16)."""
        return self._function("coriolis_matrix", (self._n,) * 2, (self._n, self._n))

    @cached_property
    def inverse_dynamics(self) -> MotionFunction:
        """inverse_dynamics(phi, phi_dot, phi_ddot): tau, shape (n,), friction included."""
        return self._function("inverse_dynamics", (self._n,) * 3, (self._n,))

    @cached_property
    def forward_dynamics(self) -> MotionFunction:
        """forward_dynamics(phi, phi_dot, tau): phi_ddot, shape (n,)."""
        return self._function("forward_dynamics", (self._n,) * 3, (self._n,))

    @cached_property
    def rigid_rate(self) -> StateFunction:
        """rigid_rate(x, tau): x', x = (phi, phi_dot), shape (2 n,)."""
        return self._function("rigid_rate", (2 * self._n, self._n), (2 * self._n,))

    @cached_property
    def flexible_rate(self) -> StateFunction:
        """flexible_rate(x, tau): x', x = (phi_arm, phi_motor, rates), shape (4 n,). K12."""
        return self._function("flexible_rate", (4 * self._n, self._n), (4 * self._n,))

    @cached_property
    def rigid_rate_jacobian(self) -> StateFunction:
        """rigid_rate_jacobian(x, tau): dx'/dx, shape (2 n, 2 n)."""
        return self._rate_jacobian("rigid_rate", 2 * self._n)

    @cached_property
    def flexible_rate_jacobian(self) -> StateFunction:
        """flexible_rate_jacobian(x, tau): dx'/dx, shape (4 n, 4 n)."""
        return self._rate_jacobian("flexible_rate", 4 * self._n)

    def _program(self, name: str) -> Any:
        from .equations import coriolis, dynamics, state_equations

        home = state_equations if name.endswith("_rate") else dynamics
        return getattr(coriolis if name == "coriolis_matrix" else home, name)(self.model)

    def _function(self, name: str, sizes: tuple[int, ...], shape: tuple[int, ...]) -> Any:
        module = native_module(name, self.model.key, lambda: self._program(name), self._cache)
        return native_function(module, sizes, shape)

    def _rate_jacobian(self, name: str, size: int) -> StateFunction:
        """Columns are directional derivatives along the axes of x, one batch for all."""

        def program() -> Any:
            from .equations.state_equations import rate_tangent

            return rate_tangent(self._program(name))

        n, units = self._n, np.eye(size)
        module = native_module(f"{name}_tangent", self.model.key, program, self._cache)
        along = native_function(module, (size, n, size), (size,))

        def function(x: ArrayLike, tau: ArrayLike, /, out: Array | None = None) -> Array:
            x, tau = real_array("x", x), real_array("tau", tau)
            if out is not None:
                check_out(out, (size, size))
            if x.shape != (size,) or tau.shape != (n,):
                given = f"got {x.shape} and {tau.shape}"
                raise ValueError(f"x must be ({size},) and tau ({n},), {given}")
            rows = along(np.tile(x, (size, 1)), np.tile(tau, (size, 1)), units)
            if out is None:
                return np.ascontiguousarray(rows.T)
            out[...] = rows.T
            return out

        return function


def compile_dynamics(model: InertialModel, *, cache: Path | str | None = None) -> CompiledDynamics:
    """Compiled dynamics of an inertial model of numbers; for the cache see `compile`."""
    return CompiledDynamics(model, cache)


class CompiledMeasurement:
    """Numeric measurement equations of one robot and IMU; see `compile_measurement`."""

    def __init__(
        self, robot: Robot, gravity: tuple[float, ...], frame: int | None, cache: Path | str | None
    ) -> None:
        refuse_symbols("compile_measurement", robot.name, robot.free_symbols)
        self.robot, self._imu, self._cache = robot, (gravity, frame), cache

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.robot, *self._imu, self._cache)

    @cached_property
    def reading(self) -> MotionFunction:
        """reading(phi, phi_dot, phi_ddot): y, shape (n + 6,): motor angles, gyro, accelerometer."""
        return self._function("measurement", (self.robot.n_joints + 6,))

    @cached_property
    def jacobian(self) -> MotionFunction:
        """jacobian(phi, phi_dot, phi_ddot): H = dy/d(phi, phi_dot, phi_ddot), (n + 6, 3 n)."""
        n = self.robot.n_joints
        return self._function("measurement_jacobian", (n + 6, 3 * n))

    def _function(self, name: str, shape: tuple[int, ...]) -> Any:
        def program() -> Any:
            from .equations import imu_equations

            return getattr(imu_equations, name)(self.robot, *self._imu)

        key = repr((self.robot.key, self._imu))
        module = native_module(name, key, program, self._cache)
        return native_function(module, (self.robot.n_joints,) * 3, shape)


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


if TYPE_CHECKING:
    from .equations.program import StraightLineProgram


def compile_frame_pose(
    robot: Robot, frame: int, *, cache: Path | str | None = None
) -> AngleFunction:
    """pose(phi): T_base_frame, shape (4, 4). Thesis (3.22).

    frame: 0 is the base, k the frame of the k-th link, constant links counted.

    Raises ValueError for another frame, or a symbolic parameter.
    """

    def program() -> "StraightLineProgram":
        from .equations.forward_kinematics import frame_pose

        return frame_pose(robot, frame)

    return _compiled(robot, f"frame_pose_{frame}", (4, 4), program, cache)


def compile_frame_jacobian(
    robot: Robot, frame: int, axes: int = 0, *, cache: Path | str | None = None
) -> AngleFunction:
    """jacobian(phi): shape (6, n), (v, omega) of the origin of a frame for motor rates.

    frame: 0 is the base, k the frame of the k-th link, constant links counted.
    axes: frame whose axes v and omega are in; the base's by default, the frame's own if equal.

    Raises ValueError for another frame, or a symbolic parameter.
    """

    def program() -> "StraightLineProgram":
        from .equations.forward_kinematics import frame_jacobian

        return frame_jacobian(robot, frame, axes)

    shape = (6, robot.n_joints)
    return _compiled(robot, f"frame_jacobian_{frame}_{axes}", shape, program, cache)


def _compiled(
    robot: Robot, name: str, shape: tuple[int, ...], program: Any, cache: Path | str | None
) -> AngleFunction:
    refuse_symbols("compile", robot.name, robot.free_symbols)
    module = native_module(name, robot.key, program, cache)
    return native_function(module, (robot.n_joints,), shape)
