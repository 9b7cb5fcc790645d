"""Which error parameters a set of configurations can tell apart."""

from typing import NamedTuple

import numpy as np

from armside.arrays import Array

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


class Independent(NamedTuple):
    """Columns in order that are linearly independent, and the others."""

    columns: list[int]
    dependent: list[Dependence]


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


def independent(J: Array, names: list[str]) -> Independent:
    """Greedy choice of columns of J (rows, P): each is taken unless the earlier ones explain it."""
    length = np.linalg.norm(J, axis=0)
    # The triangular factor has the same inner products in at most P rows.
    R: Array = np.asarray(np.linalg.qr(J / np.where(length > 0.0, length, 1.0), mode="r"))
    basis = np.empty((len(R), 0))
    chosen: list[int] = []
    dependent: list[Dependence] = []
    for i, column in enumerate(R.T):
        rest = column - basis @ (basis.T @ column)
        rest -= basis @ (basis.T @ rest)  # a second pass keeps the basis orthogonal
        if (left := np.linalg.norm(rest)) > DEPENDENT:
            chosen.append(i)
            basis = np.column_stack([basis, rest / left])
        else:
            weight = np.linalg.lstsq(R[:, chosen], column, rcond=None)[0]
            same = np.abs(weight) > 1e-3 * max(np.abs(weight).max(initial=0.0), 1e-6)
            with_effect = tuple(
                names[k] for k, is_part in zip(chosen, same, strict=True) if is_part
            )
            dependent.append(Dependence(names[i], with_effect))
    return Independent(chosen, dependent)


def spectrum(J: Array, names: list[str]) -> Spectrum:
    """Rank and singular values of J (rows, P), each column divided by its norm."""
    length = np.linalg.norm(J, axis=0)
    R = np.asarray(np.linalg.qr(J / np.where(length > 0.0, length, 1.0), mode="r"))
    _, values, vt = np.linalg.svd(R)
    values = values / values[0]
    rank = int((values > DEPENDENT).sum())
    direction = np.abs(vt[rank - 1])
    weakest = tuple(names[i] for i in np.argsort(-direction) if direction[i] > NAMED)
    return Spectrum(rank, values, weakest or (names[int(direction.argmax())],))
