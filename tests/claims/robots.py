"""Motor- and tracker-side learning on robots that are described by a robot file alone.

Each seed is another friction, tracker set-up and noise. The designs of the files are those that
`robots-design` asks for, of other poses and seeds than those that are judged.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import NamedTuple

import mujoco
import numpy as np

from armside import assets
from armside.sim.cell import ToolPose
from armside.sim.evaluation.robot_examination import Examination
from armside.sim.laser import learn
from armside.sim.laser.specification import Cut
from armside.sim.robot.model import load_model
from armside.sim.robot_file.find import find_cell

from ._engine import Check, Claim, Row, Rows, Tally, all_hold, crossed
from ._learned import POSES, learned
from .laser_irb1400 import designed

LEFT = 0.10
"""Of the largest error of all motors, or of the tool, at k = 0."""


class Task(NamedTuple):
    """Robot file, and where its design is found."""

    file: str
    training: ToolPose
    across_tool: bool = False
    """Contours across the tool's axis: level ones leave the slide of a SCARA at rest."""

    @property
    def path(self) -> str:
        return str(assets.LARGE_ROBOT_XML.with_name(f"{self.file}.toml"))

    def cut(self, pose: str | ToolPose) -> Cut:
        return Cut(robot=self.path, pose=pose, across_tool=self.across_tool)


def _at(x: float, y: float, z: float, *quaternion: float) -> ToolPose:
    """Pose at a place [m]; the quaternion is normalised."""
    w, i, j, k = (np.array(quaternion) / np.linalg.norm(quaternion)).tolist()
    return ToolPose((x, y, z), (w, i, j, k))


ROBOTS: Mapping[str, Task] = {
    "UR5e-like": Task("ur5e_like", _at(0.40, 0.20, 0.35, 0, 1, 0, 0)),
    "Panda-like": Task("panda_like", _at(0.50, 0.05, 0.35, 0, 1, 0, 0)),
    "SCARA": Task("scara", _at(0.35, -0.15, 0.30, 0, 1, 0.09, 0.09), True),
    "two-link": Task("two_link", _at(0.60, -0.10, 1.00, 1, 0, 0, 0)),
    "KR16-like": Task("kr16_like", _at(1.05, 0.10, 0.95, 0.15, 0.05, 0.98, 0.12)),
}
MOTOR = {pose: f"worst motor {pose}, (9.5)" for pose in POSES}
TRACKER = {pose: f"tracker RMS {pose}, k = 5 over k = 0" for pose in POSES}


def run(case: tuple[int, str], tally: Tally, poses: Sequence[str] = POSES) -> Iterator[Row]:
    seed, name = case
    cuts = {pose: ROBOTS[name].cut(pose) for pose in poses}
    motor = {MOTOR[p]: learned(cut, seed, tally).worst("motor_inf") for p, cut in cuts.items()}
    yield (
        {"seed": seed, "robot": name}
        | motor
        | {TRACKER[pose]: _by_tracker(cut, seed) for pose, cut in cuts.items()}
    )


def _by_tracker(cut: Cut, seed: int) -> float:
    """RMS of the tool by the tracker after learning from it, over that of k = 0."""
    first, *_, last = learn(cut, measure="tracker", seed=seed)
    return float(last.tool.rms / first.tool.rms)


def checks(rows: Rows, poses: Sequence[str] = POSES) -> Iterator[Check]:
    motor, tracker = (rows.of(*(of[pose] for pose in poses)) for of in (MOTOR, TRACKER))
    ends = f"ends at {LEFT} or below of k = 0 at every pose"
    yield all_hold(f"every motor {ends}; worst {motor.max():.3f}", motor <= LEFT)
    yield all_hold(f"the tool, by tracker, {ends}; worst {tracker.max():.3f}", tracker <= LEFT)
    for name in dict.fromkeys(rows["robot"].tolist()):
        yield from described(name)


def described(name: str) -> Iterator[Check]:
    """Verdicts of `robot check`, and of plain MuJoCo that loads what `robot build` writes."""
    cell = find_cell(ROBOTS[name].path)
    found = Examination(load_model(cell.xml), cell).checks()
    yield all_hold(f"{name}: every verdict of `robot check`", [c.holds for c in found])
    mj = mujoco.MjModel.from_xml_path(str(cell.xml))
    moved = [int(mj.joint(f"motor_{i + 1}").bodyid[0]) for i in range(cell.robot.n_joints)]
    drawn = np.isin(moved, mj.geom_bodyid)
    yield all_hold(f"{name}: plain MuJoCo loads its MJCF and every link has a shape", drawn)


CLAIM = Claim(
    title="Learning on robots of robot files, circles of 5 mm radius at 40 mm/s, k = 5",
    seeds=5,
    cases=crossed(ROBOTS),
    run=run,
    checks=checks,
)


TRAINING_SEED = 100
"""Added to a seed: no individual that is judged has been trained on."""


def cases_of_design(seeds: Sequence[int]) -> Iterator[tuple[str, int]]:
    yield from product(ROBOTS, (TRAINING_SEED + seed for seed in seeds))


def run_design(case: tuple[str, int], _: Tally) -> Iterator[Row]:
    name, seed = case
    cells = designed(ROBOTS[name].cut(ROBOTS[name].training), seed)
    yield {"seed": seed, "robot": name} | {k: v for k, v in cells.items() if k != "static gain"}


def checks_design(rows: Rows) -> Iterator[Check]:
    for name, own in rows.by("robot").items():
        gamma, delta, cutoff = np.median(own.of("gamma", "delta", "cutoff [Hz]"), axis=0)
        of_file = find_cell(ROBOTS[name].path).learning
        asked = f"gamma {gamma:.2f}, delta {delta:g}, cutoff {cutoff:g} Hz"
        same = of_file is not None and (of_file.delta, of_file.cutoff) == (delta, cutoff)
        near = of_file is not None and abs(of_file.gamma - gamma) <= 0.05
        yield all_hold(f"{name}: its file has the medians {asked}", [same, near])


CLAIM_DESIGN = Claim(
    title="The designs that learning data of the robots ask for, at their training poses",
    seeds=3,
    cases=cases_of_design,
    run=run_design,
    checks=checks_design,
)
