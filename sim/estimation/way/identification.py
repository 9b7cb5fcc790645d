"""Identification of an arm's springs along a long way, by the innovations of a filter.

Explained readings follow the pose exactly; the filter that whitens what is left is that of the
place in the middle of the record.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.consistency import Whiteness, whiteness
from armside.ilc.estimation.kalman import SteadyStateFilter
from armside.ilc.estimation.prediction_error import ParameterEstimate, Whitened, estimate_parameters

from ...instruments.imu import ImuCfg, ImuSamples
from ..arm_filter import ArmFilter, ProcessNoise, arm_filter
from ..linearised_arm import LinearisedArm
from .deflection import deflection
from .elasticity import Elasticity
from .parameters import WayConstants, WayPrior, constants_at
from .readings import explained, residual
from .rigid_motion import RigidMotion

if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline

_STARTS = ((0.0, 0.7), (-0.2, 0.0))
"""Log stiffness of gears and of the structure."""
_FURTHER = ((0.0, 1.2),)
"""Likewise, where these lead to a minimum far from the prior: one without lost motion, where a
structure that stiffens without bound, or gives way, stands in for it."""


@dataclass(frozen=True, eq=False)
class WayIdentified:
    """Identified constants, their uncertainty, and the whiteness of the innovations on them."""

    constants: WayConstants
    fit: ParameterEstimate
    whiteness: Whiteness


def identify(
    motion: RigidMotion,
    nominal: Elasticity,
    samples: ImuSamples,
    imu: ImuCfg,
    *,
    prior: WayPrior = WayPrior(),
    process_noise: ProcessNoise = ProcessNoise(),
) -> WayIdentified:
    """The constants that explain a record best.

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
    constants = constants_at(nominal, fit.theta, process_noise.fraction)
    return WayIdentified(constants, fit, whiteness(fit.innovation))


def linearised(motion: RigidMotion, springs: Elasticity, segment: int) -> LinearisedArm:
    """The arm in one segment of its motion."""
    structure, damping = springs.stiffness.copy(), springs.damping.copy()
    structure[springs.axes] = damping[springs.axes] = 0.0
    arm = motion.linearised(segment, structure, damping)
    return arm.on_springs(np.diag(springs.stiffness[springs.axes]), springs.damping[springs.axes])


def filter_at(
    motion: RigidMotion,
    constants: WayConstants,
    imu: ImuCfg,
    noise: ProcessNoise,
    segment: int,
) -> ArmFilter:
    """Process of the deviation from the deflected arm, in one segment."""
    noise = replace(noise, fraction=constants.process_noise)
    return arm_filter(linearised(motion, constants.springs, segment), imu, noise)


class _Known(NamedTuple):
    settled: SteadyStateFilter
    readings: "CubicHermiteSpline"


class _Innovations:
    """Whitened innovations of a record, for parameters (m,)."""

    def __init__(
        self,
        motion: RigidMotion,
        nominal: Elasticity,
        samples: ImuSamples,
        imu: ImuCfg,
        noise: ProcessNoise,
    ) -> None:
        self.motion, self.nominal, self.samples = motion, nominal, samples
        self.imu, self.noise = imu, noise
        self.segment = int(motion.segment[len(motion.segment) // 2])
        # Gradients move clock and mounting as well, which filter and deflection do not depend on.
        self._last: tuple[bytes, _Known | None] = (b"", None)

    def __call__(self, theta: Array) -> Whitened:
        constants = constants_at(self.nominal, theta, self.noise.fraction)
        known = self._known(theta, constants)
        if known is None:
            return Whitened(np.full((len(self.samples.time), 6), np.inf), 0.0)
        start = np.zeros(len(known.settled.process.A))
        left, start[-6:] = residual(
            self.samples, known.readings, constants.clock_offset, constants.mounting
        )
        W, log_det = known.settled.whitening
        return Whitened(known.settled(left, start).innovation @ W.T, log_det)

    def _known(self, theta: Array, constants: WayConstants) -> "_Known | None":
        n = len(self.nominal.stiffness)
        key = np.r_[theta[: n + 3], constants.process_noise].tobytes()
        if key != self._last[0]:
            self._last = key, self._set_up(constants)
        return self._last[1]

    def _set_up(self, constants: WayConstants) -> "_Known | None":
        """None for springs that cannot carry the arm."""
        try:
            bent = deflection(self.motion, constants.springs)
            model = filter_at(self.motion, constants, self.imu, self.noise, self.segment)
            settled = SteadyStateFilter(model.sampled(1.0 / self.imu.rate))
        except (FloatingPointError, RuntimeError):
            return None
        return _Known(settled, explained(self.motion, bent, self.imu))
