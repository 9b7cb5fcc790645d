"""The program of a part: `armside cut --as-program`."""

from typing import TYPE_CHECKING, Any

from armside.sim.controller.gate import exceeded
from armside.sim.controller.limits import GuidanceLimits
from armside.sim.controller.programs import (
    automatic_spacing,
    corrected_by,
    new_program,
    read_program,
)
from armside.sim.controller.stored_correction import StoredCorrection
from armside.sim.estimation.tool_law import pass_band
from armside.sim.laser.experiment import Iteration
from armside.sim.records.run_folder import RunFolder

from .part_options import CutCfg

if TYPE_CHECKING:
    from armside.sim.laser.part_cut import PartCut

    from .cut_run import Ready


def write_program(
    folder: RunFolder,
    what: "PartCut",
    cfg: CutCfg,
    made: "Ready | None" = None,
    last: Iteration | None = None,
) -> tuple[list[str], dict[str, Any]]:
    """Write the program of a part, corrected where it was cut. Lines and entries about it."""
    from armside.sim.laser.part_cut import sequence

    motion = sequence(what, what.plan, what.plane)
    automatic = automatic_spacing(motion, pass_band(0.0))
    spacing = automatic if cfg.spacing == "auto" else 1e-3 * cfg.spacing
    assert cfg.as_program is not None
    new = new_program(motion, cfg.as_program, spacing, what.cutting.rapid)
    entries = {key: value for key, value in vars(new).items() if key != "text"}
    text, largest, lines = new.text, 0.0, [new.line]
    if made is not None and last is not None:
        log, drives = last.run.recording, made.experiment.nominal.drives
        stored = StoredCorrection(
            correction=last.correction,
            reference=log.reference,
            sample_time=float(log.time[1] - log.time[0]),
            k=last.k,
            robot=cfg.robot,
        )
        held = exceeded(
            stored.correction,
            stored.sample_time,
            path=stored.reference,
            limits=GuidanceLimits.of_cell(what.cell),
            slides=what.cell.robot.slides,
        )
        if held:
            lines.append(f"The program is not corrected: {'; '.join(held.values())}")
        else:
            found = corrected_by(read_program(new.text), motion, stored, what.cell, drives)
            (text,), largest = found.texts, found.largest_offset
            lines.append(found.line)
    (folder / text.name).write_bytes(text.content.encode("latin-1"))
    return lines, entries | {"file": text.name, "largest_offset": largest}
