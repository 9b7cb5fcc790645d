"""Benchmark of kinematic calibration: fits of a UR10 by the number of poses."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from armside.kinematics import CATALOGUE
from armside.kinematics.calibration import JointErrors, Measurements, Priors
from armside.kinematics.calibration.error_model import ErrorModel
from armside.kinematics.calibration.fit import Choice, Fit, fit
from armside.kinematics.calibration.selection import identifiable

from ._timing import Row, timed

POSES = (1_500, 10_000)
NOISE = 50e-6
"""[m] Of a measured coordinate."""
ERROR = 1e-3
"""[m, rad] Standard deviation of the true geometric errors."""
HARMONIC = 0.2e-3
"""[rad] Amplitude of the true error of each joint, sin(3 q)."""
TARGET = np.array([0.05, 0.03, 0.10])
"""[m] In the tool frame."""


def measured() -> Sequence[Row]:
    """Geometry, and from it geometry with 40 harmonics of each joint and compliance."""
    fits = {}
    for n in POSES:
        data = measurements(n)
        fits[f"geometry, {n:,} poses"] = partial(geometry, data)
        fits[f"40 harmonics from there, {n:,} poses"] = partial(harmonics, data, geometry(data))
    return timed(fits, repeats=5)


def measurements(n: int) -> Measurements:
    """n random poses of a UR10 with geometric errors and errors of its joints."""
    rng, model = np.random.default_rng(0), _model()
    phi = rng.uniform(-2.5, 2.5, (n, 6))
    errors = rng.normal(0.0, ERROR, len(model.names))
    T = model.kinematics(model.variables(phi + HARMONIC * np.sin(3.0 * phi), errors)).pose
    points = T[:, :3, 3] + T[:, :3, :3] @ TARGET + rng.normal(0.0, NOISE, (n, 3))
    return Measurements(phi=phi, points=points[:, None])


def geometry(data: Measurements) -> Fit:
    """Choice of the parameters that can be identified, and their fit."""
    model = _model()
    return fit(model, data, Choice(identifiable(model, data).geometry))


def harmonics(data: Measurements, start: Fit) -> Fit:
    """Fit with joint errors, from a fit of the geometry."""
    choice = Choice(start.problem.choice.geometry, JointErrors(40, True))
    return fit(_model(), data, choice, Priors(noise=start.noise), start)


def _model() -> ErrorModel:
    return ErrorModel(CATALOGUE["ur10"].robot)
