"""Error parameters that a set of configurations tells apart, and the poses to measure next.

Next poses are D-optimal: they have the largest growth of the determinant of the information.
"""

from typing import NamedTuple

import numpy as np

from armside.arrays import Array

from ..dh import Limits
from ..regressor import independent_columns
from .error_model import DH, ErrorModel
from .fit import (
    Choice,
    Fit,
    Priors,
    in_base,
    jacobian_of_points,
    make_problem,
    residuals_and_jacobian,
)
from .measurements import Measurements, register

DEPENDENT = 1e-7
"""Part of a column that is left after projection, below which it depends on the earlier ones."""
WEAK = 1e-2
"""Singular value, relative to the largest, below which a combination is poorly seen."""
NAMED = 0.3
"""Component of a unit vector from which a parameter is named as part of a combination."""


class Dependence(NamedTuple):
    """A redundant parameter, and those that have the same effect together."""

    name: str
    same_as: tuple[str, ...]


class Spectrum(NamedTuple):
    """Singular values of an identification Jacobian with columns of equal norm."""

    rank: int
    values: Array
    """In falling order, relative to the largest."""
    weakest: tuple[str, ...]
    """Parameters of the combination that is seen worst."""

    @property
    def smallest(self) -> float:
        """Smallest singular value of those that are not zero."""
        return float(self.values[self.rank - 1])


def _normalised(J: Array) -> Array:
    """Triangular factor of J (rows, P) with columns of length 1: their inner products in P rows."""
    length = np.linalg.norm(J, axis=0)
    return np.asarray(np.linalg.qr(J / np.where(length > 0.0, length, 1.0), mode="r"))


def _dependence(R: Array, names: list[str], index: int, earlier: list[int]) -> Dependence:
    """What a column is explained by, of those chosen before it."""
    weight = np.linalg.lstsq(R[:, earlier], R[:, index], rcond=None)[0]
    same = np.abs(weight) > 1e-3 * max(np.abs(weight).max(initial=0.0), 1e-6)
    parts = zip(earlier, same, strict=True)
    return Dependence(names[index], tuple(names[k] for k, is_part in parts if is_part))


def spectrum(J: Array, names: list[str]) -> Spectrum:
    """Rank and singular values of J (rows, P), each column divided by its norm."""
    _, values, vt = np.linalg.svd(_normalised(J))
    values = values / values[0]
    rank = int((values > DEPENDENT).sum())
    direction = np.abs(vt[rank - 1])
    weakest = tuple(names[i] for i in np.argsort(-direction) if direction[i] > NAMED)
    return Spectrum(rank, values, weakest or (names[int(direction.argmax())],))


MOST = 500
"""Configurations that a rank is computed from; more change no digit that is printed."""


class Identifiable(NamedTuple):
    """Parameters of the links to fit, and what was found about all of them."""

    geometry: tuple[str, ...]
    redundant: list[Dependence]
    all: Spectrum
    """Of all parameters: its rank is the number of parameters that can be identified."""
    chosen: Spectrum
    """Of those that are fitted, with base, tool and targets."""


def identifiable(
    model: ErrorModel, data: Measurements, wanted: tuple[str, ...] = ()
) -> Identifiable:
    """Independent error parameters: Denavit-Hartenberg before Hayati's, from the base on.

    wanted: parameters of the links to choose from; all by default.

    Raises ValueError: a parameter that is wanted does not exist, or is redundant.
    """
    for name in wanted:
        if name.startswith(("base_", "tool_")):
            raise ValueError(f"{name} is always fitted: name parameters of links alone")
        model.index(name)
    dh = [name for name in model.names if name.rpartition("_")[0] in DH]
    links = (*dh, *(name for name in model.names if name.startswith("beta_")))
    J, names = identification_jacobian(model, data, links)
    if wanted:
        kept = [i for i, name in enumerate(names) if name in wanted or name not in links]
        J, names = J[:, kept], [names[i] for i in kept]
    R = _normalised(J)
    columns = independent_columns(R, DEPENDENT)
    others = [i for i in range(len(names)) if i not in columns]
    redundant = [_dependence(R, names, i, [k for k in columns if k < i]) for i in others]
    if wanted and redundant:
        name, same = redundant[0]
        text = f"{name} cannot be told from {', '.join(same) or 'no effect at all'} in these poses"
        raise ValueError(f"redundant parameters: {text}; leave one out")
    chosen = [names[i] for i in columns]
    geometry = tuple(name for name in chosen if name in links)
    return Identifiable(geometry, redundant, spectrum(J, names), spectrum(J[:, columns], chosen))


def identification_jacobian(
    model: ErrorModel, data: Measurements, links: tuple[str, ...]
) -> tuple[Array, list[str]]:
    """Derivatives of all coordinates for the nominal robot, (rows, P), and their parameters.

    Base, tool and targets stand first: what a link shares with them is theirs.
    """
    rows = np.unique(np.linspace(0, len(data) - 1, min(MOST, len(data))).astype(int))
    data = data[rows]
    registration = register(model.nominal_pose(data.phi), data)
    own = in_base(registration, data)
    problem = make_problem(model, registration, own, Choice(links), Priors())
    r, J = residuals_and_jacobian(problem, np.zeros(len(problem.scale)), slice(0, len(data)))
    J = J[np.isfinite(r).all(axis=2)].reshape(-1, len(problem.scale))
    names = problem.names
    order = sorted(range(len(names)), key=lambda i: names[i] in links)
    return J[:, order], [names[i] for i in order]


CANDIDATES = 1000


def next_poses(fit: Fit, limits: Limits, number: int, rng: np.random.Generator) -> Array:
    """Motor angles (number, n) of poses that tell most about the parameters of a fit.

    Greedy choice among random configurations within the limits; each pose is chosen in view of
    what was measured and of those chosen before it.
    """
    drawn = rng.uniform(limits.lower, limits.upper, (CANDIDATES, len(limits.lower)))
    candidates = drawn[limits.contain(drawn)]
    J, covariance = jacobian_of_points(fit, candidates) / fit.noise, fit.covariance.copy()
    chosen: list[int] = []
    for _ in range(number):
        seen = J @ covariance
        gain = np.linalg.slogdet(np.eye(3) + seen @ np.swapaxes(J, 1, 2))[1]
        gain[chosen] = -np.inf
        best = int(gain.argmax())
        chosen.append(best)
        K = np.linalg.solve(np.eye(3) + J[best] @ seen[best].T, seen[best])
        covariance -= seen[best].T @ K
    return candidates[chosen]
