"""Benchmarks of the theory: the search of Fig 8.7, 500 iterations, norm-optimal learning."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy import signal

from armside.ilc import Heuristic, ZeroPhaseButterworth, two_mass_study
from armside.ilc.analysis import largest_gamma
from armside.ilc.filters import butterworth
from armside.ilc.laws.norm_optimal import NormOptimal
from armside.ilc.laws.quadratic import QuadraticCriterion
from armside.ilc.models.conversion import as_state_space
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import Model, SystemMatrix
from armside.ilc.models.two_mass import TwoMassLoop
from armside.scripts.figures.two_mass import FIGURES

from ._timing import Row, interleaved, peak_memory, timed

REPEATS = 5
COUPLED = ((2, 2000), (4, 2000), (6, 1000), (6, 2000), (6, 4000), (12, 2000))
"""Motors and samples of norm-optimal learning with entries that all differ."""


def measured() -> Sequence[Row]:
    """Rows of the benchmark."""
    coupled = [row for m, n in COUPLED for row in _coupled(m, n)]
    stored = [row for n in (6, 12) for row in _state_space(n)]
    rows = [*_search(), *_five_hundred(), *_norm_optimal(), *coupled, *stored]
    return [*rows, *_updates()]


def _search() -> list[Row]:
    sides = (TwoMassLoop().T_motor, TwoMassLoop().T_arm)

    def search() -> None:
        for T_u in sides:
            largest_gamma(T_u, two_mass_study.SHIFTS, two_mass_study.SEARCHED_CUTOFFS)

    return timed({"Fig 8.7: 101 shifts x 99 cutoffs, both sides": search}, REPEATS)


def _five_hundred() -> list[Row]:
    with TemporaryDirectory() as folder:

        def iterate() -> None:
            two_mass_study.learned.cache_clear()
            for name in ("8.9", "8.10"):
                FIGURES[name](Path(folder) / f"{name}.png", 0)

        return timed({"500 iterations, Figs 8.9 and 8.10 drawn": iterate}, REPEATS)


def _norm_optimal() -> list[Row]:
    # Thesis (9.12), and the joint of chapter 8 at the same rate: two kinds of motors.
    servo = System(np.array([0, 0, 0, 0, 0, 0.5083]), np.array([1, -0.4884]), 0.004)
    T_u = SystemMatrix.diagonal([servo, TwoMassLoop(sample_time=0.004).T_motor] * 3)
    return _timed_law(T_u, 2000, "norm-optimal, 2,000 samples x 6 motors")


def _coupled_motors(n: int) -> SystemMatrix:
    """n x n second-order entries that all differ, poles of modulus 0.5 to 0.99."""
    rng = np.random.default_rng(2)

    def entry() -> System:
        radius, angle = rng.uniform(0.5, 0.99), rng.uniform(0.05, 2.8)
        a = np.array([1.0, -2.0 * radius * np.cos(angle), radius**2])
        drawn = System(np.concatenate(([0.0], rng.standard_normal(2))), a, 0.004)
        return drawn * (1.0 / np.abs(drawn.response(np.linspace(0.0, np.pi, 400))).max())

    return SystemMatrix(tuple(tuple(entry() for _ in range(n)) for _ in range(n)))


def _coupled(n: int, n_samples: int) -> list[Row]:
    what = f"norm-optimal, {n_samples:,} samples x {n} coupled motors"
    return _timed_law(_coupled_motors(n), n_samples, what)


def _state_space(n: int) -> list[Row]:
    T_u = as_state_space(_coupled_motors(n))
    return _timed_law(T_u, 2000, f"the same {n} motors as {len(T_u.A)} states, 2,000 samples")


def _timed_law(T_u: Model, n_samples: int, what: str) -> list[Row]:
    weights = QuadraticCriterion(correction=1e-4, change=1e-2)
    u, e = np.random.default_rng(0).standard_normal((2, n_samples, T_u.n_inputs))

    def design() -> NormOptimal:
        return NormOptimal(T_u=T_u, n_samples=n_samples, criterion=weights)

    law = design()
    found = timed({"design": design, "iteration": lambda: law(u, e)}, REPEATS)
    peak = f"peak so far {peak_memory():.2f} GB"
    return [replace(row, name=f"{what}: {row.name}, {peak}") for row in found]


def _updates() -> list[Row]:
    Q = ZeroPhaseButterworth(10.0, 0.004)
    law = Heuristic(Q=Q, gamma=0.9, delta=3)
    u, e = np.random.default_rng(0).standard_normal((2, 380, 6))
    ((b, a),) = butterworth(10.0, 0.004, 2)
    each = [lambda: Q(u), lambda: signal.filtfilt(b, a, u, axis=0, padlen=6), lambda: law(u, e)]
    ours, theirs, update = interleaved(each, REPEATS)
    return [
        Row("Q on 380 samples x 6 motors", ours, "scipy filtfilt", theirs),
        Row("update of (9.2), 380 samples x 6 motors", update),
    ]
