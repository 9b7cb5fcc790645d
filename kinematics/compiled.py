"""A robot of numbers as compiled functions of its motor angles: kinematics and dynamics."""

from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from . import cache as native
from .binding import bind
from .dh import Robot
from .equations.inertial_model import RobotModel

if TYPE_CHECKING:
    from .equations.program import Program


class OfAngles(Protocol):
    """A function of motor angles; a batch of N has a leading axis in arguments and result."""

    def __call__(self, phi: ArrayLike, /, out: Array | None = None) -> Array: ...


class OfRates(Protocol):
    """A function of motor angles and their rates."""

    def __call__(
        self, phi: ArrayLike, phi_dot: ArrayLike, /, out: Array | None = None
    ) -> Array: ...


class OfState(Protocol):
    """A function of a state x and motor torques tau."""

    def __call__(self, x: ArrayLike, tau: ArrayLike, /, out: Array | None = None) -> Array: ...


class OfMotion(Protocol):
    """A function of motor angles, their rates, and accelerations or torques."""

    def __call__(
        self,
        phi: ArrayLike,
        phi_dot: ArrayLike,
        third: ArrayLike,
        /,
        out: Array | None = None,
    ) -> Array: ...


class CompiledRobot:
    """Numeric kinematics of one robot; see `compile`. Each function is built on first use.

    Functions accept anything array-like; C-contiguous float64 arrays take the short way. They
    return `out` when it is given, else a new array.
    """

    def __init__(self, robot: Robot, cache: Path | None = None) -> None:
        _refuse_symbols("compile", robot.name, robot.free_symbols)
        self.robot = robot
        self._cache = cache

    def __reduce__(self) -> tuple[Any, ...]:
        """Another process gets the robot and loads its functions from the cache folder."""
        return type(self), (self.robot, self._cache)

    @cached_property
    def pose(self) -> OfAngles:
        """pose(phi): T_base_tool, shape (4, 4). Thesis (3.26)."""
        return self._function("pose", 1, (4, 4))

    @cached_property
    def jacobian(self) -> OfAngles:
        """jacobian(phi): shape (6, n), (v, omega) of the tool origin in base axes for motor rates.

        Thesis (3.39), with (4.10): J_phi = J_theta coupling.
        """
        return self._function("jacobian", 1, (6, self.robot.n_joints))

    @cached_property
    def jacobian_rate(self) -> OfRates:
        """jacobian_rate(phi, phi_dot): shape (6, n), dJ/dt. Thesis (4.5)."""
        return self._function("jacobian_rate", 2, (6, self.robot.n_joints))

    @cached_property
    def acceleration(self) -> OfMotion:
        """acceleration(phi, phi_dot, phi_ddot): shape (6,), classical (v_dot, omega_dot) of the
        tool origin in base axes, without gravity. Thesis (3.57).
        """
        return self._function("acceleration", 3, (6,))

    def _function(self, name: str, arguments: int, shape: tuple[int, ...]) -> Any:
        def source() -> str:
            from .codegen import numba_module
            from .equations import forward_kinematics as motion

            return numba_module(getattr(motion, name)(self.robot))

        module = native.load(name, self.robot.key, source, self._cache)
        return bind(module, (self.robot.n_joints,) * arguments, shape)


def compile(robot: Robot, *, cache: Path | str | None = None) -> CompiledRobot:
    """Compiled pose, Jacobian and acceleration of a robot.

    Args:
        robot: all D-H parameters must be numbers.
        cache: folder for generated code; the platform's cache folder by default.

    Raises:
        ValueError: a D-H parameter is symbolic.
    """
    return CompiledRobot(robot, None if cache is None else Path(cache))


