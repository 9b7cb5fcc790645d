"""Dynamics linear in the inertial parameters, and its base parameters. Thesis (2.17).

Theta has ten numbers for each moving group of bodies: mass, first moment (3), inertia about the
body frame's origin (xx, xy, xz, yy, yz, zz). Columns of Y are torques of unit parameters.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from .equations.inertial_model import InertialModel
from .native_function import native_module

RANK = 1e-9
"""Columns of Y whose residual is below this fraction of the greatest column count as dependent."""


def inertial_parameters(model: InertialModel) -> Array:
    """Theta of a model of numbers, shape (10 n,)."""
    from .equations.recursion import body_chain

    segments = body_chain(model.robot, model.bodies).segments
    return np.array([float(e) for segment in segments for e in segment.inertia.elements])


def regressor(
    model: InertialModel,
    phi: ArrayLike,
    phi_dot: ArrayLike,
    phi_ddot: ArrayLike,
    *,
    cache: Path | str | None = None,
) -> Array:
    """Y with Y Theta = D phi'' + C phi' + g, rotor inertia and friction apart. Thesis (2.17).

    Shape (n, 10 n) for phi, phi_dot, phi_ddot of shape (n,), or (N, n, 10 n) for (N, n).
    """
    motion = [np.asarray(a, dtype=np.float64) for a in (phi, phi_dot, phi_ddot)]
    n = model.robot.n_joints
    shapes = {a.shape for a in motion}
    if len(shapes) > 1 or motion[0].ndim not in (1, 2) or motion[0].shape[-1] != n:
        raise ValueError(f"phi, phi_dot, phi_ddot must all be ({n},) or (N, {n}), got {shapes}")
    rows = [np.repeat(np.atleast_2d(a), 10 * n, axis=0) for a in motion]
    units = np.tile(np.eye(10 * n), (len(rows[0]) // (10 * n), 1))
    torques = np.empty((len(units), n))

    def program() -> Any:
        from .equations.dynamics import parametric_torque

        return parametric_torque(model)

    key = repr((model.robot.key, model.gravity))
    native_module("parametric_torque", key, program, cache).many(*rows, units, torques)
    Y = torques.reshape(-1, 10 * n, n).swapaxes(1, 2)
    return Y[0] if motion[0].ndim == 1 else Y


@dataclass(frozen=True)
class BaseParameters:
    """Identifiable combinations K Theta of the inertial parameters, Y[:, independent] K = Y.

    Independent columns span all of Y; the combination K has shape (r, 10 n).
    """

    independent: tuple[int, ...]
    combination: Array

    def values(self, theta: ArrayLike) -> Array:
        """Base parameters of a Theta, shape (r,)."""
        return self.combination @ np.asarray(theta, dtype=np.float64)


def base_parameters(
    model: InertialModel, rng: np.random.Generator, samples: int = 60
) -> BaseParameters:
    """Base parameters by the numeric rank of Y over random motions.

    Columns of Y are taken in order, without those that combine the columns before.
    """
    n = model.robot.n_joints
    motion = rng.uniform(-np.pi, np.pi, (3, samples, n))
    Y = regressor(model, *motion).reshape(-1, 10 * n)
    scale = np.linalg.norm(Y, axis=0)
    threshold = RANK * scale.max()
    independent: list[int] = []
    basis = np.empty((len(Y), 0))
    for column in range(10 * n):
        rest = Y[:, column] - basis @ (basis.T @ Y[:, column])
        rest -= basis @ (basis.T @ rest)
        if (length := np.linalg.norm(rest)) > threshold:
            basis = np.column_stack([basis, rest / length])
            independent.append(column)
    K = np.asarray(np.linalg.lstsq(Y[:, independent], Y, rcond=None)[0], dtype=np.float64)
    K[np.abs(K) < 1e-10] = 0.0
    return BaseParameters(tuple(independent), K)
