"""`armside laser`: a robot cuts a shape, ILC improves it, a laser tracker judges."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any

from armside.sim.cell import CELLS
from armside.sim.laser import experiment as experiments
from armside.sim.laser.experiment import Experiment, Iteration
from armside.sim.laser.plant import Pass
from armside.sim.records.run_folder import RunFolder
from armside.sim.records.summary import summary
from armside.sim.robot.effects import Effect

from ..laser_options import EffectName as EffectName
from ..laser_options import LaserCfg as LaserCfg
from ..laser_options import arm_learning
from ..laser_options import learning_law as learning_law
from ..laser_results import quality, results, show, write
from ..laser_task import believed_arm, robot
from ..laser_task import task as task
from ..shell.console import Report
from ..shell.errors import RunFailed, checking_input
from ..shell.options import Common


def prepare(cfg: LaserCfg, seed: int) -> Experiment:
    """Everything before the first run; raises ValueError for what cannot be done."""
    imu = None
    if cfg.measure != "motor":
        from armside.sim.instruments.imu import ImuCfg

        imu = ImuCfg()
    experiment = experiments.prepare(
        CELLS[cfg.robot],
        robot(cfg),
        task(cfg),
        seed=seed,
        friction_spread=cfg.friction_spread * 1e-2,
        without=[Effect(name) for name in cfg.without],
        imu=imu,
    )
    learning_law(cfg).check(*experiment.loaded.reference.shape)
    return experiment


def run(cfg: LaserCfg, seed: int, done: Callable[[], None] = lambda: None) -> dict[str, Any]:
    """Prepare, run and learn: status, limits and measures, as `results` arranges them."""
    experiment = prepare(cfg, seed)
    start = _start(cfg, experiment, seed)
    return results(experiment, list(_counted(start(), done)))


def _start(cfg: LaserCfg, experiment: Experiment, seed: int) -> Callable[[], Iterable[Iteration]]:
    """What makes the runs, with all that it reads already read."""
    if cfg.measure == "motor":
        return lambda: experiments.iterate(experiment, learning_law(cfg), cfg.iterations)
    from ..arm_side import stored_springs

    arm, known_robot = believed_arm(cfg, seed), robot(cfg)
    place = {name: getattr(cfg, name) for name in ("pose", "position", "quaternion")}
    springs = stored_springs(cfg.identification, place) if cfg.identification else None

    def start() -> Iterable[Iteration]:
        from armside.sim.estimation.arm_learning import begin
        from armside.sim.instruments.imu import ImuCfg

        return begin(
            experiment,
            known_robot,
            arm,
            ImuCfg(),
            arm_learning(cfg),
            cfg.iterations,
            springs,
        )[1]

    return start


def _counted(iterations: Iterable[Iteration], done: Callable[[], None]) -> Iterator[Iteration]:
    for iteration in iterations:
        yield iteration
        done()


def _repeated(
    cfg: LaserCfg, experiment: Experiment, last: Iteration, done: Callable[[], None]
) -> Iterator[Pass]:
    """Runs with the last correction; none where learning diverged."""
    for _ in range(0 if last.trial.diverged else cfg.repetitions):
        yield experiment.plant.run(last.trial.correction)
        done()


def laser(*, cfg: LaserCfg = LaserCfg(), common: Common = Common()) -> None:
    """Cut a shape with a flexible robot and learn to cut it better, from motor or arm side.

    Writes summary.json, signals.parquet, circles.png, errors.png, kerf.png and replay.rrd.
    """
    report = Report(common)
    with checking_input():
        experiment = prepare(cfg, common.seed)
        start = _start(cfg, experiment, common.seed)
    with report.progress("cutting", total=cfg.iterations + 1 + cfg.repetitions) as step:
        iterations = list(_counted(start(), step))
        repeated = list(_repeated(cfg, experiment, iterations[-1], step))
    found = results(experiment, iterations) | quality(experiment, iterations, repeated, cfg.beam)
    outcome = summary("laser", cfg, common, **found)
    with RunFolder("laser", seed=common.seed, out=common.out) as folder:
        write(folder, experiment, iterations, outcome)
    show(report, outcome, folder.path)
    if outcome["status"] == "diverged":
        raise RunFailed(f"learning diverged at iteration {iterations[-1].trial.k}")
