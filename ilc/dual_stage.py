"""Two-stage learning on a joint with elasticity: reference ILC and torque ILC, motor or load side.

W. Chen, M. Tomizuka, IEEE Trans. Control Systems Technology 22(4), 2014. P_u is the model from
torque to the side u that is learned; mu is linear feedforward and feedback torque together.

    r+ = Q(r + g_r P_u^-1 P_m e)            e = q_r - q
    t+ = Q(t + g_u P_u^-1 e_p)              e_p = P_u mu - q

P_u^-1 e_p is computed as mu - P_u^-1 q, both through Q: no integrator of the model is run. The gain
g_u follows |e_p| in acceleration of the load, or velocity of the motor, where P_u is stable.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from armside.arrays import Array

from .filters import Edge, ZeroPhaseButterworth
from .models.elastic_bench import (
    STEP,
    BenchRun,
    Individual,
    Response,
    TwoMass,
    reference,
    run,
)

PAD = 2000
"""Samples of rest on both sides of a record in the frequency domain."""
FROM, TO = 300, 4200
"""Samples of the record whose error is measured: 0.3 to 4.2 s."""


def by_frequency(response: Response, signal: Array) -> Array:
    """Signal (N,) through a response at the frequencies of `laplace`, causal or not.

    The ends are held and blended to zero over the pads.
    """
    n, fade = len(signal), 0.5 + 0.5 * np.cos(np.pi * np.linspace(0.0, 1.0, PAD))
    padded = np.concatenate([signal[0] * fade[::-1], signal, signal[-1] * fade])
    found = np.fft.irfft(response * np.fft.rfft(padded), len(padded))
    return found[PAD : PAD + n]


def laplace(n: int, step: float = STEP) -> Response:
    """s = j omega [rad/s] of a padded record of n samples, one every `step` [s]."""
    return np.asarray(2j * np.pi * np.fft.rfftfreq(n + 2 * PAD, step), dtype=np.complex128)


@dataclass(frozen=True, kw_only=True)
class DualStage:
    """Law with its model; torque: side of torque ILC, none for reference ILC alone."""

    model: TwoMass = field(default_factory=TwoMass)
    torque: str | None = None
    cutoff: float = 30.0
    """Of Q1 [Hz]; its order is not printed."""

    def __post_init__(self) -> None:
        if self.torque not in (None, "motor", "load"):
            raise ValueError(f"torque must be None, motor or load, got {self.torque!r}")

    def runs(self, individual: Individual, count: int = 10) -> Iterator[tuple[Array, BenchRun]]:
        """Load error (N,) [rad] by the load's encoder and signals of runs 1 to `count`."""
        _, wanted = reference()
        model, s = self.model, laplace(len(wanted))
        Q = ZeroPhaseButterworth(self.cutoff, STEP, edge=Edge.REST)
        over_load, inverse_motor = model.motor_over_load(s), model.torque_over_motor(s)
        inverse = inverse_motor if self.torque == "motor" else model.torque_over_load(s)
        # e_p of the motor's velocity, the load's acceleration: 0 where s is.
        stable = np.zeros_like(s)
        stable[1:] = (s if self.torque == "motor" else s**2)[1:] / inverse[1:]

        def smooth(signal: Array) -> Array:
            return Q(signal[:, None])[:, 0]

        r = by_frequency(over_load, wanted)
        t, first, g_u = np.zeros_like(r), None, 0.0
        for _ in range(count):
            linear = by_frequency(inverse_motor, r)
            done = run(individual, r, linear + t)
            error = wanted - done.load
            yield error, done
            if self.torque is not None:
                side = done.motor if self.torque == "motor" else done.load
                mu = smooth(linear + done.feedback)
                unmodelled = mu - by_frequency(inverse, smooth(side))
                size = float(np.linalg.norm(by_frequency(stable, unmodelled)))
                first = size if first is None else first
                g_u = min(4.0 * size / first, 1.0)
                t = smooth(t + g_u * unmodelled)
            r = smooth(r + (1.0 - 0.5 * g_u) * by_frequency(over_load, smooth(error)))


def rms_and_peak(error: Array) -> tuple[float, float]:
    """[mrad], over 0.3 to 4.2 s."""
    seen = 1e3 * error[FROM:TO]
    return float(np.sqrt(np.mean(seen**2))), float(np.abs(seen).max())
