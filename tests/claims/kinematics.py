"""Generated code and the closed-form inverse at configurations in (-pi, pi) of all motors."""

from collections.abc import Iterator

import numpy as np

from armside.kinematics import IRB1400, LARGE_ROBOT, CompiledRobot, Robot, compile, inverse_branches
from armside.kinematics.rigid import link_transform

from ._engine import Check, Claim, Row, Rows, Tally, all_hold, crossed

ROBOTS = {robot.name: robot for robot in (IRB1400, LARGE_ROBOT)}
CONFIGURATIONS = 1000  # number of configurations for each seed and robot
POSE, INVERSE, DERIVATIVE = 1e-13, 1e-11, 1e-8
"""Greatest errors: rounding of a product, of an inverse, of central differences (h = 1e-6)."""
COLUMNS = {
    "seed": "seed",
    "robot": "robot",
    "pose": "pose against the product of link matrices",
    "inverse": "forward of every inverse branch against its target",
    "missing": "configurations that no branch returns to",
    "derivative": "Jacobian against central differences",
}


def run(case: tuple[int, str], _: Tally) -> Iterator[Row]:
    seed, name = case
    phi = np.random.default_rng(seed).uniform(-np.pi, np.pi, (CONFIGURATIONS, 6))
    yield {"seed": seed, "robot": name} | errors(ROBOTS[name], phi)


def errors(robot: Robot, phi: np.ndarray) -> dict[str, float]:
    """Greatest errors over configurations (N, 6) [rad]."""
    functions = compile(robot)
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
    slope = _differences(functions, phi) - functions.jacobian(phi)[:, :3]
    return {
        "pose": float(np.abs(T - product).max()),
        "inverse": float(np.abs(back).max()),
        "missing": int((np.nanmin(gap, axis=1) > 1e-6).sum()),
        "derivative": float(np.abs(slope).max()),
    }


def _differences(functions: CompiledRobot, phi: np.ndarray, h: float = 1e-6) -> np.ndarray:
    """dp/dphi by central differences, (N, 3, 6)."""
    ahead, behind = (
        np.stack([functions.pose(phi + step)[:, :3, 3] for step in steps], axis=-1)
        for steps in (h * np.eye(6), -h * np.eye(6))
    )
    return (ahead - behind) / (2 * h)


def checks(rows: Rows) -> Iterator[Check]:
    yield all_hold(f"generated poses are exact to {POSE:g}", rows["pose"] <= POSE)
    yield all_hold(f"every branch has its pose to {INVERSE:g}", rows["inverse"] <= INVERSE)
    yield all_hold("one branch is always the original configuration", rows["missing"] == 0)
    exact = rows["derivative"] <= DERIVATIVE
    yield all_hold(f"Jacobians are derivatives to {DERIVATIVE:g}", exact)


CLAIM = Claim(
    title=f"Kinematics at {CONFIGURATIONS} random configurations for each row",
    seeds=10,
    cases=crossed(ROBOTS),
    run=run,
    checks=checks,
    columns=COLUMNS,
)
