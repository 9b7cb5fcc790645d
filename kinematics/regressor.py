"""Dynamics linear in the inertial parameters, base parameters, and derivatives. Thesis (2.17).

Theta has ten numbers for each moving group of bodies: mass, first moment (3), inertia about the
body frame's origin (xx, xy, xz, yy, yz, zz). Columns of Y are torques of unit parameters.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array, check_out, real_array

from .cache import native_function
from .compiled import CompiledFunction, derivatives, refuse_symbols
from .equations.inertial_model import InertialModel

if TYPE_CHECKING:
    from .equations.program import StraightLineProgram

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

    def program() -> Any:
        from .equations.dynamics import parametric_torque

        return parametric_torque(model)

    key = repr((model.robot.key, model.gravity))
    sizes = (n, n, n, 10 * n)
    torques = native_function("parametric_torque", key, program, sizes, (n,), cache)(*rows, units)
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
    independent = independent_columns(Y, RANK * np.linalg.norm(Y, axis=0).max())
    K = np.asarray(np.linalg.lstsq(Y[:, independent], Y, rcond=None)[0], dtype=np.float64)
    K[np.abs(K) < 1e-10] = 0.0
    return BaseParameters(tuple(independent), K)


def independent_columns(A: Array, least: float) -> list[int]:
    """Columns of A (rows, m) of which more than a length is left by those before."""
    basis, chosen = np.empty((len(A), 0)), list[int]()
    for index, column in enumerate(A.T):
        rest = column - basis @ (basis.T @ column)
        rest -= basis @ (basis.T @ rest)  # a second pass keeps the basis orthogonal
        if (length := np.linalg.norm(rest)) > least:
            basis = np.column_stack([basis, rest / length])
            chosen.append(index)
    return chosen


def compile_inverse_dynamics_jacobian(
    model: InertialModel, *, cache: Path | str | None = None
) -> CompiledFunction:
    """jacobian(phi, phi_dot, phi_ddot): shape (n, 3 n), derivatives of the motor torques.

    Its blocks are d tau / d phi, d tau / d phi_dot and d tau / d phi_ddot; the last is the mass
    matrix D. Coulomb friction has the derivative 0. Thesis (2.15).
    """
    refuse_symbols("compile", model.robot.name, model.free_symbols)
    n = model.robot.n_joints
    along = native_function(
        "inverse_dynamics_tangent",
        model.key,
        lambda: torque_tangent(model),
        (3 * n, 3 * n),
        (n,),
        cache,
    )

    def jacobian(
        phi: ArrayLike, phi_dot: ArrayLike, third: ArrayLike, /, out: Array | None = None
    ) -> Array:
        parts = [real_array("arguments", part) for part in (phi, phi_dot, third)]
        if any(part.shape != (n,) for part in parts):
            given = ", ".join(str(part.shape) for part in parts)
            raise ValueError(f"arguments must have shapes ({n},), ({n},), ({n},); got {given}")
        if out is not None:
            check_out(out, (n, 3 * n))
        return derivatives(along, out, np.concatenate(parts))

    return jacobian


def torque_tangent(model: InertialModel) -> "StraightLineProgram":
    """Directional derivative of the torques at x = (phi, phi_dot, phi_ddot) along x_change."""
    from .equations.derivative import tangent
    from .equations.dynamics import inverse_dynamics
    from .equations.program import Argument

    program = inverse_dynamics(model)
    elements = tuple(e for argument in program.inputs[:3] for e in argument.elements)
    x = Argument("x", (len(elements),), elements)
    whole = replace(program, inputs=(x, *program.inputs[3:]))
    return replace(tangent(whole, {"x": "x_change"}), name="inverse_dynamics_tangent")
