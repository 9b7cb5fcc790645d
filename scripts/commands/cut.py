"""`armside cut`: a robot cuts a whole part from its drawing, and learns all contours at once."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from armside.sim.notes import Note
from armside.sim.part_run.learning import PartIteration, learn
from armside.sim.part_run.notes import all_notes, plan_notes, run_notes
from armside.sim.part_run.results import Rows, results, rows_of
from armside.sim.records.run_folder import RUNS, RunFolder, check_writable
from armside.sim.records.summary import dumps, summary

from ..cutting import first_cut
from ..cutting.earlier import FromCfg, earlier, kept_state, save_state, show_transfer
from ..cutting.endings import fail_unless_done
from ..cutting.part import by_twin_of, part_of, plan_entries, planned, prepared, uncorrected
from ..cutting.part_options import CutCfg
from ..figures.part_results import show_plan, show_results, write_plan, write_results
from ..shell.console import Report
from ..shell.errors import checking_input, needs
from ..shell.options import Common, check_read

Drawing = Annotated[Path | None, Parameter(validator=check_read)]


def cut(
    part: Drawing = None,
    *,
    cfg: CutCfg = CutCfg(),
    of: FromCfg = FromCfg(),
    common: Common = Common(),
) -> None:
    """Cut a whole part from a drawing (.dxf, .svg, .toml) and learn all its contours at once.

    Writes summary.json, plan.png and, unless --plan-only, part.png, errors.png, signals.parquet of
    the first and last run, replay.rrd and state.npz (for --from, which needs no drawing).
    """
    report, before, start = Report(common), None, None
    with checking_input(), needs("parts", "armside cut", "shapely, ezdxf and svgelements"):
        check_writable(common.out or RUNS / "cut")
        if of.start is not None:
            cfg, common, before = earlier(of.start, "cut", cfg, common, cfg.iterations)
        part = part_of(part, before)
        job, plan = planned(part, cfg)
        ready = None if cfg.plan_only else prepared(job, plan, cfg, common.seed)
        if before is not None and ready is not None:
            resume = before.resume
            start = before.correction(ready[0].motion) if resume is None else resume.start
    show_plan(report, plan)
    by_twin = None
    if cfg.twin is not None and ready is not None:
        by_twin, set_up = by_twin_of(cfg.twin, ready[0], cfg)
        ready, start = (ready[0], set_up), start if before else by_twin.start
    about: dict[str, Any] = {"part": part}
    if before is not None:
        about["started_from"] = before.entry
    with RunFolder("cut", seed=common.seed, out=common.out) as folder:
        write_plan(folder, plan)
        if ready is None:
            notes = list(plan_notes(plan))
            outcome = summary("cut", cfg, common, **about, **plan_entries(plan), notes=notes)
            (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
        else:
            experiment, set_up = ready
            resume = None if before is None else before.resume
            least = 1e-2 * cfg.converged or None
            how: dict[str, Any] = {"start": start, "resume": resume, "converged": least}
            found = learn(experiment, set_up, cfg.iterations, **how)
            kept, rows, said = _learned(report, found, cfg.iterations + 1)
            save_state(folder, kept_state(kept[-1].state, experiment.plant, start))
            if before is not None and before.changed:
                about["started_from"]["uncorrected"] = uncorrected(job, plan, cfg, common.seed)
            notes = all_notes(plan, said, rows)
            if by_twin is not None and before is None:
                about["predicted"] = by_twin.predicted
                notes += first_cut.trust(by_twin.found)
            about |= results(experiment, rows, kept)
            outcome = summary("cut", cfg, common, **about, notes=notes)
            write_results(folder, experiment, kept, outcome)
    report.notes(notes)
    if before is not None and ready is not None:
        without = outcome["started_from"].get("uncorrected", {}).get("arm_rms")
        show_transfer(report, before, without, outcome["iterations"])
    if "predicted" in outcome:
        report.line(first_cut.line(outcome["predicted"], outcome["iterations"]))
    if ready is not None:
        show_results(report, outcome)
    report.results(outcome, folder.path)
    fail_unless_done(outcome)


def _learned(
    report: Report, iterations: Iterator[PartIteration], runs: int
) -> tuple[list[PartIteration], list[Rows], list[Note]]:
    """First and last iteration, the measures of all, and their notes."""
    kept, rows, notes = list[PartIteration](), list[Rows](), list[Note]()
    with report.progress("cutting", total=runs) as step:
        for iteration in iterations:
            kept = [*kept[:1], iteration]
            rows.append(rows_of(iteration))
            notes += run_notes(iteration)
            step()
    return kept, rows, notes
