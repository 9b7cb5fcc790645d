"""Simulation study of thesis chapter 8 on the two-mass joint: designs, learning runs, models."""

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from armside.arrays import Array

from .filters import ALL_PASS, End, RecordFilter, ZeroPhaseButterworth
from .laws.first_order import FirstOrder, Law
from .laws.heuristic import Heuristic
from .laws.model_based import ModelInverse
from .laws.norm_optimal import NormOptimal
from .laws.quadratic import QuadraticCriterion
from .learning import Trial, learn
from .measures.norms import two_norm
from .models.system import System, zoh
from .models.two_mass import FrictionPlant, TwoMassLoop, TwoMassPlant, TwoMassRun

GAMMA, DELTA = 0.9, 5
"""Design variables of Figs 8.8 to 8.12."""
CUTOFFS = (1.0, 6.0, 17.0)
"""Cutoffs of Q in Fig 8.8 [Hz]."""
SHIFTS = np.arange(-50, 51)
"""Shifts searched in Fig 8.7 [samples]."""
LARGEST_GROWTH = 1e100
"""Of an error over its first."""
SEARCHED_CUTOFFS = np.linspace(0.5, 49.5, 99)
"""Cutoffs searched in Fig 8.7 [Hz], in steps of 0.5 Hz; the thesis took 1 Hz."""


@dataclass(frozen=True, eq=False)
class TwoMassLearning:
    """Error norms ||e_m,k|| and ||e_a,k||, shape (K + 1,), over the iterations of one run."""

    motor: Array
    arm: Array
    kept: dict[int, Trial[TwoMassRun]]
    """Trials at k = 0, 1, 2, 5 and the last, by iteration."""
    plant: TwoMassPlant | FrictionPlant


def heuristic(
    cutoff: float | None, delta: int = DELTA, sample_time: float = 0.01, gamma: float = GAMMA
) -> Heuristic:
    """Law of chapter 8; cutoff None: Q = 1. Zeros are shifted in, as in the thesis's code."""
    Q: RecordFilter = ALL_PASS if cutoff is None else ZeroPhaseButterworth(cutoff, sample_time)
    return Heuristic(Q=Q, gamma=gamma, delta=delta, end=End.ZERO)


@dataclass(frozen=True, kw_only=True)
class Study:
    """Joint and design that the figures of chapter 8 are of; by default those of the thesis."""

    loop: TwoMassLoop = field(default_factory=TwoMassLoop)
    gamma: float = GAMMA
    delta: int = DELTA
    cutoff: float = 17.0
    """Of Q, where one design learns [Hz]."""
    law: Law | None = None
    """In place of that design, where one learns; None: the heuristic law."""
    name: str = "heuristic"
    """Of the law."""

    @property
    def is_thesis(self) -> bool:
        """Nothing is another than in the thesis."""
        return self == Study()

    @property
    def plant(self) -> TwoMassPlant:
        """The joint before its first run."""
        return TwoMassPlant(loop=self.loop)

    @property
    def design(self) -> str:
        """Words for the law."""
        if self.law is not None:
            return self.name
        return f"gamma = {self.gamma:g}, delta = {self.delta}, {self.cutoff:g} Hz"

    @property
    def one_heuristic(self) -> Heuristic:
        """The heuristic law of the design, ends of the record mirrored."""
        Q = ZeroPhaseButterworth(self.cutoff, self.loop.sample_time)
        return Heuristic(Q=Q, gamma=self.gamma, delta=self.delta)

    @property
    def one_law(self) -> Law:
        """The law where one learns."""
        return self.law or self.one_heuristic

    def heuristic(self, cutoff: float | None, delta: int | None = None) -> TwoMassLearning:
        """500 updates of the heuristic law with a cutoff [Hz]; None: Q = 1."""
        shift = self.delta if delta is None else delta
        law = heuristic(cutoff, shift, self.loop.sample_time, self.gamma)
        return learned(law, self.loop, 1.0)

    def learned(self, stiffness_factor: float = 1.0) -> TwoMassLearning:
        """500 updates of the law; stiffness_factor: assumed over actual stiffness in F_r."""
        law = self.law or heuristic(self.cutoff, self.delta, self.loop.sample_time, self.gamma)
        return learned(law, self.loop, stiffness_factor)


