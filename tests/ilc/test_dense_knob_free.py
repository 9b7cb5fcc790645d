"""The friction of the law without knobs beside dense references: every active set, matrices.

One to six motors, orders 1 to 14, poles to 0.995, damping to 1e-4; CI tries ten times as many.
"""

from itertools import chain, combinations

import numpy as np
from hypothesis import strategies as st

from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.identification.friction import DELAYS, FRACTIONS, friction
from armside.ilc.identification.impulse_response import Sums, correlation_time, impulse_response
from armside.ilc.laws.knob_free import FIRST, KnobFree

from .dense_filters import low_pass, shifted
from .random_cases import AGREED, ONE_MOTOR, T_S, on_plants

CONDITIONED = 1e5
"""Of the columns, up to which runs determine the friction: stops that slip in no run are alike."""
CUTOFF = 25.0


def stop(y, width):
    """(N,) a stop of one motion, sample by sample."""
    found, state = np.zeros(len(y)), 0.0
    for i in range(1, len(y)):
        state = min(1.0, max(-1.0, state + (y[i] - y[i - 1]) / width))
        found[i] = state
    return found


def held(y, width):
    return stop(y, width) if width > 0.0 else 0.0 * y


def runs_of_a_servo(rng, n_samples, n, count, T):
    """Reference and runs of a plant with friction, (N, n) each."""
    Q = low_pass(n_samples, 8.0)
    r = np.cumsum(Q @ rng.standard_normal((n_samples, n)), axis=0)
    runs = []
    for _ in range(count):
        u = 0.1 * np.abs(r).max() * Q @ rng.standard_normal((n_samples, n))
        stuck = [held(r[:, j], 0.02 * np.ptp(r[:, j])) for j in range(n)]
        y = T.simulate(r + u - 0.1 * np.abs(r).max() * np.stack(stuck, axis=1))
        runs.append((u, r - Q @ y))
    return r, runs


def columns(r, runs, j, delay):
    """Stops, servo, speed and acceleration of motor j in all runs; right side z."""
    rows, right = [], []
    for u, e in runs:
        y = r[:, j] - e[:, j]
        late = np.concatenate((np.full(delay, u[0, j]), u[: len(u) - delay, j]))
        z = e[:, j] + late
        z = z - z[0]
        speed = np.gradient(y)
        stuck = [held(y, w * np.ptp(r[:, j])) for w in FRACTIONS]
        servo = [-np.cumsum(z), -np.gradient(z)]
        rows.append(np.column_stack([*stuck, *servo, speed, np.gradient(speed)]))
        right.append(z)
    return np.concatenate(rows), np.concatenate(right)


def bounded(A, z):
    """(5,) of the least squares with the first five >= 0, by every set of those that are 0; the
    part of z^2 that is left, and the condition of the columns."""
    size = np.linalg.norm(A, axis=0)
    kept = np.flatnonzero(size > 0.0)
    least, best, one = np.inf, np.zeros(7), A[:, kept] / size[kept]
    bound = [i for i, column in enumerate(kept) if column < 5]
    free = [i for i, column in enumerate(kept) if column >= 5]
    every = chain.from_iterable(combinations(bound, k) for k in range(len(bound) + 1))
    for chosen in every:
        at = [*chosen, *free]
        x = np.linalg.lstsq(one[:, at], z)[0]
        left = float(np.square(z - one[:, at] @ x).sum() / (z @ z))
        if (x[: len(chosen)] >= 0.0).all() and left < least:
            least, best = left, np.zeros(7)
            best[kept[at]] = x / size[kept[at]]
    return best[:5], least, np.linalg.cond(one)


