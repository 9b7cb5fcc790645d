"""Learning laws by name, `heuristic:gamma=0.9,delta=3`, and a user's own, `file.py:Name`."""

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np

from ..laws.first_order import DType, FirstOrder, Law, PType
from ..laws.heuristic import Heuristic
from ..laws.knob_free import KnobFree
from ..laws.memory import (
    Adaptive,
    DisturbanceObserver,
    FrequencyKalman,
    HighOrder,
    internal_model,
    periodic_pattern,
)
from ..laws.model_based import Gradient, ModelInverse
from ..laws.model_free import FiniteDifference, MeasuredGradient, b_splines
from ..laws.norm_optimal import Constrained, NormOptimal, PointToPoint
from ..laws.quadratic import QuadraticCriterion
from ..laws.repetitive import Repetitive
from ..laws.robust import h_infinity as matched
from ..laws.transfer import BasisFunctions, RationalBasis, derivatives
from .own import own_law
from .task import Setting
from .words import Words, converted, unknown_name


def basis(s: Setting, *, order: int = 4, ridge: float = 1e-9) -> Law:
    """Polynomial basis functions: derivatives 1 to `order` of the reference."""
    found = derivatives(s.reference, s.sample_time, order)
    return BasisFunctions(T_u=s.T_u("basis"), basis=found, ridge=ridge)


def rational(s: Setting, *, numerator: int = 4, denominator: int = 2) -> Law:
    """Rational basis functions: so many terms in the numerator and the denominator."""
    return RationalBasis(
        T_u=s.shared_model("rational"),
        reference=s.reference,
        n_numerator=numerator,
        n_denominator=denominator,
    )


def point_to_point(s: Setting, *, times: tuple[float, ...]) -> Law:
    """Right at these times [s] of the record and free between them: times=0.5/1.2."""
    points = [round(time / s.sample_time) for time in times]
    return PointToPoint(
        T_u=s.T_u("point-to-point"), points=points, n_samples=s.n_samples, n_columns=s.n_columns
    )


def repetitive(s: Setting, *, period: int, begin: int = 0, cutoff: float | None = None) -> Law:
    """Laps of `period` samples from sample `begin` on: one periodic correction for all."""
    L = _inverse(s, "repetitive", cutoff)
    return Repetitive(L=L, Q=s.Q(cutoff), period=period, begin=begin)


_TENTH = 0.1  # of the sample rate: beyond it no servo is driven


def heuristic(
    s: Setting, *, gamma: float | None = None, delta: int | None = None, cutoff: float | None = None
) -> Law:
    """Q(u + gamma q^delta e); gamma and delta by the design helper where not given."""
    shifted = _gain(s, gamma, delta)
    return Heuristic(Q=s.Q(cutoff), gamma=shifted.gamma, delta=shifted.delta)


def d_type(s: Setting, *, gamma: float = 0.05, delta: int = 1, cutoff: float | None = None) -> Law:
    """Q(u + gamma de/dt), gamma [s]."""
    L = DType(gamma_d=gamma, sample_time=s.sample_time, delta=delta)
    return FirstOrder(L=L, Q=s.Q(cutoff))


def gradient(s: Setting, *, step: float = 0.0, cutoff: float | None = None) -> Law:
    """Steepest descent with the model's adjoint; step 0: 1 / max |T_u|^2."""
    return FirstOrder(L=Gradient(T_u=s.T_u("gradient"), step=step), Q=s.Q(cutoff))


def inverse(
    s: Setting, *, rate: float = 1.0, regularisation: float = 1e-6, cutoff: float | None = None
) -> Law:
    """Algorithm 2: inverse of the model up to the cutoff."""
    return FirstOrder(L=_inverse(s, "inverse", cutoff, rate, regularisation), Q=s.Q(cutoff))


def norm_optimal(s: Setting, *, correction: float = 1e-6, change: float = 1e-4) -> Law:
    """Algorithm 3: weights of correction and change relative to that of the error."""
    weights = QuadraticCriterion(correction=correction, change=change)
    T_u = s.T_u("norm-optimal")
    return NormOptimal(T_u=T_u, n_samples=s.n_samples, n_columns=s.n_columns, criterion=weights)


def constrained(s: Setting, *, limit: float, correction: float = 1e-6, change: float = 1e-4) -> Law:
    """Algorithm 3 with |u| <= limit."""
    return Constrained(
        T_u=s.T_u("constrained"),
        n_samples=s.n_samples,
        n_columns=s.n_columns,
        criterion=QuadraticCriterion(correction=correction, change=change),
        limit=limit,
    )


def adaptive(
    s: Setting,
    *,
    noise: float,
    disturbance: float,
    gamma: float | None = None,
    delta: int | None = None,
    cutoff: float | None = None,
) -> Law:
    """Gain by a Kalman filter; standard deviations of measurement noise and of the error."""
    return Adaptive(
        L=_gain(s, gamma, delta),
        Q=s.Q(cutoff),
        noise_variance=noise**2,
        initial_variance=disturbance**2,
    )