@lru_cache(maxsize=32)
def learned(law: Law, loop: TwoMassLoop, stiffness_factor: float) -> TwoMassLearning:
    """500 updates on the motor side; stiffness_factor: assumed over actual stiffness in F_r."""
    if stiffness_factor != 1.0:
        loop = loop.with_stiffness_error(stiffness_factor)
    return run(TwoMassPlant(loop=loop), law, 500)


def run(plant: TwoMassPlant | FrictionPlant, law: Law, iterations: int) -> TwoMassLearning:
    """Learning with any law on the motor side of the joint, not stopped where it diverges."""
    motor, arm, kept = [], [], {}
    for trial in learn(
        plant,
        law,
        plant.motor_reference,
        iterations,
        output_of=lambda record: record.motor,
        divergence_ratio=np.inf,
    ):
        motor.append(two_norm(trial.error)[0])
        arm.append(two_norm(plant.arm_reference - trial.result.arm)[0])
        if motor[-1] > LARGEST_GROWTH * motor[0]:
            raise ValueError(
                f"learning diverges: its error is {motor[-1]:.3g} rad at k = {trial.k}"
            )
        if trial.k in (0, 1, 2, 5, iterations):
            kept[trial.k] = trial
    return TwoMassLearning(np.array(motor), np.array(arm), kept, plant)


def algorithms(of: Study = Study()) -> dict[str, Law]:
    """Algorithms 1 to 3 of thesis 7.5 for the motor side, with the study's bandwidth; and its
    law."""
    T_u = of.loop.T_motor
    Q = ZeroPhaseButterworth(of.cutoff, T_u.sample_time)
    inverse = ModelInverse(T_u=T_u, learned=Q, regularisation=1e-6)
    weights = QuadraticCriterion(correction=1e-6, change=1e-4)
    own = {} if of.law is None else {of.name: of.law}
    return {
        "1 heuristic": Heuristic(Q=Q, gamma=of.gamma, delta=of.delta),
        "2 model inverse": FirstOrder(Q=Q, L=inverse),
        "3 norm-optimal": NormOptimal(T_u=T_u, n_samples=800, criterion=weights),
        **own,
    }


def rough_models(loop: TwoMassLoop = TwoMassLoop()) -> dict[str, System]:
    """Models of T_u,m from exact to crude, for L = gamma T^T."""
    joint, F, sample_time = loop.joint, loop.F, loop.sample_time
    inertia = joint.Jm + joint.rg**2 * joint.Ja
    rigid = zoh([joint.kt], [inertia, joint.fm, 0.0], sample_time)
    stiffer = replace(joint, k=4.0 * joint.k).motor(sample_time)

    def lag(delay: int) -> System:
        return System(np.array([0.0] * delay + [0.2]), np.array([1.0, -0.8]), sample_time)

    return {
        "exact": loop.T_motor,
        "stiffness x 4": (stiffer * F).feedback(),
        "rigid, one inertia": (rigid * F).feedback(),
        "lag 0.2/(q - 0.8), delay 1": lag(1),
        "the same, delay 2": lag(2),
    }


def phase_error(model: System, T_u: System, omega: Array) -> Array:
    """Phase of conj(model) T_u [rad], in (-pi, pi].

    If it is below pi/2 at all frequencies, L = gamma model^T with a small enough gamma satisfies
    the criterion with Q = 1.
    """
    return np.angle(np.conj(model.response(omega)) * T_u.response(omega))


def iterations_to(norms: Array, fraction: float) -> int | None:
    """First iteration with at most this fraction of the first error; None: none."""
    below = np.flatnonzero(norms <= fraction * norms[0])
    return int(below[0]) if below.size else None
