"""`armside compare`: the same cuts learned from motors, estimate, tracker and ground truth."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from armside.ilc.workbench.compare import RunState
from armside.sim.laser.comparison import COMPARED, Case, compared, rms
from armside.sim.laser.design import default_design
from armside.sim.laser.experiment import Iteration
from armside.sim.laser.loop import Start, iterate
from armside.sim.laser.measures import MotorAngles
from armside.sim.laser.results import notes
from armside.sim.notes import Cause, Note, together
from armside.sim.records.summary import summary
from armside.sim.twin.twin import stored_twin

from ..cutting.comparison import (
    CompareCfg,
    cases_of,
    refuse_absurd_comparison,
    save_states_of,
    starts_of,
)
from ..cutting.cut_run import Ready
from ..cutting.earlier import FromCfg, started
from ..shell.console import Report, run_folder
from ..shell.errors import checking_input
from ..shell.options import Common


def compare(
    *, cfg: CompareCfg = CompareCfg(), of: FromCfg = FromCfg(), common: Common = Common()
) -> None:
    """Learn each cut from the motors, an estimate, a laser tracker and the true tool; by a twin.

    Writes summary.json, compare.png, state.npz (for --from) and replay.rrd: of the first cut,
    unlearned and learned each way.
    """
    from armside.sim.estimation.tool_law import ToolLawKind

    from ..figures import comparison as figures

    report = Report(common)
    with checking_input():
        cfg, common, before = started(of.start, "compare", cfg, common)
        todo = cases_of(cfg, common.seed)
        refuse_absurd_comparison(cfg, len(todo))
        starts = [{} if before is None else starts_of(before, *each) for each in enumerate(todo)]
        for case in todo[:1]:
            case.experiment()  # an individual may not fit the robot
        if cfg.twin is not None:
            stored_twin(cfg.twin).check(todo[0].cut)
    law, error = replace(COMPARED.law, kind=ToolLawKind(cfg.law)), cfg.stiffness_error * 1e-2
    measure = replace(COMPARED, law=law, stiffness_error=error)

    def learned(job: tuple[Case, dict[str, Start]]) -> dict[str, list[Iteration]]:
        case, start = job
        ways = compared(case, cfg.iterations, measure, start)
        if cfg.twin is not None:
            ways["twin"] = _by_twin(case, cfg.twin, cfg.iterations, start.get("twin"))
        return ways

    found = report.each("comparing", learned, list(zip(todo, starts, strict=True)))
    rows = [row for case, each in zip(todo, found, strict=True) for row in _rows(case, each)]
    said = together(_notes(todo, found))
    counted = [each.k for each in max((m for of in found for m in of.values()), key=len)]
    from_ = None if before is None else before.entry
    outcome = summary(
        "compare", cfg, common, comparisons=rows, k=counted, notes=said, started_from=from_
    )
    with run_folder(outcome, common) as folder:
        save_states_of(folder, found)
        figures.learned(folder / "compare.png", todo, found)
        figures.write_replay(folder / "replay.rrd", todo[0], found[0])
    report.notes(said)
    if before is not None:
        report.line(before.line)
    heads = figures.columns(counted)
    report.table(figures.TITLE, heads, figures.table(rows, counted))
    report.results(outcome, folder.path)


def _by_twin(case: Case, folder: Path, iterations: int, before: Start | None) -> list[Iteration]:
    """First run by a twin's correction; learning goes on from the motor angles."""
    measure = MotorAngles(default_design(case.cut.cell))
    made = Ready(experiment=case.experiment(), measure=measure).corrected_by(folder)
    if isinstance(before, RunState):
        made = replace(made, start=before)
    return list(made.iterations(iterations))


def _notes(todo: list[Case], found: list[dict[str, list[Iteration]]]) -> Iterator[Note]:
    for case, of in zip(todo, found, strict=True):
        experiment, limit = case.experiment(), f"{case.cut.limits.acceleration:g} m/s^2"
        place = f"{case.cut.pose}, {1e3 * case.cut.speed:g} mm/s, {limit}"
        for measure, iterations in of.items():
            for note in notes(experiment, iterations):
                of_motion = note.cause in (Cause.SPEED, Cause.ACCELERATION)
                where = place if of_motion else f"{place}, {measure}"
                yield replace(note, text=f"{where}: {note.text}")


def _rows(case: Case, found: dict[str, list[Iteration]]) -> Iterator[dict[str, Any]]:
    experiment, motors = case.experiment(), found["motor"]
    uncorrected = motors[0].tool.rms
    if motors[0].correction.any():
        without = MotorAngles(default_design(case.cut.cell)).prepare(experiment)
        uncorrected = next(iterate(experiment, without, 0)).tool.rms
    for measure, iterations in found.items():
        yield {
            "pose": case.cut.pose,
            "programmed_speed": case.cut.speed,
            "reached_speed": experiment.motion.reached_speed,
            "measure": measure,
            "arm_rms": rms(iterations),
            "uncorrected": uncorrected,
            "diverged": iterations[-1].diverged,
        }
