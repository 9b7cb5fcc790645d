"""Identification of an arm's springs from one run, by the innovations of a filter.

Explained readings follow the pose exactly; the filter that whitens what is left is that of the
place in the middle of the record. Inertia is taken from the assumed arm: only K / M shows in the
motion.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.consistency import Whiteness, whiteness
from armside.ilc.estimation.kalman import SteadyStateFilter
from armside.ilc.estimation.prediction_error import ParameterEstimate, Whitened, estimate_parameters

from ..instruments.imu import ImuCfg, ImuSamples
from .arm_filter import ArmFilter, ProcessNoise, arm_filter
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
    process_noise: ProcessNoise = ProcessNoise(),
) -> Identified:
    """The parameters that explain a record best.

    nominal: start of the search. imu: kind of unit, as its data sheet has it.

    Raises RuntimeError where no start leads to a minimum.
    """
    sd, n = prior.standard_deviation(nominal), len(nominal.stiffness)

    def start(gears: float, structure: float) -> Array:
        theta = np.zeros_like(sd)
        theta[:n] = structure
        theta[nominal.axes] = gears
        return theta

    starts, further = ([start(*each) for each in given] for given in (_STARTS, _FURTHER))
    model = _Innovations(motion, nominal, samples, imu, process_noise)
    fit = estimate_parameters(model, np.zeros_like(sd), sd, starts, further)
    parameters = parameters_at(nominal, fit.theta, process_noise.fraction)
    return Identified(parameters, fit, whiteness(fit.innovation))


def synchronised(
    motion: RigidMotion,
    known: ArmParameters,
    samples: ImuSamples,
    imu: ImuCfg,
    prior: SpringPrior = SpringPrior(),
    process_noise: ProcessNoise = ProcessNoise(),
) -> tuple[ArmParameters, Whiteness]:
    """Known springs with what is not theirs found again, and the innovations.

    Clock and mounting differ from unit to unit and from start to start, and what the springs leave
    unexplained from cut to cut: another place turns other gears.

    Raises RuntimeError for springs that cannot carry the arm.
    """
    model = _Innovations(motion, known.springs, samples, imu, process_noise)
    sd = np.array([prior.clock, *3 * (prior.mounting,), prior.process_noise])

    def own(theta: Array) -> ArmParameters:
        return replace(
            known,
            clock_offset=float(theta[0]),
            mounting=theta[1:4].copy(),
            process_noise=process_noise.fraction * float(np.exp(theta[4])),
        )

    found = estimate_parameters(lambda theta: model.on(own(theta)), 0.0 * sd, sd, [0.0 * sd])
    return own(found.theta), whiteness(found.innovation)


def filter_at(
    motion: RigidMotion,
    parameters: ArmParameters,
    imu: ImuCfg,
    noise: ProcessNoise,
    segment: int,
) -> ArmFilter:
    """Process of the deviation from the deflected arm, in one segment."""
    noise = replace(noise, fraction=parameters.process_noise)
    return arm_filter(motion.linearised(segment, parameters.springs), imu, noise)


class _Known(NamedTuple):
    settled: SteadyStateFilter
    readings: "CubicHermiteSpline"


@dataclass(eq=False)
class _Innovations:
    """Whitened innovations of a record, for parameters (m,)."""

    motion: RigidMotion
    nominal: Elasticity
    samples: ImuSamples
    imu: ImuCfg
    noise: ProcessNoise
    # Gradients move clock and mounting as well, which filter and deflection do not depend on.
    _last: tuple[bytes, _Known | None] = (b"", None)

    def __call__(self, theta: Array) -> Whitened:
        return self.on(parameters_at(self.nominal, theta, self.noise.fraction))

    def on(self, parameters: ArmParameters) -> Whitened:
        """Innovations on given parameters."""
        known = self._known(parameters)
        if known is None:
            return Whitened(np.full((len(self.samples.time), 6), np.inf), 0.0)
        start = np.zeros(len(known.settled.process.A))
        left, start[-6:] = residual(
            self.samples, known.readings, parameters.clock_offset, parameters.mounting
        )
        W, log_det = known.settled.whitening
        return Whitened(known.settled(left, start).innovation @ W.T, log_det)

    def _known(self, parameters: ArmParameters) -> "_Known | None":
        springs = parameters.springs
        parts = springs.stiffness, springs.damping, springs.lost_motion, parameters.process_noise
        key = b"".join(np.asarray(part).tobytes() for part in parts)
        if key != self._last[0]:
            self._last = key, self._set_up(parameters)
        return self._last[1]

    def _set_up(self, parameters: ArmParameters) -> "_Known | None":
        """None for springs that cannot carry the arm."""
        try:
            bent = deflection(self.motion, parameters.springs)
            segment = int(self.motion.segment[len(self.motion.segment) // 2])
            model = filter_at(self.motion, parameters, self.imu, self.noise, segment)
            settled = SteadyStateFilter(model.sampled(1.0 / self.imu.rate))
        except (FloatingPointError, RuntimeError):
            return None
        return _Known(settled, explained(self.motion, bent, self.imu))
