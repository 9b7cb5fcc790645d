"""Flexible two-mass joint of thesis chapter 8: model, controller, closed loops, and plants.

The motor angle q_m is measured and controlled, the arm angle q_a is the performance output behind
the gear ratio r_g. `FrictionPlant` adds Coulomb friction at the motor, tau_C = c sign(q_m'), and
noise on the measured angle (future work of chapter 8).
"""

from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cache, cached_property

import numpy as np

from armside.arrays import Array

from ..records import as_number, as_record, records
from .system import System, require_stable, state_space_to_system, tustin, zero_order_hold, zoh


class ArmReading(Enum):
    """Computation of the arm angle in a discrete simulation."""

    THESIS = "thesis"
    """q_a = G_a(q) q_m, each transfer function discretised separately: half a sample late."""
    STATE = "state"
    """From the discretised state of the whole joint."""


@dataclass(frozen=True, kw_only=True)
class TwoMassJoint:
    """Two inertias with a spring and damper between them, behind a gear. Thesis (8.1), (8.2).

    rg: gear ratio, arm angle per motor angle. Jm, Ja: inertia of motor and arm [kg m^2]. k, d:
    spring [N m/rad] and damper [N m s/rad], arm side. fm: viscous motor friction [N m s/rad]. kt:
    torque constant [N m/V]. Defaults: Table 8.1, a laboratory-scale arm identified by Gunnarsson
    et al. (2007) and tuned there to oscillate visibly.
    """

    rg: float = 0.2
    Jm: float = 0.0021
    Ja: float = 0.0991
    k: float = 5.0
    d: float = 0.25
    fm: float = 0.0713
    kt: float = 0.122

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value >= 0.0 and (value or name in ("d", "fm"))):
                bound = ">=" if name in ("d", "fm") else ">"
                raise ValueError(f"{name} must be {bound} 0, got {value}")

    @property
    def state_space(self) -> tuple[Array, Array]:
        """(A, B) for x = (q_a, q_a', q_m, q_m') and the motor voltage. Thesis (8.3)."""
        rg, Jm, Ja, k, d = self.rg, self.Jm, self.Ja, self.k, self.d
        arm = [-k / Ja, -d / Ja, rg * k / Ja, rg * d / Ja]
        motor = [rg * k / Jm, rg * d / Jm, -(rg**2) * k / Jm, -(self.fm + rg**2 * d) / Jm]
        A = np.array([[0.0, 1.0, 0.0, 0.0], arm, [0.0, 0.0, 0.0, 1.0], motor])
        return A, np.array([[0.0], [0.0], [0.0], [self.kt / Jm]])

    @property
    def motor_transfer(self) -> tuple[Array, Array]:
        """(num, den) of G_m(s), voltage to q_m, descending powers of s. Thesis (8.6)."""
        rg2, Jm, Ja, k, d, fm = self.rg**2, self.Jm, self.Ja, self.k, self.d, self.fm
        third, second = d * Jm + fm * Ja + rg2 * d * Ja, fm * d + k * Jm + rg2 * k * Ja
        den = [Jm * Ja, third, second, fm * k, 0.0]
        return self.kt * np.array([Ja, d, k]), np.array(den)

    @property
    def arm_transfer(self) -> tuple[Array, Array]:
        """(num, den) of G_a(s), q_m to q_a, descending powers of s. Thesis (8.7)."""
        return self.rg * np.array([self.d, self.k]), np.array([self.Ja, self.d, self.k])

    def motor(self, sample_time: float, state: int = 2) -> System:
        """G_m(q), voltage to q_m; to q_a through the whole state for `state` 0."""
        A, B = zero_order_hold(*self.state_space, sample_time)
        return state_space_to_system(A, B, np.eye(4)[[state]], sample_time)

    def arm(self, sample_time: float) -> System:
        """G_a(q), q_m to q_a, q_m held over each sample."""
        return zoh(*self.arm_transfer, sample_time)


@dataclass(frozen=True, kw_only=True)
class PdController:
    """F(s) = K_p + K_d s / (1 + T_f s). Thesis (8.10); defaults (8.11)."""

    Kp: float = 6.0
    Kd: float = 0.274
    Tf: float = 0.075

    def discrete(self, sample_time: float) -> System:
        """F(q), by Tustin. The thesis does not state the method."""
        return tustin([self.Kd + self.Kp * self.Tf, self.Kp], [self.Tf, 1.0], sample_time)


@dataclass(frozen=True, kw_only=True)
class TwoMassLoop:
    """Joint under feedback, with the correction added to the motor reference. Fig 8.2."""

    joint: TwoMassJoint = field(default_factory=TwoMassJoint)
    controller: PdController = field(default_factory=PdController)
    reference_model: TwoMassJoint | None = None
    """Joint that F_r assumes; None: the actual one."""
    arm_reading: ArmReading = ArmReading.THESIS
    sample_time: float = 0.01
    """[s]. Thesis Table 8.1."""

    def __post_init__(self) -> None:
        as_number(self.sample_time, "sample_time", 0.0)

    @property
    def F(self) -> System:
        return self.controller.discrete(self.sample_time)

    @property
    def T_motor(self) -> System:
        """T_{u,m}, correction to q_m. Thesis (8.15). ValueError if the loop is unstable."""
        return (self.joint.motor(self.sample_time) * self.F).feedback()

    @property
    def T_arm(self) -> System:
        """T_{u,a}, correction to q_a. Thesis (8.16)."""
        if self.arm_reading is ArmReading.THESIS:
            return self.joint.arm(self.sample_time) * self.T_motor
        # Both outputs of the joint have the same denominator a: the loop's is a a_F + b_m b_F.
        forward = self.joint.motor(self.sample_time, state=0) * self.F
        return System(forward.b, self.T_motor.a, self.sample_time)

    @property
    def F_r(self) -> System:
        """Arm reference to motor reference, q^-1 / G_a(q). Thesis (8.8), (8.9)."""
        G_a = (self.reference_model or self.joint).arm(self.sample_time)
        # G_a has one sample of delay, as q^-1, which makes the inverse proper
        inverse = System(G_a.a, G_a.b[1:], self.sample_time)
        return require_stable(inverse, "the motor reference filter F_r")

    def with_stiffness_error(self, factor: float = 2.0) -> "TwoMassLoop":
        """Loop whose F_r assumes `factor` times the actual stiffness. Fig 8.11."""
        return replace(self, reference_model=replace(self.joint, k=factor * self.joint.k))


