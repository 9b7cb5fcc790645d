"""`armside laser`: a robot cuts a contour, ILC improves it, a laser tracker measures it."""

from dataclasses import replace

from armside.sim.laser.experiment import Iteration
from armside.sim.laser.plant import Pass
from armside.sim.laser.results import iteration_row, quality
from armside.sim.records.run_folder import RUNS, RunFolder, check_writable
from armside.sim.records.summary import summary

from ..cutting import first_cut
from ..cutting.earlier import FromCfg, earlier, kept_state, save_state, show_transfer
from ..cutting.endings import fail_unless_done
from ..cutting.learning import prepared
from ..cutting.options import LaserCfg
from ..figures.laser_results import show, write
from ..shell.console import Report
from ..shell.errors import checking_input
from ..shell.options import Common


def laser(
    *, cfg: LaserCfg = LaserCfg(), of: FromCfg = FromCfg(), common: Common = Common()
) -> None:
    """Cut a shape with a flexible robot and learn to cut it better, from motor or arm side.

    Writes summary.json, signals.parquet, circles.png, errors.png, kerf.png, replay.rrd and
    state.npz (for --from).
    """
    report, before = Report(common), None
    with checking_input():
        check_writable(common.out or RUNS / "laser")
        if of.start is not None:
            cfg, common, before = earlier(of.start, "laser", cfg, common, cfg.iterations)
        job = replace(prepared(cfg, common.seed), earlier=before)
        started = job.start
    if cfg.twin is not None:
        job = job.by_twin_of(cfg.twin)
        started = job.start
    experiment, by_twin = job.experiment, job.by_twin
    with report.progress("cutting", total=cfg.iterations + 1 + cfg.repetitions) as step:
        iterations = list[Iteration]()
        for iteration in job.iterations(cfg.iterations):
            iterations.append(iteration)
            step()
        state = kept_state(iterations[-1].state, experiment.plant, started)
        last, repeated = iterations[-1], list[Pass]()
        for _ in range(0 if last.diverged else cfg.repetitions):
            repeated.append(experiment.plant.run(last.correction))
            step()
    found = job.results(iterations) | quality(experiment, iterations, repeated, cfg.beam)
    uncorrected = job.uncorrected
    if before is not None:
        found |= {"started_from": before.entry}
        if uncorrected is not None:
            found["started_from"]["uncorrected"] = iteration_row(uncorrected)
    if by_twin is not None and before is None:
        more, notes = first_cut.outcome(by_twin, iterations[0].run, cfg)
        found |= more | {"notes": [*found["notes"], *notes]}
    outcome = summary("laser", cfg, common, **found)
    with RunFolder("laser", seed=common.seed, out=common.out) as folder:
        write(folder, experiment, iterations, outcome)
        save_state(folder, state)
    report.notes(found["notes"])
    if before is not None:
        without = None if uncorrected is None else uncorrected.tool.rms
        show_transfer(report, before, without, outcome["iterations"])
    if "predicted" in outcome:
        report.line(first_cut.line(outcome["predicted"], outcome["iterations"]))
    show(report, outcome, folder.path)
    fail_unless_done(outcome)
