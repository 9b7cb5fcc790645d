"""What a twin by IMU and motors lacks, block by block; twelve tasks.

A twin of each individual of development is given the truth of one block of its parameters at a
time. "Left" is the tool error if the correction of a first run cancelled exactly what the twin
predicts: of the programmed path plus robot less twin, both without correction, over that of the
robot. It takes one run where learning takes nine, and is near what learning leaves.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from armside.arrays import Array
from armside.sim.evaluation.tool_error import tool_error
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.experiment import prepare
from armside.sim.laser.specification import Cut
from armside.sim.motion.tool_motion import ToolMotion, motion_notes
from armside.sim.robot.individual import Individual
from armside.sim.robot.recording import saturation
from armside.sim.robot.spread import Drawn
from armside.sim.twin.commission import MOST, commission
from armside.sim.twin.simulation import tool_path
from armside.sim.twin.twin import Twin

from ._engine import Check, Claim, Row, Rows, Tally, all_hold
from ._tasks import DEVELOPMENT, DEVELOPMENT_SEED, tasks
from ._twins import commissioning_cuts

N_TASKS = 12
GEOMETRY, EVERYTHING = "geometry", "all of these: its springs remain"
BLOCKS: Mapping[str, tuple[str, ...]] = {
    "nothing": (),
    GEOMETRY: ("position", "orientation"),
    "gear errors": ("gear_error",),
    "lost motion": ("lost_motion",),
    "friction": (
        *("friction", "friction_constant", "friction_load", "static_excess", "stribeck_speed"),
        *("viscous", "bristle_stiffness"),
    ),
    "torque ripple": ("ripple", "ripple_phase"),
    "masses": ("mass", "centre_of_mass"),
}
"""Fields of an individual that the truth is given of."""


@dataclass(frozen=True, eq=False)
class Uncorrected:
    """First run of a task without correction, by the ground truth."""

    motion: ToolMotion
    reference: Array
    tool: Array
    """(N, 3) [m], displacement from rest."""

    def left(self, simulated: Array) -> float:
        """Tool error, over that of the robot, if what a twin predicts (N, 3) [m] were cancelled."""
        programmed = self.motion.position
        return self._rms(programmed + self.tool - simulated) / self._rms(programmed[0] + self.tool)

    def _rms(self, position: Array) -> float:
        return tool_error(self.motion, self.motion.time, position).rms


def run(seed: int, tally: Tally) -> Iterator[Row]:
    number = DEVELOPMENT[seed % len(DEVELOPMENT)]
    robot, cuts = Drawn(number), [cut for _, cut in tasks(N_TASKS, DEVELOPMENT_SEED + number)]
    twin = commissioned(robot)
    true = robot.of(twin.design.nominal or twin.design.model)
    left = lacking(twin, true, [uncorrected(cut, robot, tally) for cut in cuts])
    for block, of in left.items():
        yield {
            **{"individual": number, "hidden hinges": len(true.hidden), "truth of": block},
            **{"median left": float(np.median(of)), "worst left": float(of.max())},
        }


def checks(rows: Rows) -> Iterator[Check]:
    largest = []
    for of_one in rows.by("individual").values():
        medians = dict(zip(of_one["truth of"], of_one["median left"], strict=True))
        largest.append(min(BLOCKS, key=lambda block: medians[block]) == GEOMETRY)
    yield all_hold("of single blocks the truth of geometry gains most", largest)


def commissioned(robot: Drawn) -> Twin:
    """Twin of ten cuts by IMU and motors."""
    cuts = commissioning_cuts(robot, MOST, ImuCfg())
    return commission(cuts, measure="imu").twin


def uncorrected(cut: Cut, robot: Drawn, tally: Tally) -> Uncorrected:
    """Run of a cut by a robot, without noise; its notes are counted."""
    experiment = prepare(replace(cut, individual=robot))
    reference = experiment.loaded.reference
    run = experiment.loaded.run(np.zeros_like(reference))
    tally.add((*motion_notes(experiment.motion, experiment.cut.limits), *saturation(run)))
    return Uncorrected(experiment.motion, reference, tool_path(run))


def lacking(twin: Twin, true: Individual, runs: Iterable[Uncorrected]) -> dict[str, Array]:
    """(n,) left of each task, by the block that the twin is given the truth of."""
    names = {**BLOCKS, EVERYTHING: tuple(chain(*BLOCKS.values()))}
    twins = [with_truth(twin.individual, true, fields) for fields in names.values()]
    each = [_left(twin, twins, run) for run in runs]
    return {block: np.array([left[i] for left in each]) for i, block in enumerate(names)}


def _left(twin: Twin, twins: Sequence[Individual], run: Uncorrected) -> list[float]:
    simulated = twin.design.run(twins, run.reference, np.zeros_like(run.reference))
    return [run.left(tool_path(one)) for one in simulated]


def with_truth(twin: Individual, true: Individual, fields: tuple[str, ...]) -> Individual:
    """A twin with the true values of some fields; each source of gear errors keeps its phase."""
    given = {name: getattr(true, name) for name in fields}
    source = true if "gear_error" in given else twin
    ripple_phase = given.get("ripple_phase", twin.ripple_phase)
    phase = source.gear_error_phase + (source.ripple_phase - ripple_phase)[:, None]
    return replace(twin, **given, gear_error_phase=phase)


CLAIM = Claim(title="What a twin by IMU and motors lacks", seeds=2, run=run, checks=checks)
