"""How far the two-mass joint may differ from its model before a design fails."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..filters import RecordFilter
from ..models.two_mass import TwoMassJoint, TwoMassLoop
from .criterion import frequency_grid, heuristic_criterion

PARAMETERS = ("k", "d", "Ja", "Jm", "fm", "kt")
"""What is uncertain; the gear ratio is not."""


@dataclass(frozen=True, kw_only=True)
class Design:
    """Gain, shift and filter of the heuristic law."""

    gamma: float
    delta: int
    Q: RecordFilter


def contraction(loop: TwoMassLoop, design: Design, omega: Array | None = None) -> float:
    """sup |Q| |1 - L T_u| on the motor side; infinity if the feedback loop itself is unstable."""
    try:
        T_u = loop.T_motor
        return heuristic_criterion(T_u, design.gamma, design.delta, design.Q, omega).contraction
    except ValueError:
        return np.inf


def contraction_map(
    loop: TwoMassLoop,
    design: Design,
    first: tuple[str, ArrayLike],
    second: tuple[str, ArrayLike],
) -> Array:
    """Contraction over two parameters of the true joint, each a name and factors on it.

    Shape (factors of the first, factors of the second).
    """
    omega = frequency_grid(800)
    (name_1, factors_1), (name_2, factors_2) = (
        (name, np.asarray(factors, dtype=np.float64)) for name, factors in (first, second)
    )
    return np.array(
        [
            [
                contraction(_scaled(loop, {name_1: f_1, name_2: f_2}), design, omega)
                for f_2 in factors_2
            ]
            for f_1 in factors_1
        ]
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class MonteCarlo:
    """Contraction of each sampled joint, and the factors it was sampled with."""

    contraction: Array
    """(n,)."""
    factors: Array
    """(n, number of parameters), in the order of `PARAMETERS`."""

    @property
    def share_converging(self) -> float:
        return float((self.contraction < 1.0).mean())

    def most_harmful(self) -> str:
        """The parameter whose deviation goes along best with the contraction."""
        order = np.argsort(np.argsort(self.contraction))
        deviations = np.abs(np.log(self.factors))
        return PARAMETERS[int(np.argmax(np.abs(np.corrcoef(deviations.T, order)[-1, :-1])))]


def monte_carlo(
    loop: TwoMassLoop, design: Design, spread: float, n: int, rng: np.random.Generator
) -> MonteCarlo:
    """n joints with every parameter multiplied by exp(uniform(-s, s)), s = log(1 + spread)."""
    if not spread > 0.0 or n < 1:
        raise ValueError(f"spread must be > 0 and n >= 1, got {spread} and {n}")
    width = np.log1p(spread)
    factors = np.exp(rng.uniform(-width, width, (n, len(PARAMETERS))))
    omega = frequency_grid(800)
    values = [
        contraction(_scaled(loop, dict(zip(PARAMETERS, row, strict=True))), design, omega)
        for row in factors
    ]
    return MonteCarlo(contraction=np.array(values), factors=factors)


def _scaled(loop: TwoMassLoop, factors: dict[str, float]) -> TwoMassLoop:
    """The loop around another joint; controller and reference filter stay as designed."""
    for name in factors:
        if name not in PARAMETERS:
            raise ValueError(f"Unknown parameter {name!r}. Parameters: {', '.join(PARAMETERS)}")
    joint = loop.joint
    values = {name: getattr(joint, name) * factors.get(name, 1.0) for name in PARAMETERS}
    other = TwoMassJoint(rg=joint.rg, **values)
    return TwoMassLoop(
        joint=other,
        controller=loop.controller,
        reference_model=loop.reference_model or joint,
        arm_reading=loop.arm_reading,
        sample_time=loop.sample_time,
    )
