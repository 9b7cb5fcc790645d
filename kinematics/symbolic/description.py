"""Description of a robot: its D-H table, zero pose, reach and singularities. Thesis 3.4.4."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike
from sympy.printing.latex import LatexPrinter
from sympy.printing.str import StrPrinter

from armside.arrays import Array, real_array

from ..dh import Link, Robot
from ..equations.chain import exact_parameters
from ..expressions.symbols import Expression, SymbolicMatrix, exact, symbol
from ..inverse.six_axes import UnsolvableGeometryError, wrist_arm
from ..rigid import standard_links
from .procedures import at, jacobian, matrix_t


@dataclass(frozen=True)
class SingularConditions:
    """Expressions of the D-H joint variables theta that vanish where the arm is singular.

    Elbow: stretched or folded; shoulder: wrist centre on axis 1; wrist: axes 4 and 6 aligned.
    """

    elbow: Expression
    shoulder: Expression
    wrist: Expression


def decoupled_determinant(robot: Robot) -> tuple[Expression, Expression]:
    """(arm, wrist) factors of det J_theta at the wrist centre, in theta_2, theta_3 and theta_5.

    A spherical wrist makes J block triangular there, so det J = det J_11 det J_22. The first does
    not depend on the angle of axis 1, nor the second on those of axes 4 and 6: they are taken as 0.
    Raises UnsolvableGeometryError for other arms.
    """
    wrist_arm(robot)
    theta = [sp.Symbol(f"theta_{i}", real=True) if i in (2, 3, 5) else 0 for i in range(1, 7)]
    six = [link for link in standard_links(robot) if link.moves]
    pairs = zip(theta, six, strict=True)
    links = [Link(angle, *exact_parameters(link)[1:], link.joint) for angle, link in pairs]
    links[5] = Link()  # the tool moved to the wrist centre
    J = jacobian(links)
    wrist_axes = matrix_t(links)[3][:3, :3].T * J[3:, 3:]
    determinants = J[:3, :3].det(), wrist_axes.applyfunc(sp.trigsimp).det()
    arm, wrist = (sp.factor(sp.trigsimp(each)) for each in determinants)
    return arm, wrist


def conditions(robot: Robot) -> SingularConditions:
    """The three singularities of an elbow arm with a spherical wrist, as factors."""
    arm, wrist = decoupled_determinant(robot)
    bend = {sp.Symbol("theta_3", real=True)}
    factors = [f for f in sp.Mul.make_args(arm) if f.free_symbols]
    return SingularConditions(
        elbow=sp.Mul(*(f for f in factors if f.free_symbols == bend)),
        shoulder=sp.Mul(*(f for f in factors if f.free_symbols != bend)),
        wrist=wrist,
    )


def manipulability(J: ArrayLike) -> Array:
    """sqrt(det(J J^T)) of Jacobians (..., 6, n): zero if J has rank < 6, as all with n < 6."""
    J = real_array("J", J)
    if J.shape[-1] < J.shape[-2]:
        return np.zeros(J.shape[:-2])
    return np.prod(np.linalg.svd(J, compute_uv=False), axis=-1)


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
        a2, forearm = wrist_arm(robot).geometry[4:6].tolist()
        reach, found = (abs(a2 - forearm), a2 + forearm), conditions(robot)
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
