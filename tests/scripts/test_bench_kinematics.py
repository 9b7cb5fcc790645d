"""Compiled kinematics against Pinocchio where it is installed, and against plain bounds."""

import pytest

from armside.scripts.benchmarks import kinematics as bench_kinematics
from armside.scripts.benchmarks.timing import Row

# Our time as a part of Pinocchio's on idle cores; tests allow three times as much.
LIMITS = {
    "IRB1400 pose": 1.5,
    "IRB1400 Jacobian": 1.0,
    "IRB1400 acceleration": 1.0,
    "LARGE_ROBOT mass matrix": 2.0,
    "LARGE_ROBOT mass matrix, 1000": 1 / 5,
    "LARGE_ROBOT inverse dynamics": 2.0,
    "LARGE_ROBOT inverse dynamics, 1000": 1 / 5,
}


def beside_pinocchio(rows: list[Row]) -> dict[str, float]:
    return {
        row.name: row.ratio
        for row in rows
        if row.ratio is not None and row.peer is not None and row.peer.startswith("Pinocchio")
    }


def test_calls_and_batches_are_within_their_part_of_pinocchio():
    pytest.importorskip("pinocchio", reason="pinocchio (pip install pin) is an optional peer")
    rows = [*bench_kinematics._single_calls(), *bench_kinematics._dynamics()]
    ratios = beside_pinocchio(rows)
    assert ratios.keys() == LIMITS.keys()
    for name, ratio in ratios.items():
        assert ratio <= 3 * LIMITS[name], name


def test_peers_and_ours_compute_the_same():
    import numpy as np

    from armside.kinematics import LARGE_ROBOT, Body, InertialModel, compile, compile_dynamics

    pytest.importorskip("pinocchio", reason="pinocchio (pip install pin) is an optional peer")
    from armside.scripts.benchmarks.peers import pinocchio_dynamics, pinocchio_functions

    phi, rate, rate_dot = np.random.default_rng(0).uniform(-1, 1, (3, 6))
    q = LARGE_ROBOT.joint_variables(phi)
    peer, ours = pinocchio_functions(LARGE_ROBOT), compile(LARGE_ROBOT)
    np.testing.assert_allclose(peer.pose(q), ours.pose(phi), rtol=0, atol=1e-13)
    np.testing.assert_allclose(peer.jacobian(q), ours.jacobian(phi), rtol=0, atol=1e-13)
    np.testing.assert_allclose(
        peer.acceleration(q, rate, rate_dot),
        ours.acceleration(phi, rate, rate_dot),
        rtol=0,
        atol=1e-12,
    )
    body = Body(mass=50.0, com=(-0.1, 0.05, 0.2), inertia=(3.0, 2.5, 2.0, 0.1, -0.2, 0.3))
    model = InertialModel(LARGE_ROBOT, (body,) * 6)
    theirs, dynamics = pinocchio_dynamics(model), compile_dynamics(model)
    D = np.triu(theirs.mass_matrix(q))
    np.testing.assert_allclose(D, np.triu(dynamics.mass_matrix(phi)), rtol=0, atol=1e-11)
    np.testing.assert_allclose(
        theirs.inverse_dynamics(q, rate, rate_dot),
        dynamics.inverse_dynamics(phi, rate, rate_dot),
        rtol=1e-11,
    )
