"""Identification of the arm's springs from one run, by the innovations of the filter.

One run identifies a local, *effective* elasticity: gears and structure together as they act at
the tool in this pose. Inertia is taken from the nominal arm; only K / M shows in the motion.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.consistency import Whiteness, whiteness
from armside.ilc.estimation.kalman import SteadyStateFilter
from armside.ilc.estimation.prediction_error import ParameterEstimate, Whitened, estimate_parameters
from armside.ilc.filters import ZeroPhaseButterworth

from ..instruments.imu import ImuCfg, ImuSamples
from ..robot.servo import interpolate
from .arm_filter import ArmFilter, ProcessNoise, arm_filter
from .arm_springs import SpringPrior, Springs, arm_and_wrist, springs_at
from .linearised_arm import LinearisedArm, linearised
from .nominal import NominalArm
from .nonlinear_residual import NonlinearResidual, nonlinear_residual
from .observer import ENCODER_FILTER

if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline

REST = 0.2
"""At the beginning of a run in which the arm does not move yet [s]."""
SOFTEST = 0.4
"""Lowest mode over that of the assumed arm. Gears and structure in series give 0.6 to 0.8; below
lie springs that explain a record by the change of gravity sag along the cut. ESTIMATE."""
_STARTS = ((0.0, 0.0), (-0.3, -0.3), (-0.3, 0.0), (-0.7, -0.3), (-0.7, 0.3), (-1.1, 0.0))
"""Starts of log K of the axes before the wrist and of the wrist. A structure in series with the
gears of the first only softens them. The wrist is not searched beyond its prior, where wrong minima
lie."""


@dataclass(frozen=True, eq=False)
class Identified:
    """Identified springs, their uncertainty, and the whiteness of the innovations on them."""

    springs: Springs
    fit: ParameterEstimate
    names: tuple[str, ...]
    """Of the entries of fit.theta."""
    whiteness: Whiteness


@dataclass(frozen=True, eq=False)
class Run:
    """Measurements of one run, prepared for linear filters around rest."""

    time: Array
    """(N,) [s], of the motor log."""
    phi: Array
    """(N, n) [rad], outputs of the gears from rest: motor angles, low-passed, with the gear error
    that is known."""
    phi_dot: Array
    """(N, n) [rad/s]."""
    imu_time: Array
    """(K,) [s], the IMU's own clock."""
    reading: Array
    """(K, 6) [m/s^2], [rad/s]; rows of NaN are missing."""
    nonlinear: NonlinearResidual
    """Nonlinear residual along the motion, at first that of a rigid arm."""

    @property
    def period(self) -> float:
        return float(self.time[1] - self.time[0])


def prepared(arm: NominalArm, time: Array, motor_angle: Array, samples: ImuSamples) -> Run:
    """A run's log (N,), (N, n) and the IMU's samples; of the arm its springs do not matter."""
    period = float(time[1] - time[0])
    smooth = arm.gear_output(ZeroPhaseButterworth(ENCODER_FILTER, period)(motor_angle))
    phi, phi_dot, phi_ddot = interpolate(smooth, period, 1)
    linear, moved = linearised(arm, phi[0]), phi - phi[0]
    n = len(linear.axes)
    picked = np.zeros((n, linear.n_free))
    picked[range(n), linear.axes] = 1.0
    rigid = nonlinear_residual(arm, linear, *(a @ picked for a in (moved, phi_dot, phi_ddot)))
    reading = np.hstack((samples.acceleration, samples.angular_velocity))
    return Run(time, moved, phi_dot, samples.time, reading, rigid)


def with_nonlinear_residual(arm: NominalArm, model: ArmFilter, run: Run) -> Run:
    """The run with the nonlinear residual along a model's motion instead of a rigid arm's."""
    n = model.n_free
    states = model.simulated(run.phi, run.phi_dot, run.nonlinear, run.period)
    q, q_dot = states[:, :n], states[:, n : 2 * n]
    q_ddot = np.gradient(q_dot, run.period, axis=0)
    return replace(run, nonlinear=nonlinear_residual(arm, model.arm, q, q_dot, q_ddot))


def identify(
    arm: NominalArm,
    run: Run,
    rest: Array,
    imu: ImuCfg,
    *,
    prior: SpringPrior = SpringPrior(),
    process_noise: ProcessNoise = ProcessNoise(),
) -> Identified:
    """The springs that explain one run best.

    arm: nominal, the start of the search. rest: (n,) [rad], motor angles. imu: kind of unit, as its
    data sheet has it.

    Raises RuntimeError where no start leads to a minimum.
    """
    n = len(arm.axes)
    nominal, sd = linearised(arm, rest), prior.standard_deviation(arm)
    innovations = _Innovations(arm, nominal, run, imu, prior, process_noise)
    starts = [np.repeat((*k, 0.0), (*arm_and_wrist(n), sd.size - n)) for k in _STARTS]
    rigid = estimate_parameters(innovations, np.zeros(sd.size), sd, starts)
    springs = springs_at(arm, prior, rigid.theta, process_noise.fraction)
    elastic = nominal.on_springs(springs.stiffness, springs.damping)
    run = with_nonlinear_residual(arm, arm_filter(elastic, imu, process_noise), run)
    innovations = _Innovations(arm, nominal, run, imu, prior, process_noise)
    best = estimate_parameters(innovations, np.zeros(sd.size), sd, [rigid.theta])
    springs = springs_at(arm, prior, best.theta, process_noise.fraction)
    fit = replace(best, costs=rigid.costs)
    return Identified(springs, fit, prior.names(arm), whiteness(best.innovation))


