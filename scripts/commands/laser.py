"""`armside laser`: a robot cuts a contour, ILC improves it, a laser tracker measures it."""

from armside.sim.laser.experiment import Iteration
from armside.sim.laser.plant import Pass
from armside.sim.laser.results import quality, results
from armside.sim.records.run_folder import RUNS, RunFolder, check_writable
from armside.sim.records.summary import summary

from ..cutting import first_cut
from ..cutting.learning import prepared
from ..cutting.options import LaserCfg
from ..figures.laser_results import show, write
from ..shell.console import Report
from ..shell.errors import RunFailed, checking_input
from ..shell.options import Common


def laser(*, cfg: LaserCfg = LaserCfg(), common: Common = Common()) -> None:
    """Cut a shape with a flexible robot and learn to cut it better, from motor or arm side.

    Writes summary.json, signals.parquet, circles.png, errors.png, kerf.png and replay.rrd.
    """
    report = Report(common)
    with checking_input():
        check_writable(common.out or RUNS / "laser")
        job = prepared(cfg, common.seed)
    if cfg.twin is not None:
        job = job.by_twin_of(cfg.twin)
    experiment, by_twin = job.experiment, job.by_twin
    with report.progress("cutting", total=cfg.iterations + 1 + cfg.repetitions) as step:
        iterations = list[Iteration]()
        for iteration in job.iterations(cfg.iterations):
            iterations.append(iteration)
            step()
        last, repeated = iterations[-1], list[Pass]()
        for _ in range(0 if last.diverged else cfg.repetitions):
            repeated.append(experiment.plant.run(last.correction))
            step()
    found = results(experiment, iterations) | quality(experiment, iterations, repeated, cfg.beam)
    if by_twin is not None:
        more, notes = first_cut.outcome(by_twin, iterations[0].run, cfg)
        found |= more | {"notes": [*found["notes"], *notes]}
    outcome = summary("laser", cfg, common, **found)
    with RunFolder("laser", seed=common.seed, out=common.out) as folder:
        write(folder, experiment, iterations, outcome)
    report.notes(found["notes"])
    if "predicted" in outcome:
        report.line(first_cut.line(outcome["predicted"], outcome["iterations"]))
    show(report, outcome, folder.path)
    if outcome["status"] == "diverged":
        raise RunFailed(f"learning diverged at iteration {last.k}")
