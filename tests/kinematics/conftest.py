"""Generated code without its compiler, and robots with random numbers."""

from collections.abc import Callable

import numpy as np
import pytest

from armside.kinematics import Convention, Joint, Link, Robot
from armside.kinematics.codegen.languages import interpreted as interpreted_program
from armside.kinematics.equations.inertial_model import Body, InertialModel, Motor


@pytest.fixture(scope="session")
def interpreted() -> Callable[..., Callable[..., np.ndarray]]:
    """A program as a Python function: the text that numba would compile, run by Python."""
    return interpreted_program


def make_robot(
    rng: np.random.Generator, n: int, convention: Convention, square: bool = False
) -> Robot:
    """Any joints, short numbers, a coupling of neighbours, constant links here and there.

    square: twists of 0 and 90 degrees only, which keeps fully symbolic dynamics small.
    """
    links = []
    for _ in range(n):
        joint = rng.choice([Joint.REVOLUTE] * 2 + [Joint.PRISMATIC])
        theta, d, a, alpha = rng.uniform(-1, 1, 4).round(2)
        if square:
            alpha = rng.choice([0.0, np.pi / 2, -np.pi / 2])
        links.append(Link(theta, d, a, alpha, joint=joint))
        if rng.random() < 0.2 and not square:
            links.append(Link(*rng.uniform(-1, 1, 4).round(2), joint=Joint.FIXED))
    coupling = np.eye(n) + np.diag(rng.uniform(-0.5, 0.5, n - 1).round(2), -1) if n > 1 else None
    return Robot(links, coupling, rng.uniform(-1, 1, n).round(2), convention)


def make_body(rng: np.random.Generator) -> Body:
    """Ten point masses, so that the inertia is that of a real body."""
    points, masses = rng.normal(0, 0.2, (10, 3)), rng.uniform(0.1, 1.0, 10)
    com = masses @ points / masses.sum()
    r = points - com
    tensor = np.einsum("k,kij->ij", masses, (r**2).sum(1)[:, None, None] * np.eye(3)) - (
        (masses[:, None] * r).T @ r
    )
    i = tensor
    inertia = (i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2])
    return Body(mass=masses.sum().round(2), com=tuple(com.round(2)), inertia=np.round(inertia, 3))


def make_model(rng: np.random.Generator, robot: Robot) -> InertialModel:
    motors = [
        Motor(
            inertia=rng.uniform(0.1, 1),
            viscous=rng.uniform(0, 1),
            coulomb=rng.uniform(0, 1),
            stiffness=rng.uniform(50, 100),
            damping=rng.uniform(0.1, 1),
        )
        for _ in range(robot.n_joints)
    ]
    return InertialModel(
        robot, [make_body(rng) for _ in robot.links], motors, tuple(rng.normal(size=3) * 5)
    )


@pytest.fixture(scope="session")
def random_robot():
    return make_robot


@pytest.fixture(scope="session")
def random_model():
    return make_model


@pytest.fixture(scope="session")
def central() -> Callable[..., np.ndarray]:
    """Jacobian of a function of a vector by central differences."""

    def differences(function, x: np.ndarray, h: float = 1e-6) -> np.ndarray:
        columns = [(function(x + h * e) - function(x - h * e)) / (2 * h) for e in np.eye(len(x))]
        return np.stack(columns, axis=-1)

    return differences
