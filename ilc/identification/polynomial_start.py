"""Starts of a prediction-error fit: linear least squares, refined by prefilters.

Hannan and Rissanen (1982) regress on innovations of a long ARX model; Steiglitz and McBride (1965)
repeat an ARX fit on data filtered by its own denominator, which tends to the output-error model.
Where that ends in a local minimum, the reduction of a long ARX model seldom does.
"""

import numpy as np

from armside.arrays import Array

from ..filters import recursion
from ..records import records
from .polynomial import Orders, Polynomials

_LONG = 20  # orders of the ARX model that gives innovations, at most
_REPEATED = 15
_REALISED = 10, 20, 40
"""Orders of the ARX models that are reduced: with little noise, to little bias. Without them six
output-error and Box-Jenkins fits of 300 random systems ended in a local minimum."""
_HANKEL = 80  # samples of an impulse response that a Hankel matrix covers, twice


@records("u", "y")
def starts(u: Array, y: Array, sample_time: float, orders: Orders) -> list[Polynomials]:
    """Models with stable predictors to start from."""
    dynamics = [_dynamics(u, y, orders, 0)]
    if orders.nf:
        dynamics.append(_dynamics(u, y, orders, _REPEATED))
        dynamics += [one for long in _REALISED for one in _realised(u, y, orders, long)]
    found = [_from_dynamics(*each, u, y, orders) for each in dynamics]
    models = [Polynomials(orders, theta, sample_time) for theta in found]
    return [model.with_stable_predictor() for model in models]


def _dynamics(u: Array, y: Array, orders: Orders, repeats: int) -> tuple[Array, Array]:
    """Denominator A F as one polynomial (1, ...), and the coefficients of B."""
    n, denominator = orders.na + orders.nf, np.ones(1)
    b = np.zeros(orders.nb)
    for _ in range(1 + repeats):
        stable = Polynomials(Orders(nb=1, nk=0, nf=n), np.append(1.0, denominator[1:]), 1.0)
        prefilter = stable.with_stable_predictor().parts["f"] if len(denominator) > 1 else [1.0]
        past_y, past_u = (recursion(np.ones(1), np.asarray(prefilter), s) for s in (y, u))
        columns = [-_back(past_y, i) for i in range(1, n + 1)]
        columns += [_back(past_u, orders.nk + i) for i in range(orders.nb)]
        found = _least_squares(columns, past_y)
        denominator, b = np.append(1.0, found[:n]), found[n:]
    return denominator, b


def _realised(u: Array, y: Array, orders: Orders, long: int) -> list[tuple[Array, Array]]:
    """As `_dynamics`, by Kung's realisation of the impulse response of a long ARX model.

    Empty where the record is too short for that model.
    """
    n, nk = orders.na + orders.nf, orders.nk
    if not (n < long and 3 * (long + nk) <= y.size):
        return []
    past = [_back(y, i) for i in range(1, long + nk + 1)]
    found = _least_squares([*past, *(_back(u, i) for i in range(nk, nk + long + 1))], y)
    a = _stable(np.concatenate(([1.0], -found[: long + nk])))
    f = _stable(_reduced(recursion(found[long + nk :], a, np.eye(2 * _HANKEL, 1))[:, 0], n))
    moved = recursion(np.ones(1), f, u)
    return [(f, _least_squares([_back(moved, nk + i) for i in range(orders.nb)], y))]


def _reduced(impulse: Array, order: int) -> Array:
    """Denominator of the realisation of some order from the Hankel matrix of an impulse response.

    Kung (1978).
    """
    rows = np.arange(_HANKEL)
    U, size, _ = np.linalg.svd(impulse[rows[:, None] + rows])
    observed = U[:, :order] * np.sqrt(size[:order])
    A = np.linalg.lstsq(observed[:-1], observed[1:], rcond=None)[0]
    return np.poly(A).real.astype(np.float64)


def _from_dynamics(denominator: Array, b: Array, u: Array, y: Array, orders: Orders) -> Array:
    """theta: the denominator for A or F, which both have where it is split by slow poles."""
    f, a = _split(denominator, orders)
    numerator = np.concatenate((np.zeros(orders.nk), b))
    v = recursion(a, np.ones(1), y) - recursion(numerator, _stable(f), u)
    c, d = _noise(v, u, y, orders)
    return np.concatenate((a[1:], b, c, d, f[1:]))


def _split(denominator: Array, orders: Orders) -> tuple[Array, Array]:
    if not orders.na or not orders.nf:
        one = np.ones(1)
        return (denominator, one) if orders.nf else (one, denominator)
    f = np.zeros(orders.nf + 1)
    f[0] = 1.0
    return f, denominator[: orders.na + 1]


def _stable(f: Array) -> Array:
    orders = Orders(nb=1, nk=0, nf=len(f) - 1)
    return Polynomials(orders, np.append(1.0, f[1:]), 1.0).with_stable_predictor().parts["f"]


def _noise(v: Array, u: Array, y: Array, orders: Orders) -> tuple[Array, Array]:
    """C and D of the disturbance, with innovations of a long model of it."""
    if not orders.nc and not orders.nd:
        return np.zeros(0), np.zeros(0)
    long = min(_LONG, len(v) // 10)
    past = [_back(v, i) for i in range(1, long + 1)]
    e = v - _predicted(past, v)
    columns = [-_back(v, i) for i in range(1, orders.nd + 1)]
    columns += [_back(e, i) for i in range(1, orders.nc + 1)]
    found = _least_squares(columns, v)
    return found[orders.nd :], found[: orders.nd]


def _predicted(columns: list[Array], target: Array) -> Array:
    if not columns:
        return np.zeros_like(target)
    found = _least_squares(columns, target)
    return np.stack(columns, axis=2) @ found


def _least_squares(columns: list[Array], target: Array) -> Array:
    regressor = np.stack([column.ravel() for column in columns], axis=1)
    return np.asarray(np.linalg.lstsq(regressor, target.ravel(), rcond=None)[0], dtype=np.float64)


def _back(signal: Array, samples: int) -> Array:
    return np.concatenate((np.zeros((samples, signal.shape[1])), signal))[: len(signal)]