class CompiledModel:
    """Numeric dynamics of one robot model; see `compile_dynamics`. Built on first use.

    Torques are those of the motors on the arm side of the gear. Thesis (2.15).
    """

    def __init__(self, model: RobotModel, cache: Path | None = None) -> None:
        _refuse_symbols("compile_dynamics", model.robot.name, model.free_symbols)
        self.model = model
        self._cache = cache

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.model, self._cache)

    @cached_property
    def mass_matrix(self) -> OfAngles:
        """mass_matrix(phi): D, shape (n, n), rotor inertia included."""
        n = self.model.robot.n_joints
        return self._function("mass_matrix", 1, (n, n))

    @cached_property
    def gravity_torque(self) -> OfAngles:
        """gravity_torque(phi): g, shape (n,)."""
        return self._function("gravity_torque", 1)

    @cached_property
    def bias_torque(self) -> OfRates:
        """bias_torque(phi, phi_dot): C phi_dot + g + f, shape (n,)."""
        return self._function("bias_torque", 2)

    @cached_property
    def coriolis_matrix(self) -> OfRates:
        """coriolis_matrix(phi, phi_dot): C, shape (n, n), with dD/dt - 2 C skew. Thesis (2.16)."""
        n = self.model.robot.n_joints
        return self._function("coriolis_matrix", 2, (n, n))

    @cached_property
    def inverse_dynamics(self) -> OfMotion:
        """inverse_dynamics(phi, phi_dot, phi_ddot): tau, shape (n,), friction included."""
        return self._function("inverse_dynamics", 3)

    @cached_property
    def forward_dynamics(self) -> OfMotion:
        """forward_dynamics(phi, phi_dot, tau): phi_ddot, shape (n,)."""
        return self._function("forward_dynamics", 3)

    @cached_property
    def rigid_rate(self) -> OfState:
        """rigid_rate(x, tau): x', x = (phi, phi_dot), shape (2 n,)."""
        return self._rate("rigid_rate", 2)

    @cached_property
    def flexible_rate(self) -> OfState:
        """flexible_rate(x, tau): x', x = (phi_arm, phi_motor, rates), shape (4 n,). K12."""
        return self._rate("flexible_rate", 4)

    @cached_property
    def rigid_rate_jacobian(self) -> OfState:
        """rigid_rate_jacobian(x, tau): dx'/dx, shape (2 n, 2 n)."""
        return self._rate_jacobian("rigid_rate", 2)

    @cached_property
    def flexible_rate_jacobian(self) -> OfState:
        """flexible_rate_jacobian(x, tau): dx'/dx, shape (4 n, 4 n)."""
        return self._rate_jacobian("flexible_rate", 4)

    def _function(self, name: str, arguments: int, shape: tuple[int, ...] = ()) -> Any:
        def program() -> "Program":
            from .equations import coriolis, dynamics

            home = coriolis if name == "coriolis_matrix" else dynamics
            return getattr(home, name)(self.model)

        n = self.model.robot.n_joints
        return bind(self._module(name, program), (n,) * arguments, shape or (n,))

    def _rate(self, name: str, orders: int) -> Any:
        def program() -> "Program":
            from .equations import state_equations as process

            return getattr(process, name)(self.model)

        n = self.model.robot.n_joints
        return bind(self._module(name, program), (orders * n, n), (orders * n,))

    def _rate_jacobian(self, name: str, orders: int) -> OfState:
        """Columns are directional derivatives along the axes of x, one batch for all."""

        def program() -> "Program":
            from .equations import state_equations as process

            return process.rate_tangent(getattr(process, name)(self.model))

        size, n = orders * self.model.robot.n_joints, self.model.robot.n_joints
        along = bind(self._module(f"{name}_tangent", program), (size, n, size), (size,))
        units = np.eye(size)

        def function(x: ArrayLike, tau: ArrayLike, /, out: Array | None = None) -> Array:
            x, tau = np.asarray(x, dtype=np.float64), np.asarray(tau, dtype=np.float64)
            if x.shape != (size,) or tau.shape != (n,):
                raise ValueError(
                    f"x must be ({size},) and tau ({n},), got {x.shape} and {tau.shape}"
                )
            rows = along(np.tile(x, (size, 1)), np.tile(tau, (size, 1)), units)
            if out is None:
                return np.ascontiguousarray(rows.T)
            out[...] = rows.T
            return out

        return function

    def _module(self, name: str, program: "Callable[[], Program]") -> Any:
        def source() -> str:
            from .codegen import numba_module

            return numba_module(program())

        return native.load(name, self.model.key, source, self._cache)


def compile_dynamics(model: RobotModel, *, cache: Path | str | None = None) -> CompiledModel:
    """Compiled dynamics of a robot model, all of whose parameters must be numbers.

    Args:
        cache: folder for generated code; the platform's cache folder by default.
    """
    return CompiledModel(model, None if cache is None else Path(cache))


class CompiledSensor:
    """Numeric measurement equations of one robot and sensor; see `compile_measurement`."""

    def __init__(
        self, robot: Robot, gravity: tuple[float, ...], frame: int | None, cache: Path | None
    ) -> None:
        _refuse_symbols("compile_measurement", robot.name, robot.free_symbols)
        self.robot = robot
        self._place = (gravity, frame)
        self._cache = cache

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.robot, *self._place, self._cache)

    @cached_property
    def reading(self) -> OfMotion:
        """reading(phi, phi_dot, phi_ddot): y, shape (n + 6,): motor angles, gyro, accelerometer."""
        return self._function("measurement", (self.robot.n_joints + 6,))

    @cached_property
    def jacobian(self) -> OfMotion:
        """jacobian(phi, phi_dot, phi_ddot): H = dy/d(phi, phi_dot, phi_ddot), (n + 6, 3 n)."""
        n = self.robot.n_joints
        return self._function("measurement_jacobian", (n + 6, 3 * n))

    def _function(self, name: str, shape: tuple[int, ...]) -> Any:
        def source() -> str:
            from .codegen import numba_module
            from .equations import imu_equations as measurement

            return numba_module(getattr(measurement, name)(self.robot, *self._place))

        key = repr((self.robot.key, self._place))
        module = native.load(name, key, source, self._cache)
        return bind(module, (self.robot.n_joints,) * 3, shape)


def compile_measurement(
    robot: Robot,
    gravity: Sequence[float] = (0.0, 0.0, -9.82),
    frame: int | None = None,
    *,
    cache: Path | str | None = None,
) -> CompiledSensor:
    """Compiled equations of the encoders and of an IMU at a frame of the robot. Row F01.

    Args:
        gravity: [m/s^2] in base axes.
        frame: the IMU sits in this link's frame; the last one by default.
        cache: folder for generated code; the platform's cache folder by default.
    """
    place = tuple(float(value) for value in gravity)
    return CompiledSensor(robot, place, frame, None if cache is None else Path(cache))


def _refuse_symbols(function: str, name: str, symbols: frozenset[Any]) -> None:
    if symbols:
        names = ", ".join(sorted(map(str, symbols)))
        raise ValueError(f"{function} needs a robot of numbers; {name} has symbols: {names}")
