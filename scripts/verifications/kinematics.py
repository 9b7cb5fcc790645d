"""`armside verify kinematics`: generated code and the closed-form inverse in random poses."""

from collections.abc import Iterable

import numpy as np

from armside.kinematics import IRB1400, LARGE_ROBOT, CompiledRobot, Robot, compile, inverse_branches
from armside.kinematics.rigid import link_transform
from armside.sim.evaluation.check import Table, all_hold

CONFIGURATIONS = 1000  # number of configurations for each seed and robot
POSE, INVERSE, DERIVATIVE = 1e-13, 1e-11, 1e-8
"""Greatest errors: rounding of a product, of an inverse, of central differences (h = 1e-6)."""


def kinematics(seeds: Iterable[int]) -> Table:
    """Errors over configurations in (-pi, pi) of all motors; one row for each seed and robot."""
    rows = [
        (seed, robot.name, *_row(robot, np.random.default_rng(seed)))
        for seed in seeds
        for robot in (IRB1400, LARGE_ROBOT)
    ]
    pose, inverse, missing, derivative = np.array([row[2:] for row in rows], dtype=float).T
    exact = (derivative <= DERIVATIVE).all()
    return Table(
        f"Kinematics at {CONFIGURATIONS} random configurations for each row",
        (
            *("seed", "robot", "pose against the product of link matrices"),
            "forward of every inverse branch against its target",
            *("configurations that no branch returns to", "Jacobian against central differences"),
        ),
        rows,
        (
            all_hold(f"generated poses are exact to {POSE:g}", (pose <= POSE).all()),
            all_hold(f"every branch has its pose to {INVERSE:g}", (inverse <= INVERSE).all()),
            all_hold("one branch is always the original configuration", (missing == 0).all()),
            all_hold(f"Jacobians are derivatives to {DERIVATIVE:g}", exact),
        ),
    )


def _row(robot: Robot, rng: np.random.Generator) -> tuple[float, float, int, float]:
    functions = compile(robot)
    phi = rng.uniform(-np.pi, np.pi, (CONFIGURATIONS, 6))
    T = functions.pose(phi)
    product = np.broadcast_to(np.eye(4), T.shape)
    q = robot.joint_variables(phi)
    for i, link in enumerate(robot.links):
        product = product @ np.stack([link_transform(link, value) for value in q[:, i]])
    found = inverse_branches(robot, T)
    target, _ = np.nonzero(found.exists)
    back = functions.pose(found.phi[found.exists]) - T[target]
    gap = (found.phi - phi[:, None]) @ robot.coupling.T
    gap = np.abs(gap - 2 * np.pi * np.round(gap / (2 * np.pi))).max(axis=-1)
    missing = int((np.nanmin(gap, axis=1) > 1e-6).sum())
    slope = _differences(functions, phi) - functions.jacobian(phi)[:, :3]
    pose, inverse, derivative = (float(np.abs(e).max()) for e in (T - product, back, slope))
    return pose, inverse, missing, derivative


def _differences(functions: CompiledRobot, phi: np.ndarray, h: float = 1e-6) -> np.ndarray:
    """dp/dphi by central differences, (N, 3, 6)."""
    ahead, behind = (
        np.stack([functions.pose(phi + step)[:, :3, 3] for step in steps], axis=-1)
        for steps in (h * np.eye(6), -h * np.eye(6))
    )
    return (ahead - behind) / (2 * h)
