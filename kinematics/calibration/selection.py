"""Choice of error parameters that are told apart by the configurations of a measurement."""

from typing import NamedTuple

import numpy as np

from armside.arrays import Array

from .error_model import DH, ErrorModel
from .fit import Choice, Priors, in_base, make_problem, residuals_and_jacobian
from .identifiability import Dependence, Spectrum, independent, spectrum
from .measurements import Measurements
from .registration import register

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

    Args:
        wanted: parameters of the links to choose from; all by default.

    Raises:
        ValueError: a parameter that is wanted does not exist, or is redundant.
    """
    for name in wanted:
        if name.startswith(("base_", "tool_")):
            raise ValueError(f"{name} is always fitted: name parameters of links alone")
        model.index(name)
    J, names = identification_jacobian(model, data, link_parameters(model))
    if wanted:
        kept = [i for i, name in enumerate(names) if name in wanted or name not in model.names]
        kept += [i for i, name in enumerate(names) if name.startswith(("base_", "tool_"))]
        J, names = J[:, sorted(set(kept))], [names[i] for i in sorted(set(kept))]
    found = independent(J, names)
    if wanted and found.dependent:
        name, same = found.dependent[0]
        text = f"{name} cannot be told from {', '.join(same) or 'no effect at all'} in these poses"
        raise ValueError(f"redundant parameters: {text}; leave one out")
    chosen = [names[i] for i in found.columns]
    links = tuple(name for name in chosen if name in link_parameters(model))
    whole = spectrum(J, names)
    return Identifiable(links, found.dependent, whole, spectrum(J[:, found.columns], chosen))


def link_parameters(model: ErrorModel) -> tuple[str, ...]:
    """Error parameters of the links: theta_i, d_i, a_i, alpha_i from the base on, then beta_i."""
    dh = [name for name in model.names if name.rpartition("_")[0] in DH]
    return (*dh, *(name for name in model.names if name.startswith("beta_")))


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
