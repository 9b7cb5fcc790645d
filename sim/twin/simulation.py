"""Runs of twins: many individuals of a design make the same cut in one rollout; links that bend.

A link bends about the two directions across it. To first order that is a symmetric compliance

    C = (c_1 a_1 a_1^T + ... + c_4 a_4 a_4^T) / k                                     [rad/(N m)]

with directions a_i 45 degrees apart, and a place along the link. Two hinges along the eigenvectors
of C stand for it, as a hidden hinge does in a robot: see `Individual.hidden`. The c_i change the
tool's path linearly, which an angle would not do, and C is a compliance as long as none is < 0.
"""

import copy
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256

import mujoco
import numpy as np

from armside.arrays import Array

from ..cell import CELLS
from ..estimation.relative_path import relative_to_start
from ..robot.drives import OwnDrive
from ..robot.effects import available
from ..robot.individual import HiddenHinge, Individual, embodied, joints, with_hinges, with_payload
from ..robot.kinematics_check import cell_model
from ..robot.model import RobotModel
from ..robot.recording import Recording
from ..robot.run import LoadedReference, cores, run_batch
from ..robot.statics import Statics
from ..robot.virtual_robot import Commanded, VirtualRobot

_DAMPING_TIME = 2e-4
"""Damping over stiffness [s], as for the hinges of the file."""
_STIFFEST = 0.25
"""Least compliance relative to 1/k: what bends less than that does not show."""

DIRECTIONS = np.deg2rad([0.0, 45.0, 90.0, 135.0])
"""Of bending, in the plane across a link [rad]: from the first of its two axes on."""

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class BendingLink:
    """A link that bends."""

    body: str
    end: Vector
    """Of the link, in its own axes [m]."""
    across: tuple[Vector, Vector]
    stiffness: float
    """k [N m/rad]: five times that of the gears beside it. ESTIMATE."""

    def hinges(self, compliance: Array, place: float) -> list[HiddenHinge]:
        """Two hinges for the compliances (4,) about the four directions, at a place along."""
        turns = np.column_stack((np.cos(DIRECTIONS), np.sin(DIRECTIONS)))
        values, vectors = np.linalg.eigh((turns.T * compliance) @ turns)
        axes = vectors.T @ np.array(self.across)
        at, k = tuple(place * np.array(self.end)), self.stiffness / np.maximum(values, _STIFFEST)
        return [
            HiddenHinge(
                body=self.body,
                axis=tuple(axis),
                position=at,
                stiffness=stiffness,
                damping=_DAMPING_TIME * stiffness,
            )
            for axis, stiffness in zip(axes, k, strict=True)
        ]


LINKS = (
    BendingLink("lower_arm", (0.0, 0.0, 1.075), ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), 2e7),
    BendingLink("tube", (1.142, 0.0, 0.0), ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), 6e6),
    BendingLink("tilt", (0.2, 0.0, 0.0), ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)), 3e6),
)
"""Of the large robot; places are in the axes of each body."""
MIDDLE = 0.5
"""Place of the design's hinges, as a fraction of the link."""
MEAN = 0.5
"""Compliance about each direction in the design: two of four make 1/k about every axis."""


def hinges(compliance: Array, place: Array) -> tuple[HiddenHinge, ...]:
    """Hinges of all links.

    compliance: (3, 4), of each about its directions, beyond the design's; place: (3,), beyond the
    middle of the link, as a fraction of its length.
    """
    each = zip(LINKS, MEAN + compliance, MIDDLE + place, strict=True)
    return tuple(hinge for link, *values in each for hinge in link.hinges(*values))


def with_bending(design: RobotModel) -> RobotModel:
    """Design whose links bend. Raises ModelError for a robot that lacks one of the links."""
    n = len(LINKS)
    return with_hinges(design, hinges(np.zeros((n, len(DIRECTIONS))), np.zeros(n)))


def bent(design: RobotModel, hidden: Sequence[HiddenHinge]) -> RobotModel:
    """Design of `with_bending` with the numbers of other hinges on its links, if there are any."""
    if not hidden:
        return design
    mj = copy.copy(design.mj)
    for joint, hinge in zip(joints(mj, "hidden_"), hidden, strict=True):
        mj.jnt_axis[joint] = np.array(hinge.axis) / np.linalg.norm(hinge.axis)
        mj.jnt_pos[joint] = hinge.position
        mj.jnt_stiffness[joint] = hinge.stiffness
        mj.dof_damping[mj.jnt_dofadr[joint]] = hinge.damping
    mujoco.mj_setConst(mj, mujoco.MjData(mj))
    return replace(design, mj=mj)


@dataclass(frozen=True)
class RobotDesign:
    """Design of a robot with its tool: what every individual of it is built on."""

    model: RobotModel = field(repr=False)
    payload: float | None = None
    """[kg]; that of the model if None."""
    nominal: RobotModel | None = field(default=None, repr=False)
    """Model of the controller; the design if None."""
    hysteresis: bool = False
    """Its individuals may have hysteresis of the gears."""

    def besides(self, servo: OwnDrive | None, hysteresis: bool = False) -> "RobotDesign":
        """The design with a servo of its own, the type's if None, and with hysteresis or not."""
        own = replace(self.model, own_drive=servo)
        return replace(self, model=own, hysteresis=hysteresis)

    def commanded(self, reference: Array) -> Commanded:
        """What the controller makes of a reference (N, 6) [rad]."""
        nominal = self.nominal or self.model
        return VirtualRobot(nominal).commanded(reference)

    def load(self, individual: Individual, reference: Array) -> LoadedReference:
        """A reference (N, 6) [rad] loaded into an individual of the design."""
        return self._load_all([individual], reference)[0]

    def _load_all(
        self, individuals: Sequence[Individual], reference: Array
    ) -> list[LoadedReference]:
        """As `load`; the controller, which is the same for all, computes its part once."""
        nominal, known = Statics(self.nominal or self.model), available(self.model)
        robots = []
        for one in individuals:
            base, own = bent(self.model, one.hidden), replace(one, hidden=())
            model = embodied(base, own, known, phi=reference[0], payload=self.payload)
            robots.append(VirtualRobot(model, nominal=nominal))
        commanded = robots[0].commanded(reference)
        return [robot.load(commanded) for robot in robots]

    def run(
        self, individuals: Sequence[Individual], reference: Array, correction: Array
    ) -> list[Recording]:
        """Noise-free runs of the same cut by several individuals, on all cores."""
        loaded, n = self._load_all(individuals, reference), len(individuals)
        return run_batch(loaded, [correction] * n, [None] * n, threads=min(n, cores()))


def design_of(robot: str, payload: float | None) -> RobotDesign:
    """Design of a cell's robot with its links' elasticity and a tool of that mass [kg]."""
    plain = cell_model(CELLS[robot])
    nominal = plain if payload is None else with_payload(plain, payload)
    return RobotDesign(with_bending(plain), payload=payload, nominal=nominal)


def robot_digest(robot: str) -> str:
    """Digest of the robot's file."""
    return sha256(CELLS[robot].xml.read_bytes()).hexdigest()[:16]


def tool_path(recording: Recording) -> Array:
    """(N, 3) [m], displacement of the tool from rest at the instants of the log."""
    every = round(float(recording.time[1] / recording.truth.time[1]))
    return relative_to_start(recording.truth.tool_position[::every])[:, :3]


def motor_path(recording: Recording) -> Array:
    """(N, 6) [rad], exact motor angles at the instants of the log."""
    every = round(float(recording.time[1] / recording.truth.time[1]))
    return recording.truth.motor_angle[::every]
