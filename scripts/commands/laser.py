"""`armside laser`: a robot cuts a contour, ILC improves it, a laser tracker measures it."""

from armside.sim.laser.experiment import Iteration, Pass
from armside.sim.laser.results import quality, results
from armside.sim.records.run_folder import RunFolder
from armside.sim.records.summary import summary

from ..cutting.cut_run import fail_unless_done, ready
from ..cutting.earlier import FromCfg, save_state, started
from ..cutting.forecast_option import ForecastCfg, entries, foreseen, show_forecast
from ..cutting.options import LaserCfg
from ..cutting.specification import cut, measure
from ..figures.laser_results import show, write
from ..shell.console import Report
from ..shell.errors import checking_input
from ..shell.options import Common


def laser(
    *,
    cfg: LaserCfg = LaserCfg(),
    of: FromCfg = FromCfg(),
    ahead: ForecastCfg = ForecastCfg(),
    common: Common = Common(),
) -> None:
    """Cut a shape with a flexible robot and learn to cut it better, from motor or arm side.

    Writes summary.json, signals.parquet, circles.png, errors.png, kerf.png, replay.rrd and
    state.npz (for --from).
    """
    report = Report(common)
    with checking_input():
        cfg, common, before = started(of.start, "laser", cfg, common)
        made = ready(cut(cfg), measure(cfg), common.seed, before)
        forecast = foreseen(report, made, ahead, cfg)
    show_forecast(report, forecast)
    made = made.corrected_by(cfg.twin)
    experiment, iterations, repeated = made.experiment, list[Iteration](), list[Pass]()
    with report.progress("cutting", total=cfg.iterations + 1 + cfg.repetitions) as step:
        for iteration in made.iterations(cfg.iterations):
            iterations.append(iteration)
            step()
        last = iterations[-1]
        for _ in range(0 if last.diverged else cfg.repetitions):
            repeated.append(experiment.plant.run(last.correction))
            step()
    found = results(experiment, iterations, of_tool=cfg.measure != "motor")
    found |= quality(experiment, iterations, repeated, cfg.beam)
    started_from, notes = made.entries()
    if "predicted" in started_from and made.by_twin is not None:
        shown, more = made.by_twin.shown_by(iterations[0].run, cfg.payload)
        started_from |= {"twin": {"folder": cfg.twin, **shown}}
        notes = [*notes, *more]
    ahead_of_it, warned = entries(forecast, cfg)
    found |= ahead_of_it | started_from | {"notes": [*warned, *found["notes"], *notes]}
    outcome = summary("laser", cfg, common, **found)
    with RunFolder("laser", seed=common.seed, out=common.out) as folder:
        write(folder, experiment, iterations, outcome)
        save_state(folder, last.state)
    report.notes(found["notes"])
    made.show(report, outcome)
    show(report, outcome, folder.path)
    fail_unless_done(outcome)