def synchronised(
    arm: NominalArm,
    springs: Springs,
    run: Run,
    rest: Array,
    imu: ImuCfg,
    *,
    prior: SpringPrior = SpringPrior(),
    process_noise: ProcessNoise = ProcessNoise(),
) -> tuple[Springs, Whiteness]:
    """Known springs with clock and mounting of another unit, found again, and the innovations.

    Clocks differ from unit to unit and from start to start; springs do not.

    Raises RuntimeError for springs that are too soft for this arm.
    """
    innovations = _Innovations(arm, linearised(arm, rest), run, imu, prior, process_noise)
    sd = np.array([prior.clock, *3 * (prior.mounting,)])

    def own(theta: Array) -> Springs:
        return replace(springs, clock_offset=float(theta[0]), mounting=theta[1:].copy())

    found = estimate_parameters(
        lambda theta: innovations.on(own(theta)), np.zeros(4), sd, [np.zeros(4)]
    )
    return own(found.theta), whiteness(found.innovation)


def residual(
    model: ArmFilter, run: Run, clock_offset: float, mounting: Array
) -> tuple[Array, Array]:
    """IMU readings (K, 6) minus those the motor angles explain; biases (6,), their mean at rest.

    mounting: (3,) [rad], rotation of the IMU's housing: it reads y - mounting x y.
    """
    return _left(run, _explained(model, run), clock_offset, mounting)


def _explained(model: ArmFilter, run: Run) -> "CubicHermiteSpline":
    """(6,) low-passed readings that the motor angles explain, over time."""
    from scipy.interpolate import CubicHermiteSpline

    states = model.simulated(run.phi, run.phi_dot, run.nonlinear, run.period)
    return CubicHermiteSpline(run.time, *model.readings(states))


def _left(
    run: Run, explained: "CubicHermiteSpline", clock_offset: float, mounting: Array
) -> tuple[Array, Array]:
    at = run.imu_time + clock_offset
    y = explained(np.clip(at, run.time[0], run.time[-1]))
    left = run.reading - y + np.hstack([np.cross(mounting, v) for v in np.split(y, 2, axis=1)])
    return left, np.nanmean(left[at < REST], axis=0)


class _Innovations:
    """Whitened innovations of a run, for parameters (m,)."""

    def __init__(
        self,
        arm: NominalArm,
        nominal: LinearisedArm,
        run: Run,
        imu: ImuCfg,
        prior: SpringPrior,
        process_noise: ProcessNoise,
    ) -> None:
        self.arm, self.nominal, self.run = arm, nominal, run
        self.slowest = SOFTEST * float(nominal.locked_modes()[0])
        self.imu, self.prior, self.process_noise = imu, prior, process_noise
        # Gradients move clock and mounting of the IMU as well, which the filter does not depend on.
        self._last: tuple[bytes, _Filter | None] = (b"", None)

    def __call__(self, theta: Array) -> Whitened:
        return self.on(springs_at(self.arm, self.prior, theta, self.process_noise.fraction))

    def on(self, springs: Springs) -> Whitened:
        """Innovations on given springs."""
        known = self._filter(springs)
        if known is None:
            return Whitened(np.full_like(self.run.reading, np.inf), 0.0)
        start = np.zeros(len(known.settled.process.A))
        left, start[-6:] = _left(self.run, known.explained, springs.clock_offset, springs.mounting)
        W, log_det = known.settled.whitening
        return Whitened(known.settled(left, start).innovation @ W.T, log_det)

    def _filter(self, springs: Springs) -> "_Filter | None":
        parts = springs.stiffness, springs.damping, springs.process_noise
        key = b"".join(np.asarray(part).tobytes() for part in parts)
        if key != self._last[0]:
            self._last = key, self._set_up(springs)
        return self._last[1]

    def _set_up(self, springs: Springs) -> "_Filter | None":
        """None for springs that are too soft for an arm."""
        candidate = self.nominal.on_springs(springs.stiffness, springs.damping)
        if candidate.locked_modes()[0] < self.slowest:
            return None
        noise = replace(self.process_noise, fraction=springs.process_noise)
        model = arm_filter(candidate, self.imu, noise)
        process = model.sampled(1.0 / self.imu.rate)
        return _Filter(SteadyStateFilter(process), _explained(model, self.run))


class _Filter(NamedTuple):
    settled: SteadyStateFilter
    explained: "CubicHermiteSpline"
