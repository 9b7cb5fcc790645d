"""A correction learned sample by sample, put into a program of linear moves, and run as one.

The tracker's correction after five updates goes through delay, lag and kinematics into the targets
of a RAPID program, which is written, read back and run by the virtual robot: parabolas in its
zones, and the contour's speed throughout. That interpolator is an assumption. Bars are those of the
trial that came before: 0.38 in the median of it, 0.68 at most.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from armside.sim.controller.programs import ProgramText, corrected_by, read_program, rows_of
from armside.sim.controller.programs.new_program import fitted
from armside.sim.controller.programs.scanner import Text
from armside.sim.controller.programs.tool_path import Row as TargetRow
from armside.sim.controller.stored_correction import StoredCorrection
from armside.sim.evaluation.tool_error import ToolError
from armside.sim.laser.experiment import prepare
from armside.sim.laser.loop import learn
from armside.sim.laser.specification import Cut
from armside.sim.motion.contour import contour_of
from armside.sim.motion.timing import PathLimits, rest_to_rest
from armside.sim.motion.tool_motion import joint_reference
from armside.sim.robot.statics import Statics, anticipated_shift, smoothed
from armside.sim.robot.virtual_robot import LOG_PERIOD

from ._engine import Check, Claim, Row, Rows, Tally, all_hold, at_most, crossed

UPDATES, MEDIAN, WORST = 5, 0.38, 0.68
TASKS = {
    "circle, radius 5 mm, 40 mm/s": Cut(speed=0.04),
    "square, 20 mm, 60 mm/s": Cut(contour=contour_of("square", 0.01), speed=0.06),
    "hexagon, 20 mm, 60 mm/s": Cut(contour=contour_of("hexagon", 0.01), speed=0.06),
}
"""Cuts by name, at p1."""
SPACINGS = (0.002, 0.001)
"""[m]."""


def run(place: tuple[int, str], tally: Tally) -> Iterator[Row]:
    seed, task = place
    cut = TASKS[task]
    *_, last = learn(cut, measure="tracker", seed=seed, iterations=UPDATES)
    tally.add(last.notes)
    experiment = prepare(cut, seed=seed)
    motion, log = experiment.motion, last.run.recording
    stored = StoredCorrection(
        correction=last.correction,
        reference=log.reference,
        sample_time=LOG_PERIOD,
        k=last.k,
        robot="large",
    )
    for spacing in SPACINGS:
        made, _ = fitted(motion.path.position, motion.path.length, spacing)
        before = read_program(module(made, motion.quaternion[0]))
        found = corrected_by(before, motion, stored, cut.cell, experiment.nominal.drives)
        first = tool_error(cut, before, seed).rms
        yield {
            **{"seed": seed, "contour": task, "spacing [mm]": 1e3 * spacing},
            "program": 1e6 * first,
            "corrected": 1e6 * tool_error(cut, read_program(*found.texts), seed).rms,
            "sample by sample": 1e6 * last.tool_true.rms,
            "largest offset [mm]": 1e3 * found.largest_offset,
        }


def module(made: TargetRow, quaternion: np.ndarray) -> Text:
    """The targets as a module."""
    turn, far = ",".join(f"{v:.9f}" for v in quaternion), ",".join(["9E9"] * 6)
    zone = f"[FALSE,{1e3 * made.zones[1]:.3f},1,1,1,1,1]"
    points = [",".join(f"{1e3 * v:.3f}" for v in at) for at in made.targets]
    moves = [f"MoveL [[{p}],[{turn}],[0,0,0,0],[{far}]], v40, {zone}, tool0;" for p in points]
    return Text("m.mod", "\n".join(["MODULE m", "PROC main()", *moves, "ENDPROC", "ENDMODULE"]))


def tool_error(cut: Cut, program: ProgramText, seed: int) -> ToolError:
    """Of the virtual robot on a program, without a correction; ground truth."""

    def planned(nominal: Statics) -> tuple[Any, np.ndarray]:
        motion, _ = cut.planned(nominal)
        (row,) = rows_of(program)
        path = row.path(row.samples(2e-5))
        steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
        s = np.concatenate([[0.0], np.cumsum(steps)])
        timing = rest_to_rest(float(s[-1]), motion.reached_speed, PathLimits())
        at, _, _ = timing.at(motion.time - motion.rest_before)
        moved = replace(motion, position=np.stack([np.interp(at, s, x) for x in path.T], axis=1))
        robot, limits = cut.cell.robot, cut.cell.limits
        phi = joint_reference(moved, robot, limits, start=cut.cell.home)
        shift = anticipated_shift(nominal, phi, LOG_PERIOD)
        shift = shift if cut.contour is None else smoothed(shift)
        return motion, joint_reference(moved, robot, limits, start=phi[0], shift=shift)

    experiment = prepare(cut, seed=seed, planned=planned)
    done = experiment.plant.run(np.zeros((len(experiment.motion.time), 6)))
    (error,) = cut.errors(experiment.motion, *done.true, edges=False)
    return error


def checks(rows: Rows) -> Iterator[Check]:
    left = rows["corrected"] / rows["program"]
    for spacing, own in rows.by("spacing [mm]").items():
        part = float(np.median(own["corrected"] / own["program"]))
        yield at_most(f"corrected over uncorrected, {spacing:g} mm: median", part, MEDIAN)
    yield at_most("the same: worst", float(left.max()), WORST)
    worse = rows["corrected"] >= rows["sample by sample"]
    yield all_hold("a program leaves more than samples of six motors", worse)


CLAIM = Claim(
    title="A learned correction put into a program: tool deviation RMS in µm",
    seeds=2,
    cases=crossed(TASKS),
    run=run,
    checks=checks,
    counted="learned cuts",
)
