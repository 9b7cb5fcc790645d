"""Two-mass joint with Coulomb friction at the motor and noise on the measured angle.

Future work of thesis chapter 8: tau_C = c sign(q_m').
"""

from dataclasses import dataclass, field
from functools import cache

import numpy as np

from armside.arrays import Array

from ..records import as_record, records
from .discretise import zero_order_hold
from .two_mass import TwoMassLoop, TwoMassRun, step_reference


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionPlant:
    """Loop of Fig 8.2 in continuous time, sampled controller, dry friction, noisy encoder.

    Between samples the linear part is exact (zero-order hold over `substeps`). In each substep
    the friction torque is the one that stops the motor, limited to c, so that it sticks without
    chattering. Noise enters the angle that controller and law measure; `run` returns the measured
    motor angle and the exact arm angle.
    """

    loop: TwoMassLoop = field(default_factory=TwoMassLoop)
    arm_reference: Array = field(default_factory=step_reference)
    coulomb: float = 0.0
    """c [N m], motor side."""
    noise: float = 0.0
    rng: np.random.Generator | None = None
    """Source of noise, whose standard deviation is that of the measured motor angle [rad]."""
    substeps: int = 20
    motor_reference: Array = field(init=False)
    """r_m = F_r r_a, shape (N, 1)."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.coulomb) and self.coulomb >= 0.0):
            raise ValueError(f"coulomb must be >= 0 N m, got {self.coulomb}")
        if self.noise < 0.0 or (self.noise > 0.0 and self.rng is None):
            needed = ">= 0 and needs an rng if it is not 0"
            raise ValueError(f"noise must be {needed}, got {self.noise}")
        if self.substeps < 1:
            raise ValueError(f"substeps must be >= 1, got {self.substeps}")
        object.__setattr__(self, "arm_reference", as_record(self.arm_reference, "arm_reference"))
        _ = self.loop.T_motor  # refuses an unstable loop
        object.__setattr__(self, "motor_reference", self.loop.F_r.simulate(self.arm_reference))

    @records("correction")
    def run(self, correction: Array, /) -> TwoMassRun:
        joint, T_s = self.loop.joint, self.loop.sample_time
        A, B = joint.state_space
        friction = np.array([[0.0], [0.0], [0.0], [-1.0 / joint.Jm]])
        A_d, BB_d = zero_order_hold(A, np.hstack((B, friction)), T_s / self.substeps)
        commanded = (self.motor_reference + correction)[:, 0]
        noise = np.zeros_like(commanded)
        if self.noise > 0.0 and self.rng is not None:
            noise = self.rng.normal(0.0, self.noise, len(commanded))
        F = self.loop.F
        b, a = np.zeros(2), np.zeros(2)
        b[: len(F.b)], a[: len(F.a)] = F.b, F.a
        matrices = (np.ascontiguousarray(A_d), BB_d[:, 0].copy(), BB_d[:, 1].copy())
        signals = (commanded, noise)
        motor, arm = _simulator()(*matrices, b, a, *signals, self.coulomb, self.substeps)
        return TwoMassRun(motor[:, None], arm[:, None])


@cache
def _simulator():
    """Loop over samples, compiled at its first use."""
    import numba  # imported here: compilation takes seconds

    return numba.njit(cache=True)(_simulate)


def _simulate(A, B, B_friction, b, a, commanded, noise, coulomb, substeps):  # pragma: no cover
    """Measured motor angle and arm angle, (N,) each, one controller period after the other."""
    n = len(commanded)
    motor, arm = np.empty(n), np.empty(n)
    x = np.zeros(4)
    error_before, voltage = 0.0, 0.0
    for t in range(n):
        motor[t] = x[2] + noise[t]
        arm[t] = x[0]
        error = commanded[t] - motor[t]
        voltage = b[0] * error + b[1] * error_before - a[1] * voltage
        error_before = error
        for _ in range(substeps):
            x = A @ x + B * voltage
            # x[3] is the speed without friction, and this the torque that stops it:
            torque = -x[3] / B_friction[3]
            x = x + B_friction * min(max(torque, -coulomb), coulomb)
    return motor, arm
