"""The rules of an episode, shared by the single and the vector env: spaces, draws, steps, rewards.

The reward is that of `armside.sim.tuning.env.IlcTuningEnv`, with the tool's RMS after (9.6).
"""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike, fspath
from typing import Any, NamedTuple

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import ArrayLike

from armside.arrays import Array
from armside.ilc.measures.norms import two_norm
from armside.ilc.models.system import System

from ..cell import CELLS, Cell
from ..instruments.imu import ImuCfg
from ..laser.design import Design
from ..laser.experiment import Experiment
from ..laser.specification import Cut
from ..robot.individual import Individual
from ..robot.kinematics_check import cell_model
from ..robot.model import RobotModel
from ..robot.spread import Drawn, check_applies
from ..robot_file.find import find_cell
from ..twin.twin import learned, stored_twin
from . import episode_task as task
from . import outlook
from .action import (
    BASES,
    LARGEST_COUNT,
    VARIABLES,
    Coefficients,
    CorrectionBasis,
    Motors,
    design_of,
)
from .episode_task import RANGES, TEST_SEEDS, Shapes, Task, shapes_of, whole
from .observation import Layout
from .situation import RewardSensor, Situation, begin, restarted, run

WORST_REWARD = -5.0  # Reward of a run that diverged; also the bound of every other
HORIZON = 20
"""Update up to which version 1 holds the last design of an episode."""

Decision = Design | Coefficients
"""What an action stands for."""
Step = tuple[np.ndarray, float, bool, bool, dict[str, Any]]
"""Observation, reward, diverged, budget used up, info."""


class Score(NamedTuple):
    """Reward of a step."""

    log_decrease: float
    """log(RMS before / RMS after) as measured by the sensor; NaN where it has no measure."""
    reward: float
    """The same within bounds, or the reward of a run that diverged."""


@dataclass(frozen=True, kw_only=True)
class EnvCfg:
    """Options of the envs, of which `gymnasium.make` takes each as a keyword."""

    robot: str | PathLike[str] = "large"
    """large, irb1400, or a robot file (.toml)."""
    motors: str = "shared"
    """shared, one design for all motors, or each."""
    reward: str = "tracker"
    """Sensor that the reward is computed from: tracker, estimate or motor."""
    iterations: int = 5
    """Learning iterations of an episode, 1 to 10: the budget of the thesis."""
    sealed: bool = False
    """Take the sealed test seeds, TEST_SEEDS, and only those; they are refused otherwise."""
    individual: int | Drawn | Individual | None = None
    """The robot of every episode, as the option of `reset`; drawn if None."""
    twin: str | PathLike[str] | None = None
    """Folder of `armside commission` for that individual: the first run of an episode is corrected
    by it, and learning goes on around its correction."""
    shape: str | Sequence[str] = "circle"
    """circle, square, slot or hexagon, or several, one of which each episode draws."""
    radius: float | Sequence[float] | None = None
    """[m] of a circle, half the side of a square, the width of a hexagon or the length of a slot;
    or a range (low, high) that each episode draws from. By default 5 mm, for a slot 15 and for the
    others 10."""
    action: str = "design"
    """design, or correction: the next correction itself."""
    basis: str = "b-splines"
    """b-splines or harmonics, of which corrections are made."""
    functions: int = 12
    """Functions of the basis, of each axis: 2 to 60."""
    version: int = 0
    """1: wider tasks, payload observed, and a reward that looks past the last update."""


