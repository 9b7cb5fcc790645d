"""The arm's springs from one run: motor angles in, IMU out, by the filter's innovations.

What one run tells is a local, *effective* elasticity: gears and structure together as they act at
the tool in this pose. Inertia is taken from the nominal arm; only K / M shows in the motion.
"""

from dataclasses import dataclass, replace

import numpy as np

from ilc.estimation.consistency import Whiteness, whiteness
from ilc.estimation.kalman import SettledFilter
from ilc.estimation.prediction_error import Fit, Whitened, fit
from ilc.filters import ZeroPhaseButterworth

from .arm_filter import ArmFilter, Distrust, arm_filter
from .arm_springs import SpringPrior, Springs, springs_at
from .frozen_arm import FrozenArm, frozen
from .instruments.imu import ImuCfg, ImuSamples
from .nominal import NominalArm
from .observer import ENCODER_FILTER
from .recording import Array
from .servo import interpolate

REST = 0.2
"""At the beginning of a run in which the arm does not move yet [s]."""
_STARTS = (
    (0.0, 0.0),
    (0.3, 0.3),
    (-0.3, -0.3),
    (-0.7, 0.0),
    (0.0, 0.7),
    (-0.7, 0.7),
)
"""Of log K: of axes 1 to 3, and of the wrist. A structure softens the first more than the last."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Identified:
    """Springs, how well they are known, and whether the filter then leaves white innovations."""

    springs: Springs
    fit: Fit
    names: tuple[str, ...]
    """Of the entries of fit.theta."""
    whiteness: Whiteness


@dataclass(frozen=True, kw_only=True, eq=False)
class Run:
    """What is measured in one run, prepared for linear filters around rest."""

    time: Array
    """(N,) [s], of the motor log."""
    phi: Array
    """(N, 6) [rad], motor angles from rest, low-passed."""
    phi_dot: Array
    """(N, 6) [rad/s]."""
    imu_time: Array
    """(K,) [s], the IMU's own clock."""
    reading: Array
    """(K, 6) [m/s^2], [rad/s]; rows of NaN are missing."""

    @property
    def period(self) -> float:
        return float(self.time[1] - self.time[0])


def prepared(time: Array, motor_angle: Array, samples: ImuSamples) -> Run:
    """A run's log (N,), (N, 6) and the IMU's samples."""
    period = float(time[1] - time[0])
    smooth = ZeroPhaseButterworth(ENCODER_FILTER, period)(motor_angle)
    phi, phi_dot, _ = interpolate(smooth, period, 1)
    return Run(
        time=time,
        phi=phi - phi[0],
        phi_dot=phi_dot,
        imu_time=samples.time,
        reading=np.hstack((samples.acceleration, samples.angular_velocity)),
    )


def identify(
    arm: NominalArm,
    run: Run,
    rest: Array,
    imu: ImuCfg,
    *,
    prior: SpringPrior = SpringPrior(),
    distrust: Distrust = Distrust(),
) -> Identified:
    """The springs that explain one run best.

    Args:
        arm: the nominal arm, where the search starts.
        rest: (6,) [rad], motor angles at rest.
        imu: the kind of unit, as its data sheet has it.

    Raises:
        RuntimeError: no start leads anywhere.
    """
    nominal = frozen(arm, rest)

    def innovations(theta: Array) -> Whitened:
        return _innovations(arm, nominal, run, imu, prior, distrust, theta)

    sd = prior.standard_deviation
    starts = [np.concatenate((np.repeat(k, 3), np.zeros(sd.size - 6))) for k in _STARTS]
    best = fit(innovations, np.zeros(sd.size), sd, starts)
    return Identified(
        springs=springs_at(arm, prior, best.theta, distrust.share),
        fit=best,
        names=prior.names,
        whiteness=whiteness(best.innovation),
    )


def residual(
    model: ArmFilter, run: Run, clock_offset: float, mounting: Array
) -> tuple[Array, Array]:
    """IMU readings minus those that the motor angles explain, and their mean at rest.

    Args:
        mounting: (3,) [rad], turn of the IMU's housing: it reads y - mounting x y.

    Returns:
        (K, 6), and (6,): the biases.
    """
    from scipy.interpolate import CubicHermiteSpline

    low, rate = model.readings(model.simulated(run.phi, run.phi_dot, run.period))
    at = np.clip(run.imu_time + clock_offset, run.time[0], run.time[-1])
    explained = CubicHermiteSpline(run.time, low, rate)(at)
    turned = [np.cross(mounting, part) for part in np.split(explained, 2, axis=1)]
    left = run.reading - explained + np.hstack(turned)
    return left, np.nanmean(left[run.imu_time + clock_offset < REST], axis=0)


def _innovations(
    arm: NominalArm,
    nominal: FrozenArm,
    run: Run,
    imu: ImuCfg,
    prior: SpringPrior,
    distrust: Distrust,
    theta: Array,
) -> Whitened:
    springs = springs_at(arm, prior, theta, distrust.share)
    candidate = nominal.on_springs(springs.stiffness, springs.damping)
    if np.linalg.eigvalsh(candidate.spring_matrix)[0] <= 0.0:  # the arm would fall
        return Whitened(np.full_like(run.reading, np.inf), 0.0)
    model = arm_filter(candidate, imu, replace(distrust, share=springs.distrust))
    left, bias = residual(model, run, springs.clock_offset, springs.mounting)
    settled = SettledFilter(model.sampled(1.0 / imu.rate))
    start = np.zeros(len(model.A))
    start[-6:] = bias
    W, log_det = settled.whitening
    return Whitened(settled(left, start).innovation @ W.T, log_det)
