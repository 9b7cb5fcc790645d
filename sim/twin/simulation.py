"""Runs of twins: many individuals of a design make the same cut in one rollout."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256

from armside.arrays import Array

from ..cell import CELLS
from ..estimation.relative_path import relative_to_start
from ..robot.effects import available
from ..robot.individual import Individual, embodied, with_payload
from ..robot.kinematics_check import cell_model
from ..robot.model import RobotModel
from ..robot.recording import Recording
from ..robot.run import LoadedReference, cores, run_batch
from ..robot.statics import Statics
from ..robot.virtual_robot import VirtualRobot
from .bending import bent, with_bending


@dataclass(frozen=True)
class RobotDesign:
    """Design of a robot with its tool: what every individual of it is built on."""

    model: RobotModel = field(repr=False)
    payload: float | None = None
    """[kg]; that of the model if None."""
    nominal: RobotModel | None = field(default=None, repr=False)
    """Model of the controller; the design if None."""

    def load(self, individual: Individual, reference: Array) -> LoadedReference:
        """A reference (N, 6) [rad] loaded into an individual of the design."""
        return self._load_all([individual], reference)[0]

    def _load_all(
        self, individuals: Sequence[Individual], reference: Array
    ) -> list[LoadedReference]:
        """As `load`; the controller, which is the same for all, computes its part once."""
        nominal = Statics(self.nominal or self.model)
        robots = [self._robot(individual, nominal, reference) for individual in individuals]
        commanded = robots[0].commanded(reference)
        return [robot.load(commanded) for robot in robots]

    def _robot(self, individual: Individual, nominal: Statics, reference: Array) -> VirtualRobot:
        model = embodied(
            bent(self.model, individual.hidden),
            replace(individual, hidden=()),
            available(self.model),
            phi=reference[0],
            payload=self.payload,
        )
        return VirtualRobot(model, nominal=nominal)

    def run(
        self, individuals: Sequence[Individual], reference: Array, correction: Array
    ) -> list[Recording]:
        """Noise-free runs of the same cut by several individuals, on all cores."""
        loaded = self._load_all(individuals, reference)
        n = len(loaded)
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
