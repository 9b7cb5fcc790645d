"""Prediction-error method: parameters of a Kalman filter's model from its innovations.

    minimise over theta   sum_i e_i^T S^-1 e_i + N log det S + |(theta - prior) / sd|^2

e are the innovations, S their covariance: twice the negative log-likelihood of the record. An
innovation is a one-step prediction error, so the filter keeps the model in phase with the record; a
fit of the simulated output has a local minimum for every lost cycle of an oscillation. Several
starts guard against the remaining minima.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array

_DIFFERENCE = 1e-4  # finite difference, in standard deviations of the prior
_FIRST_STEPS, _STEPS = 8, 25  # from every start, then from the best ones
_ROUGH, _FINE = 0.05, 1e-3  # decrease of the cost that ends them; 1 is one standard deviation
_KEPT = 3
FAR = 4.0
"""Mean square of theta from its prior, in its standard deviations, above which a minimum is
doubted: right minima of an arm's springs lie at 1.7 to 2.3, wrong ones at 6 to 12."""


class Whitened(NamedTuple):
    """Normalised innovations L^-1 e (N, p), L L^T = S, white with unit variance for a correct
    model, and the terms of log det S: 2 log L_ii, (p,). Rows with a missing channel (NaN) do not
    count.
    """

    innovation: Array
    log_det: ArrayLike


@dataclass(frozen=True, eq=False)
class ParameterEstimate:
    """Parameters (m,) at the smallest minimum found, with their uncertainty."""

    theta: Array
    covariance: Array
    """(m, m), posterior covariance of data and prior."""
    information: Array
    """(m,) in [0, 1]: reduction of each prior variance by the data; 0: no information."""
    cost: float
    innovation: Array
    """(N, p), normalised, at theta."""
    costs: tuple[float, ...]
    """Cost of each start after its first steps."""

    @property
    def standard_deviation(self) -> Array:
        return np.sqrt(np.diag(self.covariance))


def estimate_parameters(
    model: Callable[[Array], Whitened],
    prior: Array,
    prior_sd: Array,
    starts: Sequence[Array],
    further: Sequence[Array] = (),
    beside: Callable[[Array, Array], Whitened] | None = None,
) -> ParameterEstimate:
    """Minimise the prediction error by damped Gauss-Newton from each start, then from the best.

    Args:
        model: normalised innovations of the record at theta (m,).
        beside: of theta and a step that is small: the innovations at their sum to first order, or
            a little better; model(theta + step) if None.
        prior, prior_sd: (m,), mean and standard deviation of the prior.
        starts: each (m,).
        further: starts that are tried too where the minimum found lies `FAR` from the prior.

    Raises:
        RuntimeError: the prediction error, or its derivatives, are not finite at any start.
    """
    stepped = beside or (lambda theta, step: model(theta + step))
    problem = _Problem(model, stepped, prior, prior_sd)
    (theta, cost), costs = _from_starts(problem, starts)
    if further and np.square((theta - prior) / prior_sd).mean() > FAR:
        other, more = _from_starts(problem, further)
        theta, cost = min((theta, cost), other, key=lambda each: each[1])
        costs += more
    if not np.isfinite(min(costs)):
        raise RuntimeError("the prediction error is not finite at any start")
    residual, information, _ = _linearised(problem, theta)
    covariance: Array = np.asarray(np.linalg.inv(information), dtype=np.float64)
    gained = 1.0 - np.diag(covariance) / prior_sd**2
    return ParameterEstimate(theta, covariance, gained, cost, residual.innovation, costs)


class _NoDerivativeError(RuntimeError):
    """A search cannot go on from there."""


class _Problem(NamedTuple):
    """What is minimised; fields as the arguments of `estimate_parameters`."""

    model: Callable[[Array], Whitened]
    beside: Callable[[Array, Array], Whitened]
    prior: Array
    sd: Array


def _from_starts(
    problem: _Problem, starts: Sequence[Array]
) -> tuple[tuple[Array, float], tuple[float, ...]]:
    """The best minimum and its cost, and the cost of each start after its first steps."""
    found = [_search(problem, start, _FIRST_STEPS, _ROUGH) for start in starts]
    ranked = sorted(found, key=lambda each: each[1])[:_KEPT]
    ends = [_search(problem, theta, _STEPS, _FINE) for theta, _ in ranked]
    return min(ends, key=lambda each: each[1]), tuple(cost for _, cost in found)


def _cost(residual: Whitened, theta: Array, prior: Array, sd: Array) -> float:
    if np.isinf(residual.innovation).any():
        return np.inf
    seen = _seen(residual)
    value = (
        np.square(residual.innovation[seen]).sum()
        + seen.sum() * np.sum(np.atleast_1d(residual.log_det))
        + np.square((theta - prior) / sd).sum()
    )
    return float(value) if np.isfinite(value) else np.inf


def _seen(residual: Whitened) -> NDArray[np.bool_]:
    """Rows (N,) that count."""
    return np.asarray(np.isfinite(residual.innovation).all(axis=1))


def _linearised(problem: _Problem, theta: Array) -> tuple[Whitened, Array, Array]:
    """Innovations, the information (m, m) of data and prior, and the gradient of half the cost.

    The information of a Gaussian record about theta_i and theta_j is that of the mean,
    d e^T S^-1 d e, and of the covariance, 1/2 tr(S^-1 dS S^-1 dS). The derivatives of L^-1 e hold
    all of it but 1/4 of the squares of d 2 log L_ii.

    Raises _NoDerivativeError where the model ends to both sides of a parameter.
    """
    model, beside, prior, sd = problem
    here = model(theta)
    seen = _seen(here)
    e, log_det, n = here.innovation[seen].ravel(), np.atleast_1d(here.log_det), int(seen.sum())
    J, d_log_det = np.zeros((e.size, theta.size)), np.zeros((log_det.size, theta.size))
    for i, step in enumerate(np.diag(_DIFFERENCE * sd)):
        for side in (step, -step):  # the other side where the model ends within a step
            there = beside(theta, side)
            if np.isfinite(there.innovation[seen]).all():
                J[:, i] = (there.innovation[seen].ravel() - e) / side[i]
                d_log_det[:, i] = (np.atleast_1d(there.log_det) - log_det) / side[i]
                break
        else:
            raise _NoDerivativeError(f"the prediction error ends within a step of parameter {i}")
    information = J.T @ J + 0.25 * n * d_log_det.T @ d_log_det + np.diag(sd**-2.0)
    gradient = J.T @ e + 0.5 * n * d_log_det.sum(axis=0) + (theta - prior) / sd**2
    return here, information, gradient


def _search(problem: _Problem, start: Array, steps: int, enough: float) -> tuple[Array, float]:
    model, _, prior, sd = problem
    theta, damping = np.array(start, dtype=np.float64), 1e-2
    cost = _cost(model(theta), theta, prior, sd)
    for _ in range(steps if np.isfinite(cost) else 0):
        try:
            _, H, gradient = _linearised(problem, theta)
        except _NoDerivativeError:
            return theta, np.inf
        while damping < 1e6:
            step = -np.linalg.solve(H + damping * np.diag(np.diag(H)), gradient)
            tried = theta + step
            reached = _cost(model(tried), tried, prior, sd)
            if reached < cost:
                break
            damping *= 5.0
        else:
            return theta, cost
        gained, theta, cost = cost - reached, tried, reached
        damping = max(damping / 5.0, 1e-6)
        if gained < enough:
            break
    return theta, cost
