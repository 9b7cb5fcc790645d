"""Robust maximum-a-posteriori fit of error parameters, targets and joint errors.

Residuals are 3-vectors: measured less predicted point [m], and rotation vector of measured against
predicted orientation [rad]. Each has the soft-L1 loss of its length, so that a wrong measurement
keeps a bounded pull and is not dropped. The Hessian is that of Gauss and Newton; it is summed over
blocks of configurations, so that memory does not grow with their number.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from armside.arrays import Array

from .error_model import AXES, ErrorModel
from .joint_errors import JointErrors
from .measurements import Measurements, Registration, register

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

BLOCK = 256
"""Configurations of which the Jacobian is held at once."""
ROBUST = 2.0
"""Residual, in standard deviations of the noise, at which the loss turns from square to linear."""
ROTATION_NOISE = 1e-3
"""[rad] ESTIMATE of the standard deviation of a measured orientation beside that of a point."""


@dataclass(frozen=True, kw_only=True)
class Priors:
    """Standard deviations about the nominal robot, before any measurement."""

    length: float = 5e-3
    """Of a, d [m]."""
    angle: float = 10e-3
    """Of theta, alpha, beta [rad]."""
    frame: float = 0.1
    """Of base, tool and targets [m, rad], about their registration with the nominal robot."""
    harmonic: float = 100e-6
    """Of one harmonic of a joint's error [rad]. Chosen on fifty poses of the first half of the
    UR10's series C, where 50 to 100 urad differ by a tenth."""
    compliance: float = 0.5e-3
    """Of one term's effect of gravity at the tool [m], root mean square."""
    noise: float | None = None
    """Of a coordinate of a measured point [m]; None estimates it from the residuals."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if value is not None and not (np.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} must be > 0, got {value}")


CONVERGED = 1e-2
"""Decrease of the negative logarithm of the posterior at which the search ends: what is left moves
no parameter by more than about a tenth of its standard deviation."""
FIRST_NOISE = 0.25e-3
"""[m] Noise that its estimation starts from."""
NOISE_ROUNDS = 3


class Choice(NamedTuple):
    """What is fitted beside base, targets and tool rotation."""

    geometry: tuple[str, ...] = ()
    """Names of error parameters of the links."""
    joint_errors: JointErrors = JointErrors()


@dataclass(frozen=True, eq=False)
class Problem:
    """A robot, what was measured of it in about the robot's own axes, and what is fitted."""

    model: ErrorModel
    data: Measurements
    """Moved into the base frame and tool rotation of the registration."""
    targets: Array
    """(T, 3) [m], of the registration."""
    columns: tuple[int, ...]
    """Error parameters that are fitted, base and tool included."""
    choice: Choice
    scale: Array
    """(P,) Prior standard deviations: errors, targets, joint errors."""
    functions: Array
    """(N, K) Functions of the joint errors at the configurations."""

    @property
    def names(self) -> list[str]:
        """Names of the fitted parameters."""
        targets = [f"target_{t}_{a}" for t in range(1, 1 + len(self.targets)) for a in AXES]
        errors = [self.model.names[i] for i in self.columns]
        return errors + targets + self.choice.joint_errors.names(self.model.robot)


class State(NamedTuple):
    """Parameters in their own units."""

    errors: Array
    """(E,) all error parameters of the model."""
    targets: Array
    """(T, 3)."""
    joint: Array
    """(K,) coefficients of the joint errors."""


def unpack(problem: Problem, x: Array) -> State:
    """State of scaled parameters x (P,)."""
    value = x * problem.scale
    n = len(problem.columns)
    m = n + problem.targets.size
    errors = np.zeros(len(problem.model.names))
    errors[list(problem.columns)] = value[:n]
    return State(errors, problem.targets + value[n:m].reshape(-1, 3), value[m:])


def _kinematics(
    model: ErrorModel, state: State, joint_errors: JointErrors, phi: Array, functions: Array
) -> tuple[Array, Array]:
    variables = model.variables(phi, state.errors)
    joints = model.joints[joint_errors.joints(model.robot)] if len(state.joint) else []
    for i in np.unique(joints).astype(int):
        own = joints == i
        variables[:, i] += functions[:, own] @ state.joint[own]
    return model.kinematics(variables)


