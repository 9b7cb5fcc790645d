"""A robot of numbers as compiled functions of its motor angles."""

from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import native
from .dh import Robot

Array = NDArray[np.float64]


class OfAngles(Protocol):
    """A function of motor angles; a batch of N has a leading axis in arguments and result."""

    def __call__(self, phi: ArrayLike, /, out: Array | None = None) -> Array: ...


class OfMotion(Protocol):
    """A function of motor angles, their rates and accelerations."""

    def __call__(
        self,
        phi: ArrayLike,
        phi_dot: ArrayLike,
        phi_ddot: ArrayLike,
        /,
        out: Array | None = None,
    ) -> Array: ...


class CompiledRobot:
    """Numeric kinematics of one robot; see `compile`. Each function is built on first use.

    Functions accept anything array-like; C-contiguous float64 arrays take the short way. They
    return `out` when it is given, else a new array.
    """

    def __init__(self, robot: Robot, cache: Path | None = None) -> None:
        if robot.free_symbols:
            names = ", ".join(sorted(map(str, robot.free_symbols)))
            raise ValueError(f"compile needs a robot of numbers; {robot.name} has symbols: {names}")
        self.robot = robot
        self._cache = cache

    @cached_property
    def pose(self) -> OfAngles:
        """pose(phi): T_base_tool, shape (4, 4). Thesis (3.26)."""
        return self._of_angles("pose", (4, 4))

    @cached_property
    def jacobian(self) -> OfAngles:
        """jacobian(phi): shape (6, n), (v, omega) of the tool origin in base axes for motor rates.

        Thesis (3.39), with (4.10): J_phi = J_theta coupling.
        """
        return self._of_angles("jacobian", (6, self.robot.n_joints))

    @cached_property
    def acceleration(self) -> OfMotion:
        """acceleration(phi, phi_dot, phi_ddot): shape (6,), classical (v_dot, omega_dot) of the
        tool origin in base axes, without gravity. Thesis (3.57).
        """
        n = self.robot.n_joints
        return _of_motion(self._module("acceleration"), n, (6,))

    def _of_angles(self, name: str, shape: tuple[int, ...]) -> OfAngles:
        return _of_angles(self._module(name), self.robot.n_joints, shape)

    def _module(self, program: str) -> Any:
        def source() -> str:
            from . import motion
            from .codegen import numba_module

            return numba_module(getattr(motion, program)(self.robot))

        return native.load(program, self.robot.key, source, self._cache)


def compile(robot: Robot, *, cache: Path | str | None = None) -> CompiledRobot:
    """Compiled pose, Jacobian and acceleration of a robot.

    Args:
        robot: all D-H parameters must be numbers.
        cache: folder for generated code; the platform's cache folder by default.

    Raises:
        ValueError: a D-H parameter is symbolic.
    """
    return CompiledRobot(robot, None if cache is None else Path(cache))


def _of_angles(module: Any, n: int, shape: tuple[int, ...]) -> OfAngles:
    one, empty, slow = module.one, np.empty, _slow(module, n, shape)

    def function(phi: Any, /, out: Array | None = None) -> Array:
        try:
            if phi.ndim == 1:
                result = empty(shape) if out is None else out
                one(phi, result)
                return result
        except (AttributeError, TypeError, ValueError):
            pass
        return slow(out, phi)

    return function


def _of_motion(module: Any, n: int, shape: tuple[int, ...]) -> OfMotion:
    one, empty, slow = module.one, np.empty, _slow(module, n, shape)

    def function(phi: Any, phi_dot: Any, phi_ddot: Any, /, out: Array | None = None) -> Array:
        try:
            if phi.ndim == 1:
                result = empty(shape) if out is None else out
                one(phi, phi_dot, phi_ddot, result)
                return result
        except (AttributeError, TypeError, ValueError):
            pass
        return slow(out, phi, phi_dot, phi_ddot)

    return function


def _slow(module: Any, n: int, shape: tuple[int, ...]) -> Callable[..., Array]:
    """The way for batches, for array-likes, and for everything that deserves an error message."""

    def function(out: Array | None, *arguments: ArrayLike) -> Array:
        # Compiled code takes writeable arrays only; those of a record are not.
        arrays = [np.require(a, np.float64, ["C", "W"]) for a in arguments]
        for array in arrays:
            if array.ndim not in (1, 2) or array.shape[-1] != n or array.shape != arrays[0].shape:
                shapes = ", ".join(str(a.shape) for a in arrays)
                raise ValueError(f"arguments must all be ({n},) or (N, {n}); got {shapes}")
        expected = (*arrays[0].shape[:-1], *shape)
        if out is not None and (out.shape != expected or out.dtype != np.float64):
            raise ValueError(
                f"out must be float64 of shape {expected}, got {out.dtype} of {out.shape}"
            )
        direct = out is not None and out.flags.c_contiguous and out.flags.writeable
        result = out if direct else np.empty(expected)
        (module.one if arrays[0].ndim == 1 else module.many)(*arrays, result)
        if out is None or direct:
            return result
        out[...] = result
        return out

    return function
