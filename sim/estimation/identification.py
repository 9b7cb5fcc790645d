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
    fit = estimate_parameters(model, np.zeros_like(sd), sd, starts, further)
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
    # Gradients move clock and mounting as well, which filter and deflection do not depend on.
    _last: "tuple[bytes, tuple[SteadyStateFilter, CubicHermiteSpline] | None]" = (b"", None)

    def __call__(self, theta: Array) -> Whitened:
        return self.on(parameters_at(self.nominal, theta))

    def on(self, parameters: ArmParameters) -> Whitened:
        """Innovations on given parameters."""
        known = self._known(parameters)
        if known is None:
            return Whitened(np.full((len(self.samples.time), 6), np.inf), 0.0)
        settled, readings = known
        start = np.zeros(len(settled.process.A))
        unit = parameters.clock_offset, parameters.mounting
        left, start[-6:] = residual(self.samples, readings, *unit)
        W, log_det = settled.whitening
        return Whitened(settled(left, start).innovation @ W.T, log_det)

    def _known(
        self, parameters: ArmParameters
    ) -> "tuple[SteadyStateFilter, CubicHermiteSpline] | None":
        """Filter and explained readings; None for springs that cannot carry the arm."""
        springs, motion = parameters.springs, self.motion
        parts = springs.stiffness, springs.damping, springs.lost_motion, parameters.process_noise
        key = b"".join(np.asarray(part).tobytes() for part in parts)
        if key == self._last[0]:
            return self._last[1]
        try:
            bent = deflection(motion, springs)
            segment = int(motion.segment[len(motion.segment) // 2])
            process = filter_at(motion, parameters, self.imu, segment).sampled(1.0 / self.imu.rate)
            known = SteadyStateFilter(process), explained(motion, bent, self.imu)
        except (FloatingPointError, RuntimeError):
            known = None
        self._last = key, known
        return known