@dataclass(frozen=True, kw_only=True)
class Rules(EnvCfg):
    """Rules common to all episodes of a configuration. Safe to use from several threads.

    Raises ValueError for a value that does not exist; the message lists those that do.
    """

    def __post_init__(self) -> None:
        _ = self.cell  # the first to be refused
        for name, allowed in (
            ("motors", [m.value for m in Motors]),
            ("reward", [s.value for s in RewardSensor]),
            ("action", ("design", "correction")),
            ("basis", BASES),
        ):
            if (value := getattr(self, name)) not in list(allowed):
                raise ValueError(f"Unknown {name} {value!r}. It can be: {', '.join(allowed)}")
        if not isinstance(self.sealed, bool):
            raise ValueError(f"sealed must be True or False, got {self.sealed!r}")
        for name, low, high in (
            ("iterations", 1, 10),
            ("functions", 2, LARGEST_COUNT),
            ("version", 0, len(RANGES) - 1),
        ):
            object.__setattr__(self, name, whole(name, getattr(self, name), low, high))
        _ = self.layout, self.nominal
        if isinstance(self.individual, Individual):
            check_applies(self.nominal, self.individual)
        elif self.individual is not None and not isinstance(self.individual, Drawn):
            whole("individual", self.individual, 0)
        if self.twin is not None:
            if self.individual is None:
                raise ValueError("a twin is of one robot: give its individual too")
            stored_twin(self.twin).check(Cut(robot=self.cell))

    @cached_property
    def cell(self) -> Cell:
        """The robot's cell."""
        robot = fspath(self.robot) if isinstance(self.robot, PathLike) else self.robot
        if not isinstance(robot, str):
            raise ValueError(f"robot must be a name or a robot file (.toml), got {robot!r}")
        return find_cell(robot)

    @cached_property
    def nominal(self) -> RobotModel:
        """Nominal robot of the controller."""
        return cell_model(self.cell)

    @cached_property
    def shapes(self) -> Shapes:
        """Contours that are cut."""
        shapes = shapes_of(self.shape, self.radius)
        if self.radius is None and shapes.names == ("circle",):
            ranges = RANGES[self.version]
            return Shapes(shapes.names, ranges.radius, ranges.logarithmic)
        return shapes

    @cached_property
    def layout(self) -> Layout:
        """Entries of the observation."""
        basis = CorrectionBasis(self.basis, self.functions)
        own = basis if self.action == "correction" else None
        return Layout(self.cell.robot.n_joints, self.shapes, own, payload=self.version > 0)

    @property
    def robot_or_cell(self) -> str | Cell:
        """Name of a robot that has one, else its cell."""
        return self.robot if isinstance(self.robot, str) and self.robot in CELLS else self.cell

    @property
    def n_axes(self) -> int:
        """Motors of the robot."""
        return self.layout.n_axes

    @property
    def action_space(self) -> Box:
        """(3,), three of each motor, or the coefficients of each axis, as
        `armside.sim.tuning.env.IlcTuningEnv` has them."""
        if self.layout.basis is not None:
            size = self.n_axes * self.layout.basis.count
        else:
            size = len(VARIABLES) * Motors(self.motors).count(self.n_axes)
        return Box(-1.0, 1.0, (size,), np.float32)

    @property
    def observation_space(self) -> Box:
        """(50,) with six axes, in the table of `armside.sim.tuning.env.IlcTuningEnv`."""
        return Box(-1.0, 1.0, (self.layout.size,), np.float32)

    @cached_property
    def T_u(self) -> System:
        """The controller's model of each motor."""
        return outlook.motor_model(self.robot_or_cell)

    def check_seed(self, seed: Any) -> int | None:
        """A seed of Python or NumPy, or None. Raises ValueError for what is none, for a sealed one,
        or for no sealed one where it must be."""
        seed = None if seed is None else whole("seed", seed, 0)
        if self.sealed and (seed is None or seed not in TEST_SEEDS):
            raise ValueError(f"a sealed env is reset with a seed of {TEST_SEEDS}, got {seed}")
        if not self.sealed and seed is not None and seed in TEST_SEEDS:
            raise ValueError(
                f"seed {seed} belongs to the sealed test seeds {TEST_SEEDS}; "
                "only an env made with sealed=True takes them"
            )
        return seed

    def draw(self, rng: np.random.Generator, options: Mapping[str, Any] | None = None) -> Task:
        """Draw a task. See `armside.sim.tuning.episode_task.draw`."""
        if self.individual is not None and isinstance(options, Mapping | None):
            options = {"individual": self.individual} | dict(options or {})
        return task.draw(self.robot_or_cell, rng, options, self.shapes, RANGES[self.version])

    def begin(self, drawn: Task) -> Situation:
        """Build the experiment of a task and run it without learning."""
        return self.first(*self.prepared(drawn))

    def prepared(self, drawn: Task, imu: ImuCfg | None = None) -> tuple[Task, Experiment]:
        """A task within reach and its experiment. Raises as `task.experiment`."""
        imu = imu or RewardSensor(self.reward).imu
        return task.within_reach(self.robot_or_cell, self.nominal, drawn, imu)

    def first(self, drawn: Task, experiment: Experiment) -> Situation:
        """The first run of a task, corrected by the twin if there is one."""
        cut = experiment.cut
        assert isinstance(cut, Cut), "tasks are of one contour"
        twin = None if self.twin is None else learned(stored_twin(self.twin), cut)
        return begin(drawn, experiment, RewardSensor(self.reward), twin)

    def decision(self, action: ArrayLike) -> Decision:
        """The design, or the correction, of an action. Raises ValueError as `design_of` does."""
        if self.layout.basis is not None:
            return self.layout.basis.decoded(action, self.n_axes)
        return design_of(action, Motors(self.motors), self.n_axes)

    def advance(self, situation: Situation, decision: Decision) -> Situation:
        """Learn once with a design, or take the chosen correction, and run again."""
        centre = situation.centre
        if isinstance(decision, Coefficients):
            correction = centre + decision.correction(len(centre), situation.size)
        else:
            correction = centre + decision.law(situation.correction - centre, situation.error)
        return run(situation, correction, situation.k + 1)

    def score(self, before: Situation, after: Situation) -> Score:
        """The reward of a step."""
        first, second = before.measured.rms, after.measured.rms
        if np.isfinite(first) and np.isfinite(second) and first > 0.0 and second > 0.0:
            decrease = float(np.log(first / second))
            reward = min(max(decrease, WORST_REWARD), -WORST_REWARD)
        else:
            decrease, reward = np.nan, 0.0
        return Score(decrease, WORST_REWARD if after.diverged else reward)

    def truncated(self, situation: Situation) -> bool:
        """The budget of iterations is used up."""
        return situation.k >= self.iterations and not situation.diverged

    def step(self, before: Situation, after: Situation, decision: Decision) -> Step:
        """Outcome of an iteration with a decision, as Gymnasium has it."""
        score, ends = self.score(before, after), (after.diverged, self.truncated(after))
        ahead: dict[str, Any] = {}
        if isinstance(decision, Design):
            ahead["criterion"] = self.criterion(decision)
        if isinstance(decision, Design) and self.version:
            correction, error = self.predicted(after, decision)
            gear = after.experiment.loaded.model.drives.gear
            ahead["motor_error_predicted"] = two_norm(error * gear)
            if self.truncated(after):
                held = self._at_horizon(after, correction)
                later = self.score(before, held)
                if ahead["criterion"] >= 1.0:
                    later = later._replace(reward=WORST_REWARD)
                ahead["rms_held"] = float(held.measured.rms)
                ahead["rms_held_true"] = float(held.true.rms)
                score = min(score, later, key=lambda one: one.reward)
        return self.observe(after), score.reward, *ends, self.info(after, decision, score) | ahead

    def criterion(self, design: Design) -> float:
        """sup |Q (1 - L T_u)|, the largest of all motors. Thesis (7.5)."""
        return outlook.contraction(self.T_u, design)

    def predicted(
        self, situation: Situation, design: Design, until: int = HORIZON
    ) -> tuple[Array, Array]:
        """Correction and error (N, n) [rad], arm side, of run `until`, by the model."""
        centre, error = situation.centre, situation.error
        correction = situation.correction - centre
        for _ in range(until - situation.k):
            following = design.law(correction, error)
            error = error - self.T_u.simulate(following - correction)
            correction = following
        return centre + correction, error

    def held(self, situation: Situation, design: Design, until: int = HORIZON) -> Situation:
        """A run with the correction that is predicted; the episode's noise stays as it is."""
        return self._at_horizon(situation, self.predicted(situation, design, until)[0])

    @staticmethod
    def _at_horizon(situation: Situation, correction: Array) -> Situation:
        return run(restarted(situation), correction, HORIZON)

    def observe(self, situation: Situation) -> np.ndarray:
        """See `armside.sim.tuning.observation`."""
        return self.layout.of(situation)

    def info(
        self, situation: Situation, decision: Decision | None = None, score: Score | None = None
    ) -> dict[str, Any]:
        """Physical values and ground truth, for evaluation; a policy does not get them.

        Keys, the same after `reset` but for those of a step:

        - k, status (running, done or diverged);
        - the task, which as options of `reset` gives the same episode: pose, speed [m/s], payload
          [kg] (None where a robot keeps its own tool), individual (one that is no seed needs the
          seed of `reset` too, for noise), shape, radius [m]; and speed_reached [m/s];
        - truth: rms_true, maxdev_true [m];
        - motors: motor_error_two, motor_error_inf, one for each [rad] of the shaft;
        - reward terms: rms_seen, maxdev_seen [m] as the configured sensor has them; of a step
          log_decrease, log(RMS before / RMS after), NaN where there is none;
        - with a twin: rms_predicted [m], expected of the first run, and trusted, whether it is
          corrected;
        - of a step: gamma, delta [samples] and cutoff [Hz], one for each motor, or the coefficients
          (n, m) of the correction;
        - of a step with a design, by the controller's model: criterion, sup |Q (1 - L T_u)|, above
          1 where motors diverge; in version 1 also motor_error_predicted, one 2-norm for each [rad]
          of the shaft, after HORIZON updates all with this design;
        - of the last step in version 1: rms_held [m], of a run with the correction predicted there,
          and its truth, rms_held_true.
        """
        drawn, twin = situation.task, situation.twin
        status = "done" if self.truncated(situation) else "running"
        return {
            "k": situation.k,
            "status": "diverged" if situation.diverged else status,
            "pose": drawn.pose,
            "speed": drawn.speed,
            "payload": drawn.payload,
            "individual": drawn.individual,
            "shape": drawn.shape,
            "radius": drawn.radius,
            "speed_reached": float(situation.experiment.motion.reached_speed),
            "rms_true": float(situation.true.rms),
            "maxdev_true": float(situation.true.maxdev),
            "motor_error_two": situation.two_norm.copy(),
            "motor_error_inf": situation.inf_norm.copy(),
            "rms_seen": float(situation.measured.rms),
            "maxdev_seen": float(situation.measured.maxdev),
            **({} if twin is None else {"rms_predicted": twin.prediction.expected}),
            **({} if twin is None else {"trusted": twin.trusted}),
            **({} if score is None else {"log_decrease": score.log_decrease}),
            **({} if decision is None else decision.arrays(self.n_axes)),
        }


def show_compilation() -> None:
    """Print a line on stderr for each function that the first use of a robot compiles, unless
    logging is set up."""
    log = logging.getLogger("armside.kinematics.cache")
    if not log.hasHandlers():
        log.addHandler(handler := logging.StreamHandler())
        handler.setFormatter(logging.Formatter("armside: %(message)s"))
        log.setLevel(logging.INFO)
