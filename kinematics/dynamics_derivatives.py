"""Compiled derivatives of inverse dynamics, by directional derivatives along all inputs at once."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from .arguments import check_out, real_array
from .compiled import MotionFunction, refuse_symbols
from .equations.inertial_model import InertialModel
from .native_function import native_function, native_module

if TYPE_CHECKING:
    from .equations.program import StraightLineProgram


def compile_inverse_dynamics_jacobian(
    model: InertialModel, *, cache: Path | str | None = None
) -> MotionFunction:
    """jacobian(phi, phi_dot, phi_ddot): shape (n, 3 n), derivatives of the motor torques.

    Its blocks are d tau / d phi, d tau / d phi_dot and d tau / d phi_ddot; the last is the mass
    matrix D. Coulomb friction has the derivative 0. Thesis (2.15).
    """
    refuse_symbols("compile", model.robot.name, model.free_symbols)
    n = model.robot.n_joints
    module = native_module(
        "inverse_dynamics_tangent", model.key, lambda: torque_tangent(model), cache
    )
    along, units = native_function(module, (3 * n, 3 * n), (n,)), np.eye(3 * n)

    def jacobian(
        phi: ArrayLike, phi_dot: ArrayLike, third: ArrayLike, /, out: Array | None = None
    ) -> Array:
        parts = [real_array("arguments", part) for part in (phi, phi_dot, third)]
        if any(part.shape != (n,) for part in parts):
            given = ", ".join(str(part.shape) for part in parts)
            raise ValueError(f"arguments must have shapes ({n},), ({n},), ({n},); got {given}")
        if out is not None:
            check_out(out, (n, 3 * n))
        rows = along(np.tile(np.concatenate(parts), (3 * n, 1)), units)
        if out is None:
            return np.ascontiguousarray(rows.T)
        out[...] = rows.T
        return out

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
