"""Claims about the estimate on other arms than the large robot: the IRB1400, and all robot files.

As in `verify estimation` each seed is another individual, another IMU and its mounting, another
assumed stiffness (each axis wrong by up to 30 %), and other noise. The pass band of the law was
chosen on the IRB1400 at seeds from 100 on; nothing was chosen on the other arms.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from armside.assets import IRB1400_XML
from armside.sim.cell_file import find_cell
from armside.sim.evaluation.check import Check, Table, all_hold
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.comparison import COMPARED, Case, rms
from armside.sim.laser.path_error import path_error, rigid_path
from armside.sim.laser.results import notes
from armside.sim.laser.specification import Cut
from armside.sim.laser.tool_measure import Source
from armside.sim.notes import Tally

FIVE = 5
LEFT = 0.20
"""Largest fraction of k = 0 that the estimate leaves."""
COLUMNS = {
    "rigid": "error of motor-angle kinematics (3D)",
    "estimate": "error of the estimate (3D)",
    "start": "k = 0",
    "motor": "motor k = 5",
    "learned": "estimate k = 5",
    "tracked": "tracker k = 5",
}
"""Lengths [um] of one cut, by the tracker but for the first two."""
Row = tuple[int, str, str, dict[str, float], bool]
"""Seed, robot, pose, lengths [um] by `COLUMNS`, and whether learning from the tool diverged."""


def irb1400(seeds: Iterable[int]) -> Table:
    """The IRB1400 at its poses, 40 mm/s, five updates, all effects of its gears and drives."""
    rows, said = _rows(_cases("irb1400"), seeds)
    left = _over_start(rows, "learned")
    median, worst = np.median(left), left.max()
    words = f"the estimate leaves at most {LEFT:g} of k = 0 (worst {worst:.3f}"
    fraction = Check("", f"{words}, median {median:.3f})", "", worst, high=LEFT)
    title = "Learning from an estimate of the tool on the IRB1400: tool deviation RMS in µm"
    return _table(title, rows, [fraction, *_common(rows)], said)


def arms(seeds: Iterable[int]) -> Table:
    """Every robot file beside those of the thesis, at each of its poses, 40 mm/s, five updates."""
    rows, said = _rows([case for file in robot_files() for case in _cases(str(file))], seeds)
    title = "Learning from an estimate of the tool on other arms: tool deviation RMS in µm"
    return _table(title, rows, _common(rows), said)


def robot_files() -> Sequence[Path]:
    """Robot files that ship beside the robots of the thesis."""
    thesis = ("irb1400.toml", "large_robot.toml")
    return [file for file in sorted(IRB1400_XML.parent.glob("*.toml")) if file.name not in thesis]


def row(robot: str, pose: str, seed: int, said: Tally) -> Row:
    """One cut learned from motors, estimate and tracker; notes of the learned cuts are counted."""
    case = Case(cut=Cut(robot=robot, pose=pose, imu=ImuCfg()), seed=seed)
    experiment = case.experiment()
    output, learned = case.from_tool(FIVE)
    runs, springs = list(learned), output.known.springs
    tracked = list(case.from_tool(FIVE, replace(COMPARED, source=Source.TRACKER), springs)[1])
    motors = list(case.from_motors(FIVE))
    for each in (runs, tracked, motors):
        said.add(notes(experiment, each))
    first, arm = runs[0].run, experiment.cut.cell.robot
    errors = (path_error(path, first) for path in (rigid_path(first, arm), output(first)))
    lengths = *errors, rms(runs)[0], rms(motors)[-1], rms(runs)[-1], rms(tracked)[-1]
    in_um = {name: 1e6 * length for name, length in zip(COLUMNS, lengths, strict=True)}
    diverged = runs[-1].diverged or tracked[-1].diverged
    return seed, Path(robot).stem, pose, in_um, diverged


def _cases(robot: str) -> list[tuple[str, str]]:
    """A robot at each of its poses."""
    return [(robot, pose) for pose in find_cell(robot).poses]


def _rows(cases: Sequence[tuple[str, str]], seeds: Iterable[int]) -> tuple[list[Row], Tally]:
    said = Tally()
    return [row(*case, seed, said) for seed in seeds for case in cases], said


def _over_start(rows: list[Row], name: str) -> np.ndarray:
    return np.array([lengths[name] / lengths["start"] for *_, lengths, _ in rows])


def _common(rows: list[Row]) -> list[Check]:
    """Checks of every arm."""
    robots = list(dict.fromkeys(robot for _, robot, *_ in rows))
    return [
        *(_below_motors(robot, [row for row in rows if row[1] == robot]) for robot in robots),
        all_hold("no case diverges", [not diverged for *_, diverged in rows]),
    ]


def _below_motors(robot: str, rows: list[Row]) -> Check:
    """The tool after learning from the estimate, over that after learning from motor angles."""
    over = np.array([lengths["learned"] / lengths["motor"] for *_, lengths, _ in rows])
    words = f"worst {over.max():.2f} of it, median {np.median(over):.2f}"
    return all_hold(f"{robot}: estimate below motor side in every case ({words})", over < 1.0)


def _table(title: str, rows: list[Row], checks: list[Check], said: Tally) -> Table:
    shown = [(*which, *lengths.values(), diverged) for *which, lengths, diverged in rows]
    columns = ("seed", "robot", "pose", *COLUMNS.values(), "any diverged")
    return Table(title, columns, shown, checks, said.notes("learned cuts"))
