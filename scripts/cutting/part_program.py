"""The program of a part: `armside cut --as-program`."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from armside.sim.controller.programs import (
    PlannedProgram,
    automatic_spacing,
    learn_targets,
    new_program,
)
from armside.sim.controller.programs.correction import LARGEST_OFFSET
from armside.sim.estimation.tool_law import pass_band
from armside.sim.laser.experiment import Iteration
from armside.sim.notes import Cause, Note
from armside.sim.records.run_folder import RunFolder
from armside.sim.robot.model import RobotModel

from ..shell.errors import InputError
from .part_options import CutCfg

if TYPE_CHECKING:
    from collections.abc import Iterator

    from armside.sim.laser.part_cut import PartCut

    from .cut_run import Ready

DISPLACED = 3
"""Columns of a displacement of the path."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Learner:
    """A program whose targets are learned, in place of the samples of motors."""

    made: "Ready"
    program: PlannedProgram
    robot: RobotModel | None = None
    """The twin's, to learn on; None where there is none, or it is not trusted."""

    @classmethod
    def of(cls, made: "Ready", cfg: CutCfg) -> "Learner":
        """Raises InputError for an earlier run of motors' samples, or a folder without a twin."""
        motion, before = made.experiment.motion, made.earlier
        apart = cfg.as_program == "urscript"
        program = PlannedProgram.of(made.experiment, spacing_of(motion, cfg), apart=apart)
        if before is not None and before.state().loop.correction.shape[1] != DISPLACED:
            ran = "was run by samples of motors: start from a run with --as-program"
            raise InputError(f"{before.run.folder} {ran}")
        if cfg.twin is None:
            return cls(made=made, program=program)
        from armside.sim.controller.programs import first_run
        from armside.sim.twin.twin import stored_twin

        found, robot = first_run(program, stored_twin(cfg.twin))
        start = found.start if before is None else made.start
        made = replace(made, by_twin=found, start=start)
        return cls(made=made, program=program, robot=robot if found.found.trusted else None)

    def iterations(self, count: int, converged: float | None) -> "Iterator[Iteration]":
        """As of `Ready.iterations`."""
        return learn_targets(
            self.program,
            self.made.measure,
            count,
            start=self.made.start,
            robot=self.robot,
            converged=converged,
        )


def spacing_of(motion: Any, cfg: CutCfg) -> float:
    """[m], as asked for, or automatic."""
    if cfg.spacing == "auto":
        return automatic_spacing(motion, pass_band(0.0))
    return 1e-3 * cfg.spacing


def write_program(
    folder: RunFolder,
    what: "PartCut",
    cfg: CutCfg,
    learner: Learner | None = None,
    last: Iteration | None = None,
) -> tuple[list[str], dict[str, Any], list[Note]]:
    """Write the program of a part, with its last targets where it was cut: lines and entries about
    it, and a note where they are held back."""
    from armside.sim.laser.part_cut import sequence

    motion = sequence(what, what.plan, what.plane)
    rows, largest, notes, lines = None, 0.0, list[Note](), list[str]()
    if learner is not None and last is not None:
        offsets = learner.program.offsets(last.correction)
        largest = float(((offsets**2).sum(axis=1) ** 0.5).max())
        if largest > LARGEST_OFFSET:
            most = f"at most {1e3 * LARGEST_OFFSET:g} mm are allowed: the program is not corrected"
            text = f"a target would move by {1e3 * largest:.3g} mm, {most}"
            notes, largest = [Note(cause=Cause.PROGRAM, text=text)], 0.0
        else:
            rows = learner.program.rows(offsets)
            lines = [
                f"largest offset {1e3 * largest:.3g} mm; the last run, with these targets, "
                f"had an RMS of {1e6 * last.tool.rms:.3g} µm"
            ]
    assert cfg.as_program is not None
    new = new_program(motion, cfg.as_program, spacing_of(motion, cfg), what.cutting.rapid, rows)
    entries = {key: value for key, value in vars(new).items() if key != "text"}
    file: Path = folder / new.text.name
    file.write_bytes(new.text.content.encode("latin-1"))
    return [new.line, *lines], entries | {"file": file.name, "largest_offset": largest}, notes