def residuals_and_jacobian(problem: Problem, x: Array, rows: slice) -> tuple[Array, Array]:
    """Residuals (n, V, 3) of V vectors for each configuration, and their negative Jacobian.

    Vectors are the T points and, if it was measured, the orientation in units of a point's noise;
    the Jacobian has shape (n, V, 3, P), in units of the priors.
    """
    from scipy.spatial.transform import Rotation

    model, data, choice = problem.model, problem.data, problem.choice
    state, phi = unpack(problem, x), data.phi[rows]
    functions = problem.functions[rows]
    T, J = _kinematics(model, state, choice.joint_errors, phi, functions)
    R, p = T[:, :3, :3], T[:, :3, 3]
    v, w = np.swapaxes(J[:, :3], 1, 2), np.swapaxes(J[:, 3:], 1, 2)  # (n, E, 3)
    levers = np.einsum("nij,tj->nti", R, state.targets)
    r: Array = data.points[rows] - p[:, None] - levers
    by_error = v[:, None] + np.cross(w[:, None], levers[:, :, None])  # (n, T, E, 3)
    if data.rotation is not None:
        turned = data.rotation[rows] @ np.swapaxes(R, 1, 2)
        ratio = FIRST_NOISE / ROTATION_NOISE
        turn = np.asarray(Rotation.from_matrix(turned).as_rotvec())
        r = np.concatenate([r, ratio * turn[:, None]], axis=1)
        by_error = np.concatenate([by_error, ratio * w[:, None]], axis=1)
    by_target = np.zeros((*r.shape, len(state.targets), 3))
    for t in range(len(state.targets)):
        by_target[:, t, :, t] = R
    parts: list[Any] = [np.swapaxes(by_error[:, :, list(problem.columns)], 2, 3)]
    parts.append(by_target.reshape(*r.shape, -1))
    if len(state.joint):
        own = model.joints[choice.joint_errors.joints(model.robot)]
        moved: Any = np.swapaxes(by_error[:, :, own], 2, 3)
        parts.append(moved * functions[:, None, None])
    return r, np.asarray(np.concatenate(parts, axis=3) * problem.scale)


class Normal(NamedTuple):
    """Cost of the posterior, its gradient, and the Hessian of the data and of all."""

    cost: float
    gradient: Array
    hessian: Array
    lengths: Array
    """(N, V) lengths of the residuals; NaN where nothing was seen."""


def normal_equations(problem: Problem, x: Array, noise: float) -> Normal:
    """Negative logarithm of the posterior and its derivatives at scaled parameters x."""
    cost, gradient, hessian = 0.5 * float(x @ x), x.copy(), np.eye(len(x))
    lengths = []
    for first in range(0, len(problem.data), BLOCK):
        r, J = residuals_and_jacobian(problem, x, slice(first, first + BLOCK))
        length = np.linalg.norm(r, axis=2)
        lengths.append(length)
        seen = np.isfinite(length)
        r, J, s = r[seen], J[seen], (length[seen] / (ROBUST * noise)) ** 2
        cost += float(ROBUST**2 * (np.sqrt(1.0 + s) - 1.0).sum())
        root = np.sqrt(1.0 + s)
        flat = J.reshape(-1, len(x))
        gradient -= flat.T @ (r / (root * noise**2)[:, None]).ravel()
        # Square roots (n, 3, 3) of the loss's curvature over its slope: 1 across r, less along it.
        unit = r / np.maximum(np.linalg.norm(r, axis=1), np.finfo(float).tiny)[:, None]
        along = (1.0 / root - 1.0)[:, None, None] * (unit[:, :, None] * unit[:, None])
        curved = (np.eye(3) + along) / (np.sqrt(root) * noise)[:, None, None]
        flat = (curved @ J).reshape(-1, len(x))
        hessian += flat.T @ flat
    return Normal(cost, gradient, hessian, np.concatenate(lengths))


@dataclass(frozen=True, eq=False)
class Fit:
    """Result of a fit."""

    problem: Problem
    registration: Registration
    x: Array
    noise: float
    """Standard deviation of a coordinate [m], given or estimated."""
    covariance: Array
    """(P, P) of x."""
    lengths: Array
    """(N, V) lengths of the residuals [m]."""

    @property
    def state(self) -> State:
        """Parameters in their own units."""
        return unpack(self.problem, self.x)

    @property
    def standard_deviations(self) -> Array:
        """(P,) in the units of the parameters."""
        return np.sqrt(np.diag(self.covariance)) * self.problem.scale

    def residuals(self, data: Measurements) -> Array:
        """Measured less predicted points (N, T, 3) [m], in the axes of the robot's base."""
        model, errors, state = self.problem.model, self.problem.choice.joint_errors, self.state
        own = in_base(self.registration, data)
        T, _ = _kinematics(model, state, errors, own.phi, errors.values(model.robot, own.phi))
        points = T[:, None, :3, 3] + np.einsum("nij,tj->nti", T[:, :3, :3], state.targets)
        return own.points - points


def in_base(registration: Registration, data: Measurements) -> Measurements:
    """Measurements in the base frame and with the tool rotation of a registration."""
    R, p = registration.R.T, -registration.R.T @ registration.p
    own = data.moved(R, p)
    if own.rotation is None:
        return own
    return replace(own, rotation=own.rotation @ registration.R_tool.T)


