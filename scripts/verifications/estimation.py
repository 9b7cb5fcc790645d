"""The claims of `armside verify estimation`: the arm estimated, and learned from the estimate.

Each seed is another individual, another IMU screwed on differently with its clock off by up to
10 ms, another belief of the stiffness (each axis wrong by up to 30 %), and other noise.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from armside import kinematics
from armside.arrays import Array
from armside.sim.estimation.arm_learning import ArmLearningCfg, Measure, measured_path
from armside.sim.estimation.tool_path import relative_to_start
from armside.sim.laser.plant import Pass

from ..arm_side import GEAR_EFFECTS, Case, rms
from ..commands.verify import Table, Verdict
from ..jobs.workers import Workers

POSES = ("p1", "p2", "p3")
FIVE, TEN = 5, 10


class Row(NamedTuple):
    """What one seed shows at one pose. Lengths in micrometres."""

    seed: int
    pose: str
    forward_kinematics: float
    estimate: float
    start: float
    motor_5: float
    estimate_5: float
    estimate_10: float
    tracker_5: float
    default_start: float
    default_motor_5: float
    default_5: float
    default_10: float
    hard_start: float
    hard_10: float
    fast_start: float
    fast_motor: float
    fast_estimate: float
    faster_start: float
    faster_motor: float
    faster_estimate: float
    any_diverged: bool


COLUMNS = (
    "seed",
    "pose",
    "error of motor-angle kinematics (3D)",
    "error of the estimate (3D)",
    "springs: k = 0",
    "motor k = 5",
    "estimate k = 5",
    "estimate k = 10",
    "tracker k = 5",
    "all gear effects: k = 0",
    "motor k = 5",
    "estimate k = 5",
    "estimate k = 10",
    "hard: k = 0",
    "estimate k = 10",
    "81 mm/s: k = 0",
    "motor k = 5",
    "estimate k = 5",
    "100 mm/s: k = 0",
    "motor k = 5",
    "estimate k = 5",
    "any diverged",
)


def estimation(seeds: Iterable[int]) -> Table:
    """p1, p2, p3; 40 mm/s and fast; ten updates."""
    with Workers() as workers:
        rows = workers.map(_row, [(seed, pose) for seed in seeds for pose in POSES])
    return Table(
        title="Learning from an estimate of the tool: tool deviation RMS in µm",
        columns=COLUMNS,
        rows=rows,
        verdicts=verdicts(rows),
    )


def _row(case: tuple[int, str]) -> Row:
    return row(*case)


def row(seed: int, pose: str) -> Row:
    """All cases of one seed at one pose."""
    springs = Case(pose=pose, seed=seed, without=GEAR_EFFECTS)
    known, learned = springs.on_arm_side(ArmLearningCfg(), TEN)
    base = list(learned)
    first = base[0].trial.result
    by_tracker = ArmLearningCfg(measure=Measure.TRACKER)
    tracked = list(springs.on_arm_side(by_tracker, FIVE, known.springs)[1])
    motor = rms(list(springs.on_motor_side(FIVE)))

    default = Case(pose=pose, seed=seed)
    usual = list(default.on_arm_side(ArmLearningCfg(), TEN)[1])
    hard = replace(default, believed={"payload": -5.0, "damping": 1.5})
    worst = list(hard.on_arm_side(ArmLearningCfg(), TEN)[1])
    fast = replace(springs, speed=0.1)
    faster = replace(fast, acceleration=2.2)
    quick, quicker = (list(c.on_arm_side(ArmLearningCfg(), FIVE)[1]) for c in (fast, faster))
    all_runs = (base, tracked, usual, worst, quick, quicker)
    lengths = (
        error(fk_path(first), first),
        error(measured_path(ArmLearningCfg(), known, springs.imu, first), first),
        base[0].arm.rms,
        motor[-1],
        base[FIVE].arm.rms,
        base[-1].arm.rms,
        tracked[-1].arm.rms,
        usual[0].arm.rms,
        rms(list(default.on_motor_side(FIVE)))[-1],
        usual[FIVE].arm.rms,
        usual[-1].arm.rms,
        worst[0].arm.rms,
        worst[-1].arm.rms,
        quick[0].arm.rms,
        rms(list(fast.on_motor_side(FIVE)))[-1],
        quick[-1].arm.rms,
        quicker[0].arm.rms,
        rms(list(faster.on_motor_side(FIVE)))[-1],
        quicker[-1].arm.rms,
    )
    diverged = any(runs[-1].trial.diverged for runs in all_runs)
    return Row(seed, pose, *(1e6 * length for length in lengths), any_diverged=diverged)


def verdicts(rows: list[Row]) -> list[Verdict]:
    """The bars, over all rows."""

    def column(name: str) -> Array:
        return np.array([getattr(row, name) for row in rows], dtype=np.float64)

    def holds(statement: str, ratio: Array, bar: float) -> Verdict:
        return Verdict(
            f"{statement}: at most {bar:g} (worst {ratio.max():.3f})", ratio.max() <= bar
        )

    start, usual = column("start"), column("default_start")
    kinematic = column("estimate") / column("forward_kinematics")
    hard = column("hard_10")
    allowed = np.maximum(0.12 * column("hard_start"), 30.0)
    beaten = (column("estimate_5") < column("motor_5")) & (
        column("default_5") < column("default_motor_5")
    )
    slow = (column("fast_estimate") < column("fast_motor")) & (
        column("faster_estimate") < column("faster_motor")
    )
    return [
        holds("error of the estimate over that of motor-angle kinematics", kinematic, 1 / 5),
        holds(
            "springs, estimate after five updates over k = 0", column("estimate_5") / start, 0.15
        ),
        holds("springs, estimate after ten over k = 0", column("estimate_10") / start, 0.10),
        holds("springs, tracker after five over k = 0", column("tracker_5") / start, 0.10),
        holds(
            "all gear effects, estimate after five over k = 0", column("default_5") / usual, 0.15
        ),
        holds(
            "all gear effects, estimate after ten over k = 0", column("default_10") / usual, 0.15
        ),
        holds("81 mm/s, estimate over k = 0", column("fast_estimate") / column("fast_start"), 0.15),
        holds(
            "100 mm/s, estimate over k = 0",
            column("faster_estimate") / column("faster_start"),
            0.15,
        ),
        Verdict(
            "hard case after ten: at most 0.12 of k = 0 or 30 µm, whichever is larger "
            f"(worst {hard.max():.0f} µm)",
            bool((hard <= allowed).all()),
        ),
        Verdict("estimate below motor side in every case", bool((beaten & slow).all())),
        Verdict("no case diverges", not any(row.any_diverged for row in rows)),
    ]


def fk_path(run: Pass) -> Array:
    """(N, 6): the tool as rigid kinematics of the measured motor angles has it."""
    robot = kinematics.compile(kinematics.LARGE_ROBOT)
    return relative_to_start(robot.pose(np.ascontiguousarray(run.recording.motor_angle))[:, :3, 3])


def error(path: Array, run: Pass) -> float:
    """RMS distance [m] of a path (N, 6) from the true tool, at the same instants, from rest."""
    truth = run.recording.truth
    every = round(float(run.recording.time[1] / truth.time[1]))
    true = relative_to_start(truth.tool_position[::every])
    return float(np.sqrt(np.square((path - true)[:, :3]).sum(axis=1).mean()))
