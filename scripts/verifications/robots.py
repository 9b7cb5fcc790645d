"""Claims about learning on robots that are described by a robot file alone.

The designs of the files are those that the rule of `armside design` asks for on learning data of
`TRAINING`: other poses and seeds than those that are judged.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import mujoco
import numpy as np

from armside import assets
from armside.ilc.measures import norms as measures
from armside.sim.cell import ToolPose
from armside.sim.evaluation.check import Check, Table, all_hold
from armside.sim.evaluation.robot_examination import Examination
from armside.sim.laser import learn
from armside.sim.laser.design_from_data import design_from_data
from armside.sim.laser.specification import Cut
from armside.sim.notes import Tally
from armside.sim.robot.model import load_model
from armside.sim.robot_file.find import find_cell

from .learned import learned

POSES = ("p1", "p2", "p3")
LEFT = 0.10
"""Of the largest error of all motors, or of the tool, at k = 0."""
TRAINING_SEED = 100
"""Added to a seed: no individual that is judged has been trained on."""


class Task(NamedTuple):
    """Robot file, and where its design is found."""

    file: str
    training: ToolPose
    across_tool: bool = False
    """Contours across the tool's axis: level ones leave the slide of a SCARA at rest."""


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


def file_of(task: Task) -> str:
    """Robot file of a task."""
    return str(assets.LARGE_ROBOT_XML.with_name(f"{task.file}.toml"))


def robots(seeds: Iterable[int]) -> Table:
    """Motor- and tracker-side learning; each seed is another friction, tracker set-up and noise."""
    said, rows = Tally(), list[tuple[Any, ...]]()
    for seed in seeds:
        for name, task in ROBOTS.items():
            motor = [_motor(task, pose, seed, said) for pose in POSES]
            rows.append((seed, name, *motor, *(_tracker(task, pose, seed) for pose in POSES)))
    numbers = np.array([row[2:] for row in rows])
    motor, tracker = np.hsplit(numbers, 2)
    ends = f"ends at {LEFT} or below of k = 0 at every pose"
    return Table(
        "Learning on robots of robot files, circles of 5 mm radius at 40 mm/s, k = 5",
        (
            *("seed", "robot"),
            *(f"worst motor {pose}, (9.5)" for pose in POSES),
            *(f"tracker RMS {pose}, k = 5 over k = 0" for pose in POSES),
        ),
        rows,
        [
            all_hold(f"every motor {ends}; worst {motor.max():.3f}", motor <= LEFT),
            all_hold(f"the tool, by tracker, {ends}; worst {tracker.max():.3f}", tracker <= LEFT),
            *_checked(),
        ],
        said.notes("runs"),
    )


def _motor(task: Task, pose: str, seed: int, said: Tally) -> float:
    """Largest motor norm after learning from motor angles, normalised as (9.5)."""
    run = learned(Cut(robot=file_of(task), pose=pose, across_tool=task.across_tool), seed)
    said.add(run.notes)
    return float(measures.normalise(run["motor_inf"][-1], run["motor_inf"][0]).max())


def _tracker(task: Task, pose: str, seed: int) -> float:
    """RMS of the tool by the tracker after learning from it, over that of k = 0."""
    cut = Cut(robot=file_of(task), pose=pose, across_tool=task.across_tool)
    first, *_, last = learn(cut, measure="tracker", seed=seed)
    return float(last.tool.rms / first.tool.rms)


def _checked() -> Iterator[Check]:
    """Verdicts of `robot check`, and of plain MuJoCo that loads what `robot build` writes."""
    for name, task in ROBOTS.items():
        cell = find_cell(file_of(task))
        checks = Examination(load_model(cell.xml), cell).checks()
        yield all_hold(f"{name}: every verdict of `robot check`", [c.holds for c in checks])
        mj = mujoco.MjModel.from_xml_path(str(cell.xml))
        moved = [int(mj.joint(f"motor_{i + 1}").bodyid[0]) for i in range(cell.robot.n_joints)]
        drawn = np.isin(moved, mj.geom_bodyid)
        yield all_hold(f"{name}: plain MuJoCo loads its MJCF and every link has a shape", drawn)


def design(seeds: Iterable[int]) -> Table:
    """Designs from learning data of each robot at its training pose."""
    rows, verdicts = list[tuple[Any, ...]](), list[Check]()
    seeds = [TRAINING_SEED + seed for seed in seeds]
    for name, task in ROBOTS.items():
        cut = Cut(robot=file_of(task), pose=task.training, across_tool=task.across_tool)
        found = [design_from_data(cut, seed) for seed in seeds]
        for seed, one in zip(seeds, found, strict=True):
            m, p = one.model, one.proposal
            numbers = (m.delay, m.pole, float(m.fit), p.gamma, p.delta, p.cutoff, p.contraction)
            rows.append((seed, name, *numbers))
        gamma, delta, cutoff = np.median([row[5:8] for row in rows[-len(seeds) :]], axis=0)
        own = find_cell(file_of(task)).learning
        asked = f"gamma {gamma:.2f}, delta {delta:g}, cutoff {cutoff:g} Hz"
        same = own is not None and (own.delta, own.cutoff) == (delta, cutoff)
        near = own is not None and abs(own.gamma - gamma) <= 0.05
        verdicts.append(all_hold(f"{name}: its file has the medians {asked}", [same, near]))
    columns = ("seed", "robot", "delay [samples]", "pole", "fit")
    return Table(
        "The designs that learning data of the robots ask for, at their training poses",
        (*columns, "gamma", "delta", "cutoff [Hz]", "contraction"),
        rows,
        verdicts,
    )