@on_plants(5, ONE_MOTOR, n=st.sampled_from([1, 2, 6]), count=st.integers(1, 3))
def test_friction_is_the_best_of_every_active_set_and_every_delay(n, count, case):
    rng, T, _, n_samples = case
    r, runs = runs_of_a_servo(rng, n_samples, n, count, T)
    found = friction(r, runs)
    every = [[bounded(*columns(r, runs, j, delay)) for j in range(n)] for delay in DELAYS]
    left = np.array([[one[1] for one in each] for each in every])
    chosen = DELAYS.index(found.delay)
    assert left[chosen].sum() <= left.sum(axis=1).min() + AGREED
    for j, (x, rest, condition) in enumerate(every[chosen]):
        if condition > CONDITIONED:
            continue
        scale = np.linalg.norm(columns(r, runs, j, found.delay)[0], axis=0)[:5]
        ours = np.append(found.size[j], (found.kappa[j], found.tau[j]))
        theirs = np.append((1.0 - rest) * x[:3], x[3:])
        assert np.linalg.norm(scale * (ours - theirs)) <= AGREED * np.linalg.norm(scale * theirs)


def as_correction(model, y):
    """By matrices of the trapezoidal rule: (1 + kappa / D + tau D) z = F, F early by the delay."""
    one, S = np.eye(len(y)), shifted(len(y), -1, hold=False)
    D = 2.0 * np.linalg.solve(one + S, one - S)
    integral = 0.5 * np.linalg.solve(one - S, one + S)
    z = np.empty_like(y)
    for j in range(y.shape[1]):
        force = sum(
            size * held(y[:, j], width)
            for size, width in zip(model.size[j], model.widths[j], strict=True)
        )
        z[:, j] = np.linalg.solve(one + model.kappa[j] * integral + model.tau[j] * D, force)
    return shifted(len(y), model.delay) @ z


@on_plants(5, ONE_MOTOR, st.sampled_from([50, 51, 160, 400]), n=st.integers(1, 6))
def test_an_update_that_knows_friction_is_that_of_its_matrices(n, case):
    """The second update: friction out of the changes, and what the reference needs added."""
    rng, T, _, n_samples = case
    r, runs = runs_of_a_servo(rng, n_samples, n, 2, T)
    law = KnobFree(Q=ZeroPhaseButterworth(CUTOFF, T_S), n_taps=20, reference=r)
    (u0, e0), (u1, e1) = runs
    _, memory = law.step(u0, e0)
    found, _ = law.step(u1, e1, memory)

    Q = low_pass(n_samples, CUTOFF)
    smooth = [(Q @ u, Q @ e) for u, e in runs]
    model = friction(r, smooth)
    rows = [columns(r, smooth, j, model.delay) for j in range(n)]
    if max(bounded(*each)[2] for each in rows) > CONDITIONED:
        return
    needed = [as_correction(model, r - Q @ e) for _, e in runs]
    best = int(np.linalg.norm(e1) < np.linalg.norm(e0))
    acting, seen = u1 - u0 - (needed[1] - needed[0]), e0 - e1
    size = np.linalg.norm(u1 - u0, axis=0)
    response = impulse_response(Sums.none(20).with_records(acting / size, seen / size))
    shifts = [shifted(n_samples, -i, hold=False) for i in range(20)]
    G = sum(g * S for g, S in zip(response.taps, shifts, strict=True))
    certainty = correlation_time(seen - G @ acting)
    w, V = np.linalg.eigh(response.covariance)
    spread = np.einsum("ik,iab->kab", V * np.sqrt(np.maximum(w, 0.0)), np.stack(shifts))
    H = G.T @ G + certainty * sum(M.T @ M for M in spread)
    H += 1e-9 * H.diagonal().max() * np.eye(n_samples)
    step = np.linalg.solve(H, G.T @ runs[best][1])
    step = Q @ (step + as_correction(model, r) - needed[best])
    power = np.square(seen).sum(axis=0)
    known = np.maximum(1.0 - np.square(seen - G @ acting).sum(axis=0) / power, 0.0)
    step = (0.5 if best == 0 else 1.0) * step * (FIRST + (1.0 - FIRST) * known)
    assert np.linalg.norm(found - runs[best][0] - step) <= AGREED * np.linalg.norm(step)
