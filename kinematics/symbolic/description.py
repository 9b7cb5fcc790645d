"""Description of a robot: its D-H table, zero pose, reach and singular configurations."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from sympy.printing.latex import LatexPrinter
from sympy.printing.str import StrPrinter

from armside.arrays import Array

from ..dh import Robot
from ..equations.chain import exact_parameters
from ..expressions.exact import Expression, SymbolicMatrix, exact
from ..expressions.symbols import symbol
from ..inverse.six_axes import UnsolvableGeometryError
from ..inverse.wrist_arm import wrist_arm
from .procedures import at, matrix_t
from .singularity import SingularConditions, conditions


@dataclass(frozen=True)
class RobotDescription:
    """D-H table, T_base_tool at phi = 0, reach and singularities, exact where the numbers are."""

    robot: Robot
    table: tuple[tuple[Expression, ...], ...]
    """theta, d, a, alpha of each link, joint variables as motor angles. Thesis Table 4.2."""
    zero_pose: SymbolicMatrix
    reach: tuple[float, float] | None
    """Least and greatest distance of the wrist centre from axis 2 [m]; None for other arms."""
    singularities: SingularConditions | None


def describe(robot: Robot) -> RobotDescription:
    """The description of a robot of numbers or symbols."""
    phi = [symbol("phi", i) for i in range(1, robot.n_joints + 1)]
    table = tuple(exact_parameters(link) for link in at(robot, phi).links)
    try:
        reach, found = wrist_arm(robot).reach, conditions(robot)
    except UnsolvableGeometryError:
        reach, found = None, None
    return RobotDescription(robot, table, matrix_t(robot)[-1], reach, found)


class _DecimalText(StrPrinter):
    def _print_Rational(self, expr: sp.Rational) -> str:
        return repr(float(expr))


class _DecimalLatex(LatexPrinter):
    def _print_Rational(self, expr: sp.Rational) -> str:
        return str(expr.p) if expr.is_Integer else repr(float(expr))


def as_text(value: Any) -> str:
    """An expression with decimal lengths and fractions of pi: phi_2 - pi/2, 0.475."""
    return _DecimalText().doprint(value)


def as_latex(description: RobotDescription) -> str:
    """The table and the zero pose as LaTeX."""
    show = _DecimalLatex().doprint
    lines = [
        "\\begin{tabular}{rllll}",
        "  link & $\\theta_i$ [rad] & $d_i$ [m] & $a_i$ [m] & $\\alpha_i$ [rad] \\\\ \\hline",
    ]
    for number, row in enumerate(description.table, 1):
        lines.append(f"  {number} & {' & '.join(f'${show(v)}$' for v in row)} \\\\")
    zero_pose = f"\\[ T_0^n(0) = {show(description.zero_pose)} \\]"
    return "\n".join([*lines, "\\end{tabular}", "", zero_pose, ""])


def frame_positions(robot: Robot, phi: Array | None = None) -> tuple[Array, Array]:
    """Origins (m, 3) and rotations (m, 3, 3) of all frames, base first. Thesis Fig 3.1, 5.3."""
    angles = np.zeros(robot.n_joints) if phi is None else np.asarray(phi, dtype=np.float64)
    frames = matrix_t(at(robot, [exact(float(angle)) for angle in angles]))
    T = np.stack([np.array(M.evalf(), dtype=np.float64) for M in frames])
    return T[:, :3, 3], T[:, :3, :3]
