"""Friction of servo drives from their runs: the correction that would have had the same effect.

A servo of gain k_p, with integral and derivative action, that moves an inertia against friction F:

    z + kappa sum z + tau dz = F(y) / k_p + c dy + b d^2y,    z = e + q^-delta u

in samples. e, u and y = r - e are measured, F is a sum of stop operators (Prandtl and Ishlinskii),
so every unknown but the delay enters linearly: non-negative least squares for each motor, with the
one delay of all motors that leaves the least. Nothing is chosen, and run 0 says already at which
level a motor sticks. Stops that slip in no run are alike: how they share the friction is arbitrary.
After Al-Bender, Lampaert and Swevers, "The generalized Maxwell-slip model"
(IEEE Trans. Automatic Control 50, 2005), without its velocity weakening.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..records import as_record, records


@records("reference")
def stops(reference: Array, widths: Sequence[float]) -> Array:
    """(N, n, m): stop operators of each column, from -1 to 1: friction before and after it slips.

    A stop of width w follows the reference, divided by w, until it is 1, and waits there until the
    reference turns. Their sums are the hysteresis of Prandtl and Ishlinskii.
    """
    if not all(np.isfinite(w) and w > 0.0 for w in widths):
        raise ValueError(f"widths must be > 0, got {list(widths)}")
    change = np.diff(reference, axis=0, prepend=reference[:1])[:, :, None] / np.array(widths)
    found, state = np.empty_like(change), np.zeros(change.shape[1:])
    for i, step in enumerate(change):
        state = np.clip(state + step, -1.0, 1.0)
        found[i] = state
    return found


FRACTIONS = (1.0, 0.1, 0.01)
"""Widths of the stops: decades of the range of the reference."""
DELAYS = tuple(range(9))
"""Samples that a correction may take to the servo."""


@dataclass(frozen=True, eq=False)
class Friction:
    """Friction of n motors as a correction."""

    widths: Array
    """(n, p), of the stops."""
    size: Array
    """(n, p), >= 0, correction that balances each stop when it slips; as much as the fit explains,
    so that a motor near its encoder's resolution gets little."""
    kappa: Array
    tau: Array
    """(n,), >= 0, integral and derivative action of the servo over its gain [1/sample, sample]."""
    delay: int
    """Samples that a correction comes before the friction that it balances."""

    @records("output")
    def as_correction(self, output: Array) -> Array:
        """(N, n): correction that a motion (N, n) needs to overcome its friction."""
        from scipy.signal import bilinear, lfilter

        F = np.einsum("tnp,np->tn", _stops(output, self.widths), self.size)
        u = np.empty_like(F)
        for j in range(F.shape[1]):  # z of z + kappa sum z + tau dz = F, by the bilinear transform
            b, a = bilinear([1.0, 0.0], [self.tau[j], 1.0, self.kappa[j]], 1.0)
            u[:, j] = lfilter(b, a, F[:, j])
        return u[np.minimum(np.arange(len(u)) + self.delay, len(u) - 1)]


@records("reference")
def friction(reference: Array, runs: Sequence[tuple[Array, Array]]) -> Friction:
    """Friction that explains runs (correction, error), each (N, n), low-pass filtered."""
    runs = [(as_record(u, "a correction"), as_record(e, "an error")) for u, e in runs]
    if not runs or any(x.shape != reference.shape for run in runs for x in run):
        raise ValueError(f"runs must be records of shape {reference.shape}, one or more")
    widths = np.ptp(reference, axis=0)[:, None] * np.array(FRACTIONS)
    moves = [_of_motion(reference - e, widths) for _, e in runs]
    n, p = widths.shape
    tried = [[_fit(moves, runs, j, delay) for j in range(n)] for delay in DELAYS]
    best = int(np.argmin([sum(left for _, left in each) for each in tried]))
    found = np.stack([x for x, _ in tried[best]])
    explained = np.array([[1.0 - left] for _, left in tried[best]])
    size = explained * found[:, :p]
    return Friction(widths, size, found[:, p], found[:, p + 1], DELAYS[best])


def _stops(output: Array, widths: Array) -> Array:
    """(N, n, p). A motor without a range has none."""
    own = np.where(widths > 0.0, widths, np.inf)
    return np.stack([stops(output / own[:, i], (1.0,))[:, :, 0] for i in range(own.shape[1])], 2)


def _of_motion(output: Array, widths: Array) -> Array:
    """(N, n, p + 4): stops, and speed and acceleration of either sign."""
    speed = np.gradient(output, axis=0)
    smooth = np.stack((speed, np.gradient(speed, axis=0)), axis=2)
    return np.concatenate((_stops(output, widths), smooth, -smooth), axis=2)


def _fit(
    moves: Sequence[Array], runs: Sequence[tuple[Array, Array]], j: int, delay: int
) -> tuple[Array, float]:
    """(p + 2,) sizes, kappa, tau of motor j, and the part of z^2 that they leave."""
    from scipy.optimize import nnls

    rows, p = [], moves[0].shape[2] - 4
    for move, (u, e) in zip(moves, runs, strict=True):
        z = e[:, j] + u[np.maximum(np.arange(len(u)) - delay, 0), j]
        z = z - z[0]
        of_servo = np.stack((-np.cumsum(z), -np.gradient(z)), axis=1)
        rows.append(np.concatenate((move[:, j, :p], of_servo, move[:, j, p:], z[:, None]), axis=1))
    R: Array = np.asarray(np.linalg.qr(np.concatenate(rows), mode="r"))
    power = float(R[:, -1] @ R[:, -1])
    if power == 0.0:
        return np.zeros(p + 2), 0.0
    size = np.linalg.norm(R[:, :-1], axis=0)
    size[size == 0.0] = np.inf
    x, left = nnls(R[:, :-1] / size, R[:, -1])
    return (x / size)[: p + 2], left**2 / power
