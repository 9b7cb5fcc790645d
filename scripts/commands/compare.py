"""`armside compare`: the same cuts learned from motors, estimate, tracker and ground truth."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter

from armside.sim.cell import LARGE_CELL, LARGE_ROBOT_POSES, pose
from armside.sim.cut.timing import PathLimits
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.comparison import COMPARED, Case, rms
from armside.sim.laser.experiment import Iteration
from armside.sim.laser.specification import Cut
from armside.sim.records.run_folder import RunFolder
from armside.sim.records.summary import dumps, summary
from armside.sim.robot.effects import Effect

from ..cutting.options import EffectName
from ..shell.console import Report
from ..shell.errors import checking_input
from ..shell.options import Common, options

_Several = Parameter(consume_multiple=True)
RADIUS = 0.005
"""[m], of the circles."""


@options
@dataclass(frozen=True, kw_only=True)
class CompareCfg:
    """Cuts of the large robot."""

    poses: Annotated[tuple[str, ...], _Several] = tuple(LARGE_ROBOT_POSES)
    """Poses: p1, p2, p3 of thesis (9.3)."""
    speeds: Annotated[tuple[float, ...], _Several] = (40.0, 100.0)
    """Programmed speeds [mm/s]."""
    raised_acceleration: float = 2.2
    """Raised limit: cuts whose speed the controller lowers are also made with it [m/s^2]."""
    iterations: int = 10
    """Number of updates; one run more is made."""
    stiffness_error: float = 30.0
    """Error of the assumed stiffness of each axis, uniform up to this, drawn with the seed [%]."""
    law: Literal["inverse", "norm-optimal", "heuristic"] = "inverse"
    """Law on the arm side; the motor side has the thesis's heuristic."""
    without: Annotated[tuple[EffectName, ...], _Several] = ()
    """Effects of gears and drives to leave out, for ablations."""
    imu: bool = False
    """Also draw imu.png: what rate, noise and clock of the IMU buy or cost; takes minutes."""

    def __post_init__(self) -> None:
        for name in self.poses:
            pose(name)
        for speed in self.speeds:
            if not speed > 0.0:
                raise ValueError(f"speeds must be > 0 mm/s, got {speed:g}")
        if self.iterations < 1:
            raise ValueError(f"iterations must be >= 1, got {self.iterations}")
        if not 0.0 <= self.stiffness_error < 100.0:
            raise ValueError(f"stiffness-error must be in [0, 100) %, got {self.stiffness_error:g}")
        PathLimits(acceleration=self.raised_acceleration)


def cases(cfg: CompareCfg, seed: int) -> Iterator[Case]:
    """Each pose and speed; a speed that the controller lowers also with its limit raised."""
    for speed in cfg.speeds:
        limits = [PathLimits().acceleration]
        if speed * 1e-3 > PathLimits().cornering_speed(RADIUS):
            limits.append(cfg.raised_acceleration)
        for limit in limits:
            for name in cfg.poses:
                cut = Cut(
                    pose=name,
                    speed=speed * 1e-3,
                    limits=PathLimits(acceleration=limit),
                    without=tuple(Effect(effect) for effect in cfg.without),
                    imu=ImuCfg(),
                )
                yield Case(cut=cut, seed=seed)


def compare(*, cfg: CompareCfg = CompareCfg(), common: Common = Common()) -> None:
    """Learn each cut from the motors, an estimate, a laser tracker and the true tool.

    Writes summary.json, compare.png and replay.rrd: of the first cut, unlearned and learned each
    way.
    """
    from armside.sim.estimation.tool_law import ToolLawKind

    report = Report(common)
    with checking_input():
        todo = list(cases(cfg, common.seed))
    measure = replace(
        COMPARED,
        law=replace(COMPARED.law, kind=ToolLawKind(cfg.law)),
        stiffness_error=cfg.stiffness_error * 1e-2,
    )
    found: list[dict[str, list[Iteration]]] = []
    with report.progress("comparing", total=len(todo)) as step:
        for case in todo:
            found.append(case.compared(cfg.iterations, measure))
            step()
    rows = [row for case, of in zip(todo, found, strict=True) for row in _rows(case, of)]
    outcome = summary("compare", cfg, common, comparisons=rows)
    with RunFolder("compare", seed=common.seed, out=common.out) as folder:
        (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
        _draw(folder / "compare.png", todo, found)
        _write_replay(folder / "replay.rrd", todo[0], found[0])
        if cfg.imu:
            from ..figures import comparison as arm_side_figures
            from ..verifications.controls import controls

            arm_side_figures.imu_quality(folder / "imu.png", controls([common.seed]).rows)
    _print(report, rows)
    report.line(f"Results in {folder.path}")
    report.summary(outcome)


def _rows(case: Case, found: dict[str, list[Iteration]]) -> Iterator[dict[str, Any]]:
    reached = case.experiment().motion.reached_speed
    for measure, iterations in found.items():
        yield {
            "pose": case.cut.pose,
            "programmed_speed": case.cut.speed,
            "reached_speed": reached,
            "measure": measure,
            "arm_rms": rms(iterations),
            "diverged": iterations[-1].diverged,
        }


def _print(report: Report, rows: list[dict[str, Any]]) -> None:
    report.table(
        "Arm RMS (9.6) [µm] before learning, after five updates and at the end",
        ["pose", "speed [mm/s]", "learned from", "k = 0", "k = 5", "last", "last / k = 0"],
        [
            [
                row["pose"],
                1e3 * row["reached_speed"],
                row["measure"] + (" (diverged)" if row["diverged"] else ""),
                1e6 * row["arm_rms"][0],
                1e6 * row["arm_rms"][min(5, len(row["arm_rms"]) - 1)],
                1e6 * row["arm_rms"][-1],
                row["arm_rms"][-1] / row["arm_rms"][0],
            ]
            for row in rows
        ],
    )


def _draw(file: Path, todo: list[Case], found: list[dict[str, list[Iteration]]]) -> None:
    from ..figures import comparison as arm_side_figures

    titles = [
        f"{case.cut.pose}, {1e3 * case.experiment().motion.reached_speed:.0f} mm/s" for case in todo
    ]
    curves = [{name: np.array(rms(of)) for name, of in each.items()} for each in found]
    n_columns = len({case.cut.pose for case in todo})
    arm_side_figures.learned(file, titles, curves, n_columns)


def _write_replay(file: Path, case: Case, found: dict[str, list[Iteration]]) -> None:
    """The first run, then the last of each measured output, as k = 0 .. 4."""
    from armside.sim.records.signals import RecordedRun
    from armside.sim.replay.scene import Scene, write_scenes

    experiment = case.experiment()
    shown = [found["motor"][0], *(iterations[-1] for iterations in found.values())]
    runs = [
        RecordedRun(k=k, recording=it.run.recording, tracker=it.run.tracker)
        for k, it in enumerate(shown)
    ]
    mj, motion = experiment.loaded.model.mj, experiment.motion
    write_scenes(file, [Scene(mj=mj, runs=runs, motion=motion, robot=LARGE_CELL.robot)])
