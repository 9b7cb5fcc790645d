"""Unknown parameters of an arm's springs, and of its IMU's clock and mounting.

    theta = (log K_11..K_nn, log D scale, clock offset, log process noise, mounting (3), rho_ij)

relative to the nominal arm: K_ij = rho_ij sqrt(K_ii K_jj). An elastic structure couples axes of
equal parity (`coupled_axes`): in an arm of six axes those in its vertical plane with each other,
and the others.
"""

from dataclasses import dataclass, fields

import numpy as np

from armside.arrays import Array

from .nominal import NominalArm


def arm_and_wrist(n_axes: int) -> tuple[int, int]:
    """Number of axes that stand in the structure, and of those behind them: a wrist of up to 3."""
    wrist = min(max(n_axes - 3, 0), 3)
    return n_axes - wrist, wrist


@dataclass(frozen=True, kw_only=True)
class SpringPrior:
    """Prior standard deviations of the parameters around the nominal arm."""

    stiffness: float = 0.6
    """Log K of the axes before the wrist: the structure they stand in is in series with their gears
    and makes them softer, twice and more. ESTIMATE."""
    wrist_stiffness: float = 0.2
    """Log K of the wrist: uniform within +- 30 % is a standard deviation of 0.17. A wider
    one lets the wrist explain what is not its own, and ends in wrong minima."""
    damping: float = 0.5
    """Log of the damping's scale."""
    clock: float = 0.010
    """[s]."""
    process_noise: float = 0.5
    """Log of `ProcessNoise.fraction`."""
    mounting: float = 0.02
    """Rotation of the IMU's housing about each of its axes [rad]."""
    coupling: float = 0.3
    """Coupling rho; 0 keeps to gear springs."""

    def __post_init__(self) -> None:
        for field in fields(self):
            if field.name != "coupling" and not getattr(self, field.name) > 0.0:
                raise ValueError(f"{field.name} must be > 0, got {getattr(self, field.name)}")
        if not self.coupling >= 0.0:
            raise ValueError(f"coupling must be >= 0, got {self.coupling}")

    def pairs(self, arm: NominalArm) -> tuple[tuple[int, int], ...]:
        """Axes that the structure may couple, counted from 0."""
        return arm.coupled if self.coupling > 0.0 else ()

    def standard_deviation(self, arm: NominalArm) -> Array:
        """(m,), of theta; its mean is 0."""
        values = self.stiffness, self.wrist_stiffness, self.damping, self.clock, self.process_noise
        repeats = (*arm_and_wrist(len(arm.axes)), 1, 1, 1, 3, len(self.pairs(arm)))
        return np.repeat([*values, self.mounting, self.coupling], repeats)

    def names(self, arm: NominalArm) -> tuple[str, ...]:
        """(m,), of the entries of theta."""
        stiffness = (f"stiffness {i + 1}" for i in range(len(arm.axes)))
        mounting = (f"mounting {axis}" for axis in "xyz")
        pairs = (f"coupling {i + 1}-{j + 1}" for i, j in self.pairs(arm))
        return (*stiffness, "damping", "clock", "process noise", *mounting, *pairs)


@dataclass(frozen=True, eq=False)
class Springs:
    """Springs of an arm, and clock and mounting of its IMU."""

    stiffness: Array
    """(n, n) [N m/rad]."""
    damping: Array
    """(n,) [N m s/rad]."""
    clock_offset: float
    """Robot time when the unit's clock shows 0 [s]."""
    process_noise: float
    """`ProcessNoise.fraction`: fraction of the arm's twist that the model leaves unexplained."""
    mounting: Array
    """(3,) [rad], rotation of the IMU's housing from its site."""

    def on(self, arm: NominalArm) -> NominalArm:
        """The arm on these springs."""
        return arm.with_springs(self.stiffness, self.damping)


def springs_at(arm: NominalArm, prior: SpringPrior, theta: Array, fraction: float) -> Springs:
    """Springs of parameters theta on a nominal arm; fraction: expected `ProcessNoise.fraction`."""
    n = len(arm.axes)
    own = np.diag(arm.stiffness) * np.exp(theta[:n])
    K = np.diag(own)
    for rho, (i, j) in zip(theta[n + 6 :], prior.pairs(arm), strict=True):
        K[i, j] = K[j, i] = rho * np.sqrt(own[i] * own[j])
    damping, clock, noise = theta[n : n + 3]
    mounting = theta[n + 3 : n + 6].copy()
    noise = fraction * float(np.exp(noise))
    return Springs(K, arm.damping * np.exp(damping), float(clock), noise, mounting)
