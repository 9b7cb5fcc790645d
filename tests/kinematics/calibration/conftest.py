from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armside.kinematics import CATALOGUE, compile
from armside.kinematics.calibration import ErrorModel, Measurements
from armside.kinematics.calibration.calibrate import corrected

TARGETS = np.array([[0.05, 0.02, 0.10], [-0.06, 0.03, 0.08], [0.01, -0.08, 0.12]])
R_TRACKER, P_TRACKER = Rotation.from_euler("ZYX", [2.0, 0.3, -0.4]).as_matrix(), [1.5, -2.0, 0.7]


@pytest.fixture(scope="session")
def measured() -> Callable[..., Measurements]:
    """Poses of a robot with known errors, as a tracker in a frame of its own sees them."""

    def build(
        name, n, rng, *, errors=None, targets=1, noise=0.0, rotation=False, joint=None
    ) -> Measurements:
        robot, limits = CATALOGUE[name]
        model = ErrorModel(robot)
        phi = rng.uniform(limits.lower, limits.upper, (n, robot.n_joints))
        e = np.zeros(len(model.names))
        for parameter, value in (errors or {}).items():
            e[model.index(parameter)] = value
        real = compile(corrected(model, e)) if errors else compile(robot)
        T = real.pose(phi if joint is None else phi + joint(phi))
        points = T[:, None, :3, 3] + np.einsum("nij,tj->nti", T[:, :3, :3], TARGETS[:targets])
        points = points @ R_TRACKER.T + P_TRACKER + noise * rng.normal(size=points.shape)
        seen = R_TRACKER @ T[:, :3, :3] if rotation else None
        return Measurements(phi=phi, points=points, rotation=seen)

    return build