def step_reference(
    n_samples: int = 800, sample_time: float = 0.01, start: float = 1.0, box: int = 40
) -> Array:
    """r_a, shape (N, 1): a unit step through two moving averages of `box` samples. Fig 8.4.

    The move lasts 2 * box samples, constant acceleration and then deceleration. The thesis states
    neither start nor length: these are Simulink's default step time and a length that fits Fig 8.4.
    """
    first = round(start / sample_time)
    last = first + 2 * box
    if first < 0 or last > n_samples:
        needed = f"within the record of {n_samples} samples"
        raise ValueError(f"the move from sample {first} to {last} must lie {needed}")
    step = (np.arange(n_samples) >= first).astype(np.float64)
    average = np.full(box, 1.0 / box)
    return np.convolve(np.convolve(step, average), average)[:n_samples, None]


@dataclass(frozen=True)
class TwoMassRun:
    """Recorded angles of one run, shape (N, 1) each: q_m as measured, and q_a."""

    motor: Array
    arm: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class _Repeated:
    """A joint that repeats one arm reference."""

    loop: TwoMassLoop = field(default_factory=TwoMassLoop)
    arm_reference: Array = field(default_factory=step_reference)
    motor_reference: Array = field(init=False)
    """r_m = F_r r_a, shape (N, 1) as r_a."""
    _T_motor: System = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "arm_reference", as_record(self.arm_reference, "arm_reference"))
        object.__setattr__(self, "motor_reference", self.loop.F_r.simulate(self.arm_reference))
        object.__setattr__(self, "_T_motor", self.loop.T_motor)  # refuses an unstable loop


@dataclass(frozen=True, kw_only=True, eq=False)
class TwoMassPlant(_Repeated):
    """Linear joint that repeats one arm reference; `run` returns a `TwoMassRun`."""

    _to_arm: System = field(init=False, repr=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        loop, from_motor = self.loop, self.loop.arm_reading is ArmReading.THESIS
        # G_a after q_m keeps more digits than T_{u,a}, whose seven poles lie close together.
        to_arm = loop.joint.arm(loop.sample_time) if from_motor else loop.T_arm
        object.__setattr__(self, "_to_arm", to_arm)

    @records("correction")
    def run(self, correction: Array, /) -> TwoMassRun:
        """q_m = T_{u,m} (r_m + u), q_a = T_{u,a} (r_m + u), from rest."""
        commanded = self.motor_reference + correction
        motor = self._T_motor.simulate(commanded)
        from_motor = self.loop.arm_reading is ArmReading.THESIS
        return TwoMassRun(motor, self._to_arm.simulate(motor if from_motor else commanded))


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionPlant(_Repeated):
    """Loop of Fig 8.2 in continuous time, sampled controller, dry friction, noisy encoder.

    Between samples the linear part is exact (zero-order hold over `substeps`). In each substep
    the friction torque is the one that stops the motor, limited to c, so that it sticks without
    chattering. Noise enters the angle that controller and law measure; `run` returns the measured
    motor angle and the exact arm angle.
    """

    coulomb: float = 0.0
    """c [N m], motor side."""
    noise: float = 0.0
    rng: np.random.Generator | None = None
    """Source of noise, whose standard deviation is that of the measured motor angle [rad]."""
    substeps: int = 20

    def __post_init__(self) -> None:
        if not (np.isfinite(self.coulomb) and self.coulomb >= 0.0):
            raise ValueError(f"coulomb must be >= 0 N m, got {self.coulomb}")
        if self.noise < 0.0 or (self.noise > 0.0 and self.rng is None):
            needed = ">= 0 and needs an rng if it is not 0"
            raise ValueError(f"noise must be {needed}, got {self.noise}")
        if self.substeps < 1:
            raise ValueError(f"substeps must be >= 1, got {self.substeps}")
        super().__post_init__()

    @cached_property
    def _held(self) -> tuple[Array, Array, Array]:
        """A, and B of voltage and of the friction torque, over a substep."""
        joint, T_s = self.loop.joint, self.loop.sample_time
        A, B = joint.state_space
        friction = np.array([[0.0], [0.0], [0.0], [-1.0 / joint.Jm]])
        A_d, BB_d = zero_order_hold(A, np.hstack((B, friction)), T_s / self.substeps)
        return np.ascontiguousarray(A_d), BB_d[:, 0].copy(), BB_d[:, 1].copy()

    @records("correction")
    def run(self, correction: Array, /) -> TwoMassRun:
        commanded = (self.motor_reference + correction)[:, 0]
        noise = np.zeros_like(commanded)
        if self.noise > 0.0 and self.rng is not None:
            noise = self.rng.normal(0.0, self.noise, len(commanded))
        F = self.loop.F
        b, a = np.zeros(2), np.zeros(2)
        b[: len(F.b)], a[: len(F.a)] = F.b, F.a
        signals = (commanded, noise)
        motor, arm = _simulator()(*self._held, b, a, *signals, self.coulomb, self.substeps)
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
