"""Calibration of an arm from measured poses: choice of parameters, fits, held-out error."""

from dataclasses import dataclass, field, replace
from math import pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..dh import Joint, Link, Robot
from ..rigid import standard_links
from ..robot_file import Arm
from .error_model import DH, ErrorModel
from .fit import Choice, Fit, Priors, fit
from .joint_errors import JointErrors
from .measurements import Measurements, split_by_pose, unique_poses
from .plausibility import Region, check, region
from .selection import Identifiable, identifiable


def corrected(model: ErrorModel, errors: Array) -> Robot:
    """The robot with its link errors (E,) put into its table; beta_i becomes two constant links."""
    value = dict(zip(model.names, errors.tolist(), strict=True))
    links: list[Link] = []
    for i, link in enumerate(standard_links(model.robot), 1):
        numbers = {name: float(getattr(link, name)) + value[f"{name}_{i}"] for name in DH}
        links.append(Link(**numbers, joint=link.joint))
        if beta := value[f"beta_{i}"]:
            # Rot_y(beta) = Rot_z(pi/2) Rot_x(beta) Rot_z(-pi/2)
            links.append(Link(theta=pi / 2, alpha=beta, joint=Joint.FIXED))
            links.append(Link(theta=-pi / 2, joint=Joint.FIXED))
    robot = model.robot
    return Robot(links, robot.coupling, robot.offset, name=f"{robot.name} calibrated")


TRIED = (0, 2, 40)
"""Orders up to which harmonics of each joint are tried, beside compliance."""
EXPLAINED = 0.5
"""Noise with joint errors over the residual of the geometry, which contains them. Chosen on the
first half of the UR10's series C; 0.4 to 1 differ by a tenth."""
VALIDATION = 0.2
"""Fraction of the fitted poses that the kind of joint errors is chosen on."""
OUTLYING = 5.0
"""Residual of a fit, relative to the median, from which a measurement is listed."""


@dataclass(frozen=True, kw_only=True)
class CalibrationCfg:
    """Choices of a calibration."""

    fraction: float = 0.5
    """Fraction of the poses that is fitted; the others are held out."""
    poses: int | None = None
    """Number of poses to fit, in place of the fraction."""
    in_order: bool = False
    """Fit the first poses and judge on the last; random otherwise."""
    parameters: tuple[str, ...] = ()
    """Error parameters of the links; empty takes all that can be identified."""
    joint_errors: JointErrors | None = None
    """Functions of the joint errors; None chooses them on a part of the fitted poses."""
    priors: Priors = field(default_factory=Priors)

    def __post_init__(self) -> None:
        if not 0.0 < self.fraction < 1.0:
            raise ValueError(f"fraction must be between 0 and 1, got {self.fraction:g}")
        if self.poses is not None and self.poses < 1:
            raise ValueError(f"poses must be >= 1, got {self.poses}")


class Errors(NamedTuple):
    """Lengths of the residuals of points [m]."""

    mean: float
    p95: float
    max: float


