"""What a person wants to know of a robot: its table, zero pose, reach and singularities."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from sympy.printing.latex import LatexPrinter
from sympy.printing.str import StrPrinter

from armside.arrays import Array

from ..dh import Robot
from ..equations.chain import exact_parameters
from ..expressions.exact import Expression, SymbolicMatrix
from ..expressions.symbols import symbol
from ..inverse.wrist_arm import UnsolvableGeometryError, wrist_arm
from .procedures import at, matrix_t
from .singularity import SingularConditions, conditions


@dataclass(frozen=True)
class ModelReport:
    """A robot described."""

    robot: Robot
    table: tuple[tuple[Expression, ...], ...]
    """theta, d, a, alpha of each link, joint variables as motor angles. Thesis Table 4.2."""
    zero_pose: SymbolicMatrix
    """T_base_tool at phi = 0."""
    reach: tuple[float, float] | None
    """Least and greatest distance of the wrist centre from axis 2 [m]; None for other arms."""
    singularities: SingularConditions | None


def describe(robot: Robot) -> ModelReport:
    """All of it, exact where the robot's numbers are."""
    phi = [symbol("phi", i) for i in range(1, robot.n_joints + 1)]
    table = tuple(exact_parameters(link) for link in at(robot, phi).links)
    try:
        reach, found = wrist_arm(robot).reach, conditions(robot)
    except UnsolvableGeometryError:
        reach, found = None, None
    return ModelReport(robot, table, matrix_t(robot)[-1], reach, found)


class _DecimalText(StrPrinter):
    def _print_Rational(self, expr: sp.Rational) -> str:
        return repr(float(expr))


class _DecimalLatex(LatexPrinter):
    def _print_Rational(self, expr: sp.Rational) -> str:
        return str(expr.p) if expr.is_Integer else repr(float(expr))


def as_text(value: Any) -> str:
    """An expression with decimal lengths and fractions of pi: phi_2 - pi/2, 0.475."""
    return _DecimalText().doprint(value)


def as_latex(report: ModelReport) -> str:
    """The table and the zero pose for a paper."""
    show = _DecimalLatex().doprint
    lines = [
        "\\begin{tabular}{rllll}",
        "  link & $\\theta_i$ [rad] & $d_i$ [m] & $a_i$ [m] & $\\alpha_i$ [rad] \\\\ \\hline",
    ]
    for number, row in enumerate(report.table, 1):
        lines.append(f"  {number} & {' & '.join(f'${show(v)}$' for v in row)} \\\\")
    return "\n".join(
        [*lines, "\\end{tabular}", "", f"\\[ T_0^n(0) = {show(report.zero_pose)} \\]", ""]
    )


def frame_positions(robot: Robot, phi: Array | None = None) -> tuple[Array, Array]:
    """Origins (m, 3) and rotations (m, 3, 3) of all frames, base first, at phi (zero by default).

    Thesis Fig 3.1, 5.3.
    """
    angles = np.zeros(robot.n_joints) if phi is None else np.asarray(phi, dtype=np.float64)
    exact = [sp.Rational(repr(float(a))) for a in angles]
    T = [np.array(M.evalf(), dtype=np.float64) for M in matrix_t(at(robot, exact))]
    stacked = np.stack(T)
    return stacked[:, :3, 3], stacked[:, :3, :3]
