"""`armside cut`: a robot cuts a whole part from its drawing, and learns all contours at once."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated, Any

from cyclopts import Parameter

from armside.sim.laser.experiment import Iteration
from armside.sim.laser.loop import measure_of
from armside.sim.laser.results import results
from armside.sim.records.run_folder import RunFolder
from armside.sim.records.summary import dumps, summary

from ..cutting.coupon import draw_part
from ..cutting.cut_run import fail_unless_done, ready
from ..cutting.earlier import FromCfg, save_state, started
from ..cutting.forecast_option import ForecastCfg, entries, foreseen, show_forecast
from ..cutting.part_options import CutCfg, drawing, part_cut
from ..cutting.part_program import Learner, write_program
from ..cutting.part_scan import DRAWN, SCANS, PartScanCfg, Taught, taught
from ..figures.part_results import show_plan, show_results, write_plan, write_results
from ..figures.scan import scan_map
from ..shell.console import Report
from ..shell.errors import checking_input, needs
from ..shell.options import Common, FileToRead

Drawing = Annotated[FileToRead, Parameter(help="The drawing: .dxf, .svg, .toml; not with --from.")]


def cut(
    part: Drawing = None,
    /,
    *,
    cfg: CutCfg = CutCfg(),
    of: FromCfg = FromCfg(),
    seen: PartScanCfg = PartScanCfg(),
    ahead: ForecastCfg = ForecastCfg(),
    common: Common = Common(),
) -> None:
    """Cut a whole part from a drawing and learn all its contours at once.

    Writes summary.json, plan.png and, of runs, part.png, errors.png, signals.parquet of the first
    and last, replay.rrd and state.npz (for --from).
    """
    report, made, learner, lines = Report(common), None, None, list[str]()
    forecast: Any = None
    by_scan: Taught | None = None
    with checking_input():
        cfg = seen.asked(cfg)
        cfg, common, before = started(of.start, "cut", cfg, common)
        part = drawing(part, before)
        what = part_cut(part, cfg)
        plan = what.plan
        if ahead.forecast and cfg.plan_only:
            raise ValueError("forecast is of a run: leave out --plan-only")
        if ahead.forecast and cfg.as_program is not None:
            raise ValueError("forecast is of samples, not of targets: leave out --as-program")
        if not cfg.plan_only:
            made = ready(what, measure_of(cfg.measure), common.seed, before)
            forecast = foreseen(report, made, ahead, cfg)
            learner = None if cfg.as_program is None else Learner.of(made, cfg)
            if seen.scan is not None:
                by_scan = taught(seen, cfg, made, learner, before)
                made = replace(made, start=by_scan.state.loop.correction, earlier=None)
                learner = learner and replace(learner, made=made)
    show_plan(report, plan)
    show_forecast(report, forecast)
    about: dict[str, Any] = {"part": part}
    if made is not None:
        made = made.corrected_by(cfg.twin) if learner is None else learner.made
    with RunFolder("cut", seed=common.seed, out=common.out) as folder:
        write_plan(folder, plan)
        if made is None:
            about |= {} if before is None else {"started_from": before.entry}
            found = what.plan_entries()
            outcome, notes = summary("cut", cfg, common, **about, **found), found["notes"]
            if cfg.as_program is not None:
                lines, outcome["program"], _ = write_program(folder, what, cfg)
            (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
        else:
            ends = list[Iteration]()
            with report.progress("cutting", total=cfg.iterations + 1) as step:
                learned = (learner or made).iterations(cfg.iterations, 1e-2 * cfg.converged or None)
                found = results(made.experiment, _watched(learned, ends, step), of_tool=True)
            save_state(folder, by_scan.state if by_scan else ends[-1].state)
            started_from, of_twin = made.entries()
            if by_scan is not None:
                (folder / SCANS).write_text(dumps(by_scan.kept), encoding="utf-8")
                title = f"Part of k = {by_scan.entries['k']}: the beam beside its path"
                scan_map(folder / "scan.png", by_scan.scan, by_scan.drawing, title)
                started_from["scan"], of_twin = by_scan.entries, [*by_scan.notes]
            if learner is not None and found["status"] == "done":
                lines, started_from["program"], held = write_program(
                    folder, what, cfg, learner, ends[-1]
                )
                of_twin = [*of_twin, *held]
            if seen.draw_scan:
                with needs("scan", "armside cut --draw-scan", "scikit-image"):
                    draw_part(folder / DRAWN, made.experiment, ends[-1].run, common.seed)
            ahead_of_it, warned = entries(forecast, cfg)
            notes = [*warned, *found["notes"], *of_twin]
            found |= about | ahead_of_it | started_from | {"notes": notes}
            outcome = summary("cut", cfg, common, **found)
            write_results(folder, made.experiment, ends, outcome)
    report.notes(notes)
    if by_scan is not None:
        by_scan.show(report)
    elif made is not None:
        made.show(report, outcome)
        show_results(report, outcome)
    report.lines(lines)
    report.results(outcome, folder.path)
    fail_unless_done(outcome)


def _watched(
    iterations: Iterator[Iteration], ends: list[Iteration], step: Any
) -> Iterator[Iteration]:
    """Each iteration as it is made; `ends` has the first and the last."""
    for iteration in iterations:
        ends[1:] = [iteration] if ends else []
        ends[:1] = ends[:1] or [iteration]
        step()
        yield iteration