class Outlier(NamedTuple):
    """A measurement that no parameters explain; its loss is bounded, it is not dropped."""

    row: int
    target: int
    residual: float
    """[m]."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """Result of `calibrate`."""

    fitted: Measurements
    held_out: Measurements
    identifiable: Identifiable
    nominal: Fit
    """Base, tool and targets alone."""
    geometry: Fit
    full: Fit
    """Geometry and joint errors."""
    region: Region
    inside: NDArray[np.bool_]
    """(H,) held-out configurations in the region; outside of it `full` is that of the geometry."""

    def residuals(self, name: str) -> Array:
        """Lengths of the held-out residuals (H, T) [m] of nominal, geometry or full."""
        length = np.linalg.norm(getattr(self, name).residuals(self.held_out), axis=2)
        if name == "full":
            fallback = np.linalg.norm(self.geometry.residuals(self.held_out), axis=2)
            length = np.where(self.inside[:, None], length, fallback)
        return length

    def errors(self, name: str) -> Errors:
        """Held-out errors of nominal, geometry or full."""
        length = self.residuals(name)
        length = length[np.isfinite(length)]
        return Errors(float(length.mean()), float(np.quantile(length, 0.95)), float(length.max()))

    @property
    def robot(self) -> Robot:
        """Robot with the corrected table."""
        return corrected(self.geometry.problem.model, self.geometry.state.errors)

    @property
    def outliers(self) -> list[Outlier]:
        """Fitted measurements far off the full fit, the worst first."""
        length = self.full.lengths[:, : self.fitted.n_targets]
        far = np.argwhere(length > OUTLYING * np.nanmedian(length))
        rows = [Outlier(int(self.fitted.row[i]), int(t) + 1, float(length[i, t])) for i, t in far]
        return sorted(rows, key=lambda outlier: -outlier.residual)


@dataclass(frozen=True)
class Prepared:
    """A calibration whose measurements were checked and split, before any fit."""

    model: ErrorModel
    fitted: Measurements
    held_out: Measurements
    found: Identifiable
    cfg: CalibrationCfg
    rng: np.random.Generator


def calibrate(
    arm: Arm, data: Measurements, cfg: CalibrationCfg = CalibrationCfg(), *, seed: int = 0
) -> Calibration:
    """Calibrate an arm on a part of its measured poses, and judge on the others.

    Raises:
        ValueError: the measurements cannot be of this arm, or do not determine what is asked for.
    """
    return fit_prepared(prepare(arm, data, cfg, seed=seed))


def prepare(
    arm: Arm, data: Measurements, cfg: CalibrationCfg = CalibrationCfg(), *, seed: int = 0
) -> Prepared:
    """Check and split the measurements, and choose what they determine; raises as `calibrate`."""
    check(arm.robot, arm.limits, data)
    rng = np.random.default_rng(seed)
    n_unique = int(unique_poses(data.phi).max()) + 1
    fraction = cfg.fraction if cfg.poses is None else min(cfg.poses / n_unique, 0.99)
    own, others = split_by_pose(data.phi, fraction, None if cfg.in_order else rng)
    fitted, held_out = data[own], data[others]
    model = ErrorModel(arm.robot)
    found = identifiable(model, fitted, cfg.parameters)
    needed = found.chosen.rank
    if 3 * fitted.n_targets * len(fitted) <= needed:
        raise ValueError(f"too few poses: {len(fitted)} to fit for {needed} parameters")
    return Prepared(model, fitted, held_out, found, cfg, rng)


def fit_prepared(prepared: Prepared) -> Calibration:
    """Fit the parameters that were chosen, and judge on the poses that were held out."""
    model, fitted, cfg = prepared.model, prepared.fitted, prepared.cfg
    held_out, found = prepared.held_out, prepared.found
    nominal = fit(model, fitted, Choice(), cfg.priors)
    geometry = fit(model, fitted, Choice(found.geometry), cfg.priors)
    # Noise of fits with joint errors, by that of the geometry: their own would shrink to zero.
    priors = replace(cfg.priors, noise=cfg.priors.noise or EXPLAINED * geometry.noise)
    errors = cfg.joint_errors
    if errors is None:
        # Those that predict a part of the fitted poses best; no judged pose is used.
        inner, judge = split_by_pose(fitted.phi, 1.0 - VALIDATION, prepared.rng)
        tried = [JointErrors(), *(JointErrors(order, compliance=True) for order in TRIED)]

        def error(choice: JointErrors) -> float:
            one = fit(model, fitted[inner], Choice(found.geometry, choice), priors)
            return float(np.nanmean(np.linalg.norm(one.residuals(fitted[judge]), axis=2)))

        errors = min(tried, key=error)
    full = geometry
    if errors != JointErrors():
        full = fit(model, fitted, Choice(found.geometry, errors), priors, geometry)
    where = region(full, geometry)
    inside = where.contains(held_out.phi)
    return Calibration(fitted, held_out, found, nominal, geometry, full, where, inside)