def high_order(
    s: Setting,
    *,
    alpha: tuple[float, ...] = (1.0, 0.0),
    beta: tuple[float, ...] = (0.6, 0.3),
    delta: int | None = None,
    cutoff: float | None = None,
) -> Law:
    """Several iterations back, weights newest first: alpha=1/0,beta=0.6/0.3."""
    return HighOrder(alpha=alpha, beta=beta, L=_gain(s, 1.0, delta), Q=s.Q(cutoff))


def periodic(s: Setting, *, period: int = 2, pole: float = 0.1, cutoff: float | None = None) -> Law:
    """Internal model of a disturbance that repeats every `period` iterations."""
    L = _inverse(s, "periodic", cutoff)
    return internal_model(periodic_pattern(period), L=L, Q=s.Q(cutoff), pole=pole)


def disturbance_observer(s: Setting, *, order: int = 2, cutoff: float | None = None) -> Law:
    """Disturbance predicted by an autoregressive model over the iterations."""
    L = _inverse(s, "disturbance-observer", cutoff)
    return DisturbanceObserver(L=L, Q=s.Q(cutoff), T_u=L.T_u, order=order)


def model_free(
    s: Setting, *, size: float = 1.0, coupled: int = 0, cutoff: float | None = None
) -> Law:
    """Steepest descent, gradient measured by time reversal: three more runs an update, or with
    coupled=1 two and one for each pair of motors."""
    Q = s.Q(cutoff)
    return MeasuredGradient(experiment=s.experiment, coupled=bool(coupled), size=size, Q=Q)


def splines(s: Setting, *, n: int = 12, size: float = 1e-3) -> Law:
    """Gauss-Newton on n B-splines, responses measured: n runs more an update and column."""
    return FiniteDifference(experiment=s.experiment, basis=b_splines(s.n_samples, n), size=size)


def knob_free(s: Setting) -> Law:
    """Gain, shift and band from the data of the first runs: nothing to choose, no model."""
    return KnobFree(Q=s.Q(_TENTH / s.sample_time), reference=s.reference)


def kalman(s: Setting, *, noise: float, change: float = 0.0, cutoff: float | None = None) -> Law:
    """Noise-optimal gain of each frequency; standard deviations of noise, and of what changes."""
    return FrequencyKalman(L=_inverse(s, "kalman", cutoff), noise=noise, change=change)


def h_infinity(
    s: Setting, *, taps: int = 60, uncertainty: float = 0.2, cutoff: float | None = None
) -> Law:
    """L of the smallest contraction, for a model that is wrong by a fraction `uncertainty`."""
    Q = s.Q(cutoff)
    T_u = s.shared_model("h-infinity")
    return FirstOrder(L=matched(T_u, Q, n_taps=taps, uncertainty=uncertainty), Q=Q)


def _inverse(
    s: Setting, law: str, cutoff: float | None, rate: float = 1.0, regularisation: float = 1e-6
) -> ModelInverse:
    return ModelInverse(
        T_u=s.T_u(law), learned=s.Q(cutoff), rate=rate, regularisation=regularisation
    )


def _gain(s: Setting, gamma: float | None, delta: int | None) -> PType:
    if gamma is None or delta is None:
        proposed = s.proposed
        gamma = proposed[0] if gamma is None else gamma
        delta = proposed[1] if delta is None else delta
    return PType(gamma=gamma, delta=delta)


LAWS: dict[str, Callable[..., Law]] = {
    build.__name__.replace("_", "-"): build
    for build in (
        *(heuristic, d_type, gradient, inverse, norm_optimal, constrained, adaptive, high_order),
        *(periodic, disturbance_observer, model_free, splines, knob_free, basis, rational),
        *(point_to_point, kalman, repetitive, h_infinity),
    )
}
"""By name; keyword-only parameters are those of the command line."""
MEASURING = ("model-free", "splines")
"""Laws that run the plant beside the loop's own runs."""


def build_law(text: str, setting: Setting) -> Law:
    """The law that the words name, checked against the record.

    Raises ValueError for a name, parameter or value that does not exist or does not fit, and
    OwnCodeError for what a user's file raises.
    """
    words = Words.parse(text)
    if words.file:
        law = own_law(words, setting)
    elif words.name in LAWS:
        law = _named(words, setting)
    else:
        raise ValueError(unknown_name("law", words.name, (*LAWS, "file.py:Name")))
    law.check(setting.n_samples, setting.n_columns)
    return law


def _named(words: Words, setting: Setting) -> Law:
    build = LAWS[words.name]
    try:
        values: dict[str, Any] = converted(words.parameters, build)
        missing = [
            name
            for name, each in inspect.signature(build).parameters.items()
            if each.kind is each.KEYWORD_ONLY and each.default is each.empty and name not in values
        ]
        if missing:
            raise ValueError(f"needs {' and '.join(f'{name}=NUMBER' for name in missing)}")
        return build(setting, **values)
    except (ValueError, np.linalg.LinAlgError) as error:
        raise ValueError(f"law {words.text}: {error}") from error
