"""Errors of single joint angles as linear combinations of known functions of the configuration.

Harmonics: sin(m q) and cos(m q) of the joint's own variable, which take up whatever smooth error a
joint has. They interpolate: outside the angles that were measured they mean nothing.

Compliance: the torque [N m] about the joint's axis of a mass of 1 kg at the origin of each later
frame, under gravity. A coefficient is compliance times mass [kg rad/(N m)].
"""

from typing import NamedTuple

import numpy as np

from armside.arrays import Array

from ..dh import Joint, Link, Robot
from ..rigid import standard_links

G = 9.82
"""Gravity [m/s^2], along -z of the base."""


class JointErrors(NamedTuple):
    """Choice of functions."""

    harmonics: int = 0
    """Largest order m of the harmonics of each revolute joint; 0 has none."""
    compliance: bool = False

    def names(self, robot: Robot) -> list[str]:
        """Name of each function, in the order of `values`: joint_2 sin 3."""
        return [f"joint_{i} {text}" for i, text in self._list(robot)]

    def joints(self, robot: Robot) -> list[int]:
        """Joint of each function, from 0."""
        return [i - 1 for i, _ in self._list(robot)]

    def _list(self, robot: Robot) -> list[tuple[int, str]]:
        turning = [i for i, slides in enumerate(robot.slides, 1) if not slides]
        orders = range(1, self.harmonics + 1)
        named = [(i, f"{f} {m}") for i in turning for f in ("sin", "cos") for m in orders]
        if self.compliance:
            last = robot.n_joints + 2
            named += [(i, f"sag {k}") for i in turning for k in range(i + 1, last)]
        return named

    def values(self, robot: Robot, phi: Array) -> Array:
        """Functions at motor angles phi (N, n), shape (N, K)."""
        q, turning = robot.joint_variables(phi), np.flatnonzero(~np.array(robot.slides)).tolist()
        orders = np.arange(1, self.harmonics + 1)
        parts = [f(np.outer(q[:, i], orders)) for i in turning for f in (np.sin, np.cos)]
        if self.compliance:
            parts.append(gravity_torques(robot, q, turning))
        return np.concatenate(parts, axis=1) if parts else np.empty((len(phi), 0))


def gravity_torques(robot: Robot, q: Array, turning: list[int]) -> Array:
    """Torques of 1 kg at the origin of each joint frame after joint i and of the tool, (N, K)."""
    T = np.tile(np.eye(4), (len(q), 1, 1))
    axes, origins, variables = [], [], iter(q.T)
    for link in standard_links(robot):
        if link.moves:
            axes.append(T[:, :3, 2])
            origins.append(T[:, :3, 3])
        T = T @ _transforms(link, next(variables) if link.moves else np.zeros(len(q)))
    origins.append(T[:, :3, 3])
    down = np.array([0.0, 0.0, -G])
    torques = [
        np.einsum("ni,ni->n", axes[i], np.cross(origins[k] - origins[i], down))
        for i in turning
        for k in range(i + 1, len(origins))
    ]
    return np.stack(torques, axis=1)


def _transforms(link: Link, variable: Array) -> Array:
    """A_i for each value of the joint variable, (N, 4, 4). Thesis (3.29)."""
    theta = float(link.theta) + variable * (link.joint is Joint.REVOLUTE)
    d = float(link.d) + variable * (link.joint is Joint.PRISMATIC)
    c, s, zero, one = np.cos(theta), np.sin(theta), 0.0 * theta, 1.0 + 0.0 * theta
    a, ca, sa = float(link.a), np.cos(float(link.alpha)), np.sin(float(link.alpha))
    rows = [
        [c, -s * ca, s * sa, a * c],
        [s, c * ca, -c * sa, a * s],
        [zero, sa * one, ca * one, d],
        [zero, zero, zero, one],
    ]
    return np.moveaxis(np.array(rows), -1, 0)