def fit(
    model: ErrorModel,
    data: Measurements,
    choice: Choice,
    priors: Priors = Priors(),
    start: Fit | None = None,
) -> Fit:
    """Fit of base, targets and the chosen errors to measurements.

    start: fit of the same measurements and geometry with fewer joint errors, to start from.
    """
    registration = register(model.nominal_pose(data.phi), data)
    problem = make_problem(model, registration, in_base(registration, data), choice, priors)
    x, noise = np.zeros(len(problem.scale)), priors.noise or FIRST_NOISE
    if start is not None:
        x[: len(start.x)] = start.x
    x = _minimum(problem, x, noise)
    for _ in range(0 if priors.noise else NOISE_ROUNDS):
        before, noise = noise, _noise(problem, x, noise)
        x = _minimum(problem, x, noise)
        if abs(noise / before - 1.0) < 0.05:
            break
    normal = normal_equations(problem, x, noise)
    covariance = np.asarray(np.linalg.inv(normal.hessian), dtype=np.float64)
    return Fit(problem, registration, x, noise, covariance, normal.lengths)


def _minimum(problem: Problem, x: Array, noise: float) -> Array:
    from scipy.optimize import minimize

    @lru_cache(maxsize=1)  # cost, gradient and Hessian come from one pass
    def normal(content: bytes) -> Normal:
        return normal_equations(problem, np.frombuffer(content), noise)

    last = np.inf

    def ended(intermediate_result: "OptimizeResult") -> None:
        nonlocal last
        before, last = last, float(intermediate_result.fun)
        if 0.0 < before - last < CONVERGED:
            raise StopIteration

    found = minimize(
        lambda x: normal(x.tobytes())[:2],
        x,
        jac=True,
        hess=lambda x: normal(x.tobytes()).hessian,
        method="trust-exact",
        callback=ended,
        options={"initial_trust_radius": 1.0, "max_trust_radius": 1e4, "gtol": CONVERGED},
    )
    return found.x


def _noise(problem: Problem, x: Array, noise: float) -> float:
    """Robust standard deviation of a coordinate, corrected for the parameters that were fitted."""
    normal = normal_equations(problem, x, noise)
    seen = normal.lengths[np.isfinite(normal.lengths)]
    effective = len(x) - np.trace(np.linalg.inv(normal.hessian))
    freedom = max(1.0 - effective / (3 * seen.size), 0.1)
    return float(np.median(seen) / MEDIAN_LENGTH / np.sqrt(freedom))


MEDIAN_LENGTH = 1.5382
"""Median of the length of a vector of three standard normal numbers (chi, 3 degrees)."""


def make_problem(
    model: ErrorModel, registration: Registration, data: Measurements, choice: Choice, p: Priors
) -> Problem:
    """Problem of a choice, with prior standard deviations in the parameters' own units."""
    base = [n for n in model.names if n.startswith("base_")]
    tool = [n for n in model.names if n.startswith("tool_") and data.rotation is not None]
    names = [*base, *choice.geometry, *tool]
    is_length = dict(model.parameters)
    links = [p.length if is_length[name] else p.angle for name in choice.geometry]
    errors = [p.frame] * len(base) + links + [p.frame] * len(tool)
    functions = choice.joint_errors.values(model.robot, data.phi)
    joint = _joint_scale(model, data.phi, registration, choice.joint_errors, functions, p)
    scale = np.array([*errors, *[p.frame] * registration.targets.size, *joint])
    columns = tuple(model.index(name) for name in names)
    return Problem(model, data, registration.targets, columns, choice, scale, functions)


def _joint_scale(
    model: ErrorModel,
    phi: Array,
    registration: Registration,
    errors: JointErrors,
    functions: Array,
    p: Priors,
) -> Array:
    """Prior standard deviation of each coefficient; that of gravity by its effect at the tool."""
    names = errors.names(model.robot)
    sag = np.array([" sag " in name for name in names], dtype=bool)
    scale = np.full(len(names), p.harmonic)
    if not sag.any():
        return scale
    state = State(np.zeros(len(model.names)), registration.targets, np.zeros(len(names)))
    T, J = _kinematics(model, state, errors, phi, functions)
    lever = np.einsum("nij,j->ni", T[:, :3, :3], registration.targets[0])
    own = model.joints[errors.joints(model.robot)][sag]
    column = J[:, :3] + np.cross(J[:, 3:], lever[:, :, None], axis=1)
    effect = np.linalg.norm(column[:, :, own], axis=1) * functions[:, sag]
    rms = np.sqrt((effect**2).mean(axis=0))
    # A torque about a vertical axis is zero, and its coefficient stays so.
    scale[sag] = np.where(rms > 1e-9, p.compliance / np.maximum(rms, 1e-9), 0.0)
    return scale


def jacobian_of_points(fit: Fit, phi: Array) -> Array:
    """Derivative of the first target by the scaled parameters, (N, 3, P), negative, base axes."""
    problem = replace(
        fit.problem,
        data=Measurements(phi=phi, points=np.zeros((len(phi), len(fit.problem.targets), 3))),
        functions=fit.problem.choice.joint_errors.values(fit.problem.model.robot, phi),
    )
    return residuals_and_jacobian(problem, fit.x, slice(0, len(phi)))[1][:, 0]
