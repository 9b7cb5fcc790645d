"""One learning experiment of a study: everything it depends on, and the small arrays it leaves."""

from dataclasses import dataclass, field, replace

import numpy as np

from armside.arrays import Array
from armside.ilc.measures import norms as measures
from armside.sim.cell import CELLS
from armside.sim.laser import experiment as experiments
from armside.sim.laser.experiment import Experiment, Iteration
from armside.sim.robot.effects import Effect
from armside.sim.robot.individual import draw, structure_hinges, with_payload
from armside.sim.robot.model import RobotModel

from .commands.laser import LaserCfg, learning_law, task
from .laser_task import contour, robot

RIPPLE_BAND = (5.0, 14.0)
"""[Hz], around the resonances that learning leaves undamped."""
_PATH_STRIDE = 4  # tracker samples, 1 ms each
_RUN_WORTH = 1.0  # preparing costs as much as a second of simulated motion


@dataclass(frozen=True, kw_only=True)
class LearningJob:
    """`armside laser` with its options, and what that command does not offer."""

    laser: LaserCfg = field(default_factory=LaserCfg)
    seed: int = 0
    repetition: int = 0
    """Of the same experiment on the same robot: other noise only."""
    payload: float | None = None
    """Mass of the tool [kg]; None: as the options have it."""
    payload_known: bool = True
    """The controller knows the payload."""
    individual: int | None = None
    """Seed of an individual with stiffness, phases and geometry of its own; None: friction only."""
    friction_feedforward: float = 0.0
    """Share of friction that the controller feeds forward; 0: what the robot's own does."""
    series: bool = True
    """Keep corrections, errors and tool paths, not only measures."""

    @property
    def cost(self) -> float:
        """Rough, relative: for the time left."""
        turn = contour(self.laser).length / (1e-3 * self.laser.speed)
        return (self.laser.iterations + 1) * (1.2 * turn + 0.9) + _RUN_WORTH

    def run(self) -> dict[str, Array]:
        """Run it. Arrays have the iterations 0 .. K first.

        motor_inf, motor_two: (K, 6) [motor rad]. arm_rms, arm_maxdev, arm_rms_true,
        arm_maxdev_true, ripple: (K,) [m]. reached_speed [m/s], gear (6,), diverged, motion_end
        [sample]. NaN where a diverged experiment had ended.
        With `series`: error, correction (K, N, 6) [rad], path (K, M, 2) [m].
        """
        experiment = self.prepare()
        law = learning_law(self.laser)
        rows, last_diverged = [], False
        for it in experiments.iterate(experiment, law, self.laser.iterations):
            rows.append(self._row(it, experiment))
            last_diverged = it.trial.diverged
        missing = self.laser.iterations + 1 - len(rows)
        arrays = {name: _stack([row[name] for row in rows], missing) for name in rows[0]}
        return arrays | {
            "diverged": np.array(missing > 0 or last_diverged),
            "reached_speed": np.array(experiment.motion.reached_speed),
            "motion_end": np.array(self._motion_end(experiment)),
            "gear": experiment.loaded.model.drives.gear,
        }

    def prepare(self) -> Experiment:
        """The experiment before its first run."""
        cfg = self.laser
        cell = CELLS[cfg.robot]
        design = robot(cfg)
        loaded = design if self.payload is None else with_payload(design, self.payload)
        individual = None
        if self.individual is not None:
            rng = np.random.default_rng(self.individual)
            individual = draw(rng, len(structure_hinges(design)))
        return experiments.prepare(
            cell,
            self._as_known(loaded if self.payload_known else design),
            task(cfg),
            seed=self.seed,
            friction_spread=cfg.friction_spread * 1e-2,
            hardware=loaded,
            individual=individual,
            repetition=self.repetition,
            without=[Effect(name) for name in cfg.without],
        )

    def _as_known(self, model: RobotModel) -> RobotModel:
        if self.friction_feedforward == 0.0:
            return model
        drives = replace(model.drives, friction_feedforward=self.friction_feedforward)
        return replace(model, drives=drives)

    def _motion_end(self, experiment: Experiment) -> int:
        """The first sample at which the reference rests again."""
        motion = experiment.motion
        return int(np.searchsorted(motion.time, motion.rest_before + motion.timing.duration))

    def _row(self, it: Iteration, experiment: Experiment) -> dict[str, Array]:
        radii = np.hypot(*it.arm.path.T)
        first, last = experiment.motion.contour_time
        row = {
            "motor_inf": measures.inf_norm(it.motor_error),
            "motor_two": measures.two_norm(it.motor_error),
            "arm_rms": np.array(it.arm.rms),
            "arm_maxdev": np.array(it.arm.maxdev),
            "arm_rms_true": np.array(it.arm_true.rms),
            "arm_maxdev_true": np.array(it.arm_true.maxdev),
            "ripple": np.array(measures.circle_ripple(radii, last - first, *RIPPLE_BAND)),
        }
        if self.series:
            # Single precision is 1e-7 of an error of a milliradian: far below an encoder count.
            row["error"] = it.trial.error.astype(np.float32)
            row["correction"] = it.trial.correction.astype(np.float32)
            row["path"] = it.arm.path[::_PATH_STRIDE].astype(np.float32)
        return row


def _stack(rows: list[Array], missing: int) -> Array:
    """(K, ...) with NaN for the iterations that were not run."""
    return np.array(rows + [np.full_like(rows[0], np.nan)] * missing)
