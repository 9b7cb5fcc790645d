"""Identification of an arm's springs from one run, by the innovations of a filter.

Explained readings follow the pose exactly; the filter that whitens what is left is that of the
place in the middle of the record. Inertia is taken from the assumed arm: only K / M shows in the
motion.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.consistency import Whiteness, whiteness
from armside.ilc.estimation.kalman import SteadyStateFilter
from armside.ilc.estimation.prediction_error import ParameterEstimate, Whitened, estimate_parameters
from armside.ilc.estimation.process import Process

from ..instruments.imu import ImuCfg, ImuSamples
from .arm_filter import FRACTION, ArmFilter, arm_filter
from .deflection import deflection, explained, residual
from .elasticity import ArmParameters, Elasticity, SpringPrior, parameters_at
from .rigid_motion import RigidMotion

if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline

_STARTS = ((0.0, 0.7), (-0.2, 0.0))
"""Log stiffness of gears and of the structure."""
_FURTHER = ((0.0, 1.2), (0.0, 2.0))
"""Likewise, where these lead to a minimum far from the prior: one without lost motion, where a
structure that stiffens without bound, or gives way, stands in for it; or one of a structure that
is much stiffer than its gears, as that of the IRB1400."""


@dataclass(frozen=True, eq=False)
class Identified:
    """Identified parameters, their uncertainty, and the whiteness of the innovations on them."""

    parameters: ArmParameters
    fit: ParameterEstimate
    whiteness: Whiteness


def identify(
    motion: RigidMotion,
    nominal: Elasticity,
    samples: ImuSamples,
    imu: ImuCfg,
    prior: SpringPrior = SpringPrior(),
) -> Identified:
    """The parameters that explain a record best, from nominal springs on.

    Raises RuntimeError where no start leads to a minimum.
    """
    sd, n = prior.standard_deviation(nominal), len(nominal.stiffness)

    def start(gears: float, structure: float) -> Array:
        theta = np.zeros_like(sd)
        theta[:n] = structure
        theta[nominal.axes] = gears
        return theta

    starts, further = ([start(*each) for each in given] for given in (_STARTS, _FURTHER))
    model = _Innovations(motion, nominal, samples, imu)
    fit = estimate_parameters(model, np.zeros_like(sd), sd, starts, further, model.beside)
    parameters = parameters_at(nominal, fit.theta)
    return Identified(parameters, fit, whiteness(fit.innovation))


def synchronised(
    motion: RigidMotion,
    known: ArmParameters,
    samples: ImuSamples,
    imu: ImuCfg,
    prior: SpringPrior = SpringPrior(),
) -> tuple[ArmParameters, Whiteness]:
    """Known springs with what is not theirs found again, and the innovations.

    Clock and mounting differ from unit to unit and from start to start, and what the springs leave
    unexplained from cut to cut: another place turns other gears.

    Raises RuntimeError for springs that cannot carry the arm.
    """
    model = _Innovations(motion, known.springs, samples, imu)
    sd = np.array([prior.clock, *3 * (prior.mounting,), prior.process_noise])

    def own(theta: Array) -> ArmParameters:
        return replace(
            known,
            clock_offset=float(theta[0]),
            mounting=theta[1:4].copy(),
            process_noise=FRACTION * float(np.exp(theta[4])),
        )

    found = estimate_parameters(lambda theta: model.on(own(theta)), 0.0 * sd, sd, [0.0 * sd])
    return own(found.theta), whiteness(found.innovation)


def filter_at(
    motion: RigidMotion, parameters: ArmParameters, imu: ImuCfg, segment: int
) -> ArmFilter:
    """Process of the deviation from the deflected arm, in one segment."""
    arm = motion.linearised(segment, parameters.springs)
    return arm_filter(arm, imu, parameters.process_noise)


@dataclass(eq=False)
class _Innovations:
    """Whitened innovations of a record, for parameters (m,)."""

    motion: RigidMotion
    nominal: Elasticity
    samples: ImuSamples
    imu: ImuCfg
    # Gradients move one parameter at a time, which few of these depend on.
    _filter: tuple[bytes, SteadyStateFilter | None] = (b"", None)
    _readings: "tuple[bytes, CubicHermiteSpline | None]" = (b"", None)

    def __call__(self, theta: Array) -> Whitened:
        return self.on(parameters_at(self.nominal, theta))

    def beside(self, theta: Array, step: Array) -> Whitened:
        """At theta + step, with the filter by its derivative at theta."""
        here, there = (parameters_at(self.nominal, each) for each in (theta, theta + step))
        try:
            settled, readings = self._settled(here), self._explained(there, stored=False)
            if _of_filter(there) != self._filter[0]:
                settled = settled.beside(self._process(there))
        except (FloatingPointError, RuntimeError):
            return self._impossible
        return self._whitened(settled, readings, there)

    def on(self, parameters: ArmParameters) -> Whitened:
        """Innovations on given parameters; infinite for springs that cannot carry the arm."""
        try:
            known = self._settled(parameters), self._explained(parameters)
        except (FloatingPointError, RuntimeError):
            return self._impossible
        return self._whitened(*known, parameters)

    @property
    def _impossible(self) -> Whitened:
        return Whitened(np.full((len(self.samples.time), 6), np.inf), 0.0)

    def _whitened(
        self, settled: SteadyStateFilter, readings: "CubicHermiteSpline", own: ArmParameters
    ) -> Whitened:
        start = np.zeros(len(settled.process.A))
        left, start[-6:] = residual(self.samples, readings, own.clock_offset, own.mounting)
        W, log_det = settled.whitening
        return Whitened(settled(left, start).innovation @ W.T, log_det)

    def _process(self, parameters: ArmParameters) -> Process:
        segment = int(self.motion.segment[len(self.motion.segment) // 2])
        process = filter_at(self.motion, parameters, self.imu, segment)
        return process.sampled(1.0 / self.imu.rate)

    def _settled(self, parameters: ArmParameters) -> SteadyStateFilter:
        key, (last, settled) = _of_filter(parameters), self._filter
        if settled is None or key != last:
            settled = SteadyStateFilter(self._process(parameters))
            self._filter = key, settled
        return settled

    def _explained(self, parameters: ArmParameters, stored: bool = True) -> "CubicHermiteSpline":
        springs, (last, readings) = parameters.springs, self._readings
        key = _bytes(springs.stiffness, springs.damping, springs.lost_motion)
        if readings is None or key != last:
            readings = explained(self.motion, deflection(self.motion, springs), self.imu)
            if stored:
                self._readings = key, readings
        return readings


def _of_filter(parameters: ArmParameters) -> bytes:
    """What the filter depends on."""
    springs = parameters.springs
    return _bytes(springs.stiffness, springs.damping, parameters.process_noise)


def _bytes(*parts: Array | float) -> bytes:
    return b"".join(np.asarray(part).tobytes() for part in parts)
