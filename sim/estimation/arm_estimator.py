"""The tool's path from motor angles and IMU: observer, plus a smoothed deviation.

The observer simulates the nominal arm with the measured motors as input. The deviation that the IMU
adds is small, so it is estimated in deviation form: a linear filter and smoother whose gains depend
on the arm, the pose and the IMU's timeline only, and are computed once for all runs of a reference.
"""

from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property

import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.kalman import Smoothed, Smoother, SteadyStateFilter
from armside.ilc.estimation.wiener import NonCausal

from ..instruments.imu import ImuCfg, ImuSamples
from .arm_filter import ArmFilter, ProcessNoise, arm_filter
from .arm_identification import Run, prepared, residual, with_nonlinear_residual
from .arm_springs import Springs
from .linearised_arm import linearised
from .nominal import NominalArm
from .observer import ArmMotion, observe
from .plausibility import check_plausible
from .relative_path import REST_SAMPLES, relative_to_start

UNIDENTIFIED = 0.3
"""`ProcessNoise.fraction` of an arm whose springs were not identified."""


class Estimate(Enum):
    """Readings of a run that its path is estimated from."""

    OBSERVER = "observer"
    """None: motor angles and model only."""
    FILTER = "filter"
    """Those before each instant: what a controller could know."""
    SMOOTHER = "smoother"
    """All of them: a run is over before it is learned from."""
    WIENER = "wiener"
    """All of them, in the frequency domain."""


@dataclass(frozen=True, eq=False)
class ToolEstimate:
    """The tool as estimated, at the instants of the motor log."""

    displacement: Array
    """(N, 6): displacement [m] and rotation vector [rad] from rest, base axes."""
    innovation: Array
    """(K, 6), whitened innovations of the filter; NaN where no reading was used."""


@dataclass(frozen=True, eq=False)
class ArmEstimator:
    """Estimates the tool of one robot at one pose."""

    arm: NominalArm
    """Arm on the assumed springs."""
    clock_offset: float
    """Robot time when the IMU's clock shows 0 [s]."""
    mounting: Array
    """(3,) [rad], rotation of the IMU's housing."""
    rest: Array
    """(a,) [rad], motor angles at rest."""
    imu: ImuCfg
    process_noise: ProcessNoise

    @cached_property
    def model(self) -> ArmFilter:
        """The process that filters work on."""
        return arm_filter(linearised(self.arm, self.rest), self.imu, self.process_noise)

    @cached_property
    def _smoothers(self) -> dict[bytes, Smoother]:
        return {}

    def smoother(self, run: Run) -> Smoother:
        """Gains for the timeline of a run; computed when a timeline is first met."""
        seen = np.isfinite(run.reading)
        key = seen.tobytes()
        if key not in self._smoothers:
            process = self.model.sampled(1.0 / self.imu.rate)
            self._smoothers[key] = Smoother(process, self.model.start_covariance(), seen)
        return self._smoothers[key]

    @cached_property
    def settled(self) -> SteadyStateFilter:
        return SteadyStateFilter(self.model.sampled(1.0 / self.imu.rate))

    def deviations(self, run: Run) -> Smoothed:
        """States of filter and smoother at the IMU's instants."""
        left, bias = self._residual(run)
        start = np.zeros(len(self.model.A))
        start[-6:] = bias
        return self.smoother(run)(left, start)

    def _residual(self, run: Run) -> tuple[Array, Array]:
        nonlinear = with_nonlinear_residual(self.arm, self.model, run)
        return residual(self.model, nonlinear, self.clock_offset, self.mounting)

    def __call__(
        self,
        time: Array,
        motor_angle: Array,
        samples: ImuSamples | None,
        kind: Estimate = Estimate.SMOOTHER,
    ) -> ToolEstimate:
        """The tool in one run: log (N,), (N, a) and IMU samples, None without an IMU.

        Raises EstimateError for a path that the motor angles contradict.
        """
        found = self._estimate(time, motor_angle, samples, kind)
        tool, period = found.displacement[:, :3], float(time[1] - time[0])
        check_plausible(tool, self.arm, self.model.arm, motor_angle, period)
        return found

    def _estimate(
        self, time: Array, motor_angle: Array, samples: ImuSamples | None, kind: Estimate
    ) -> ToolEstimate:
        from scipy.interpolate import CubicSpline

        period = float(time[1] - time[0])
        path = tool_path(observe(self.arm, motor_angle, period), period)
        if samples is None or kind is Estimate.OBSERVER:
            return ToolEstimate(path, np.empty((0, 6)))
        run = prepared(self.arm, time, motor_angle, samples)
        states = self.deviations(run)
        if kind is Estimate.WIENER:
            left, bias = self._residual(run)
            model = self.model
            wiener = NonCausal(model.A, model.intensity, model.C, model.tool)
            deviation = wiener(left - bias, 1.0 / self.imu.rate, model.reading_covariance)
        else:
            chosen = states.filtered if kind is Estimate.FILTER else states.smoothed
            deviation = chosen @ self.model.tool.T
        instants = run.imu_time + self.clock_offset
        # A cubic spline, held beyond its ends.
        shift = CubicSpline(instants, deviation)(np.clip(time, instants[0], instants[-1]))
        shift -= shift[:REST_SAMPLES].mean(axis=0)
        W, _ = self.settled.whitening
        return ToolEstimate(path + shift, states.innovation @ W.T)


def estimator(
    arm: NominalArm,
    springs: Springs,
    rest: Array,
    imu: ImuCfg,
    process_noise: ProcessNoise = ProcessNoise(),
) -> ArmEstimator:
    """An estimator on identified springs."""
    noise, clock = replace(process_noise, fraction=springs.process_noise), springs.clock_offset
    return ArmEstimator(springs.on(arm), clock, springs.mounting, rest, imu, noise)


def tool_path(motion: ArmMotion, period: float) -> Array:
    """(N, 6): displacement and rotation vector of the tool from rest, every `period` [s]."""
    every = round(period / float(motion.time[1] - motion.time[0]))
    return relative_to_start(motion.tool_position[::every], motion.tool_quaternion[::every])
