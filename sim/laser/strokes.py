"""Straight strokes in one plane, each from rest to rest: a `Setup` of learning.

The square of Chen and Tomizuka, IEEE Trans. Control Systems Technology 22(4), 2014, is not a
contour with rounded corners: the tool stops in each.
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields
from itertools import pairwise

import numpy as np

from armside import assets
from armside.arrays import Array, check_numbers

from ..cell import CELLS, Cell
from ..estimation.imu_health import ImuError
from ..evaluation.contour_error import contour_errors
from ..evaluation.motion_error import MotionError
from ..evaluation.tool_error import ToolError
from ..instruments.noise import rate_of, stride
from ..motion.timing import PathLimits, rest_to_rest
from ..notes import Cause, Note
from ..part.arcs import Chain
from ..part.curve import Kind
from ..part.motion import CutLeg, PartMotion, samples_until
from ..robot.statics import Statics
from ..robot.virtual_robot import LOG_PERIOD
from ..robot_file.find import find_cell
from .experiment import Iteration, prepare
from .loop import learn
from .part_cut import JointSpeedError, reference, timed
from .specification import Ended, Row, Setup, Timed

ROBOTS = assets.LARGE_ROBOT_XML.parent
REST_BEFORE, REST_AFTER = 0.5, 1.0
"""[s], as in the record of the paper: from 1.5 to 5.5 s, with strokes from 2.0 s on."""
PERIOD = 0.75
"""[s], of the square."""
SLOWER = 0.9
"""Factor on the speed, as often as a joint would be too fast. ESTIMATE"""


@dataclass(frozen=True, kw_only=True)
class Strokes(Setup[PartMotion]):
    """Strokes around the pose, without `corners` those of a square. SI units."""

    side: float = 0.1
    """[m], of the square."""
    corners: tuple[tuple[float, float], ...] = ()
    """(S + 1) places [m] in the plane, from the pose, at which the tool stops."""
    period: float = PERIOD
    """[s], from the beginning of a stroke to that of the next."""
    speed: float = 1.0
    """[m/s], at most."""
    limits: PathLimits = field(default_factory=lambda: PathLimits(acceleration=12.5, jerk=400.0))
    """Jerk: ESTIMATE, a stroke of 0.1 m takes 0.21 s; the paper's take 0.2 to 0.3 s."""

    def __post_init__(self) -> None:
        super().__post_init__()
        check_numbers(self, "side", "speed")
        for name in ("side", "speed"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be > 0, got {getattr(self, name)}")

    def planned(self, nominal: Statics) -> tuple[PartMotion, Array]:
        speed = self.speed
        while True:
            motion = self._motion(speed)
            with suppress(JointSpeedError):
                return motion, reference(self, nominal, motion)
            speed *= SLOWER

    def _motion(self, speed: float) -> PartMotion:
        half = 0.5 * self.side
        square = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]], dtype=np.float64)
        paths = [Chain(np.array(ends), np.zeros(1)) for ends in pairwise(self.corners or square)]
        timings = [rest_to_rest(path.length, speed, self.limits) for path in paths]
        if (duration := max(timing.duration for timing in timings)) > self.period:
            longest = f"the time of {self.period:g} s from one to the next"
            raise ValueError(f"a stroke takes {duration:.3g} s, more than {longest}")
        legs = tuple(
            CutLeg(
                path=path,
                timing=timing,
                start=REST_BEFORE + self.period * i,
                name=f"stroke {i + 1}",
                kind=Kind.OPEN,
                lead=0.0,
                asked_speed=self.speed,
            )
            for i, (path, timing) in enumerate(zip(paths, timings, strict=True))
        )
        return PartMotion(
            legs=legs,
            plane=self.plane,
            middle=(0.0, 0.0),
            tool_quaternion=self.tool_pose.quaternion,
            n_samples=samples_until(legs, REST_AFTER, LOG_PERIOD),
            step=LOG_PERIOD,
            rest_before=REST_BEFORE,
        )

    def errors(
        self, motion: PartMotion, time: Array, position: Array, *, edges: bool = True
    ) -> tuple[ToolError, ...]:
        every = stride(rate_of(time), 1.0 / LOG_PERIOD)
        return contour_errors(motion, time[::every], position[::every], None)

    def whole(self, motion: PartMotion, errors: Sequence[ToolError]) -> ToolError:
        """Strokes count alike."""
        return ToolError(
            rms=float(np.sqrt(np.mean([error.rms**2 for error in errors]))),
            maxdev=max(error.maxdev for error in errors),
            path=np.concatenate([error.path for error in errors]),
        )

    def contours(self, motion: PartMotion) -> Sequence[Timed]:
        return timed(motion)

    def weights(self, motion: PartMotion) -> Array:
        return np.ones((motion.n_samples, 1))

    def notes(self, motion: PartMotion) -> Iterator[Note]:
        reached = motion.cuts[0].reached_speed
        if reached < 0.999 * self.speed:
            text = f"the speed is lowered from {1e3 * self.speed:.4g} to {1e3 * reached:.4g} mm/s"
            yield Note(cause=Cause.SPEED, text=text)

    def entries(
        self, motion: PartMotion, contours: Sequence[Sequence[Row]], ends: Sequence[Ended]
    ) -> Row:
        return {"reached_speed": motion.cuts[0].reached_speed}


def robot_of(name: str) -> Cell:
    """Cell of a name, or of a file of the folder of robots."""
    return find_cell(name if name in CELLS else str(ROBOTS / name))


@dataclass(frozen=True)
class StrokesJob:
    """Learning the square by one measured output: ten runs of one individual."""

    robot: str = "large"
    """Name of a cell, or a file of the folder of robots."""
    measure: str = "motor"
    individual: int = 0
    """Seed of the robot's parameters and of the noise."""
    iterations: int = 9

    @property
    def cost(self) -> float:
        """Relative."""
        return 20.0 if self.measure == "estimate" else 4.0

    def run(self) -> dict[str, Array]:
        """Scalar fields of `MotionError` (10,) by name, NaN from a refusal or divergence on, and
        `reached_speed` [m/s]."""
        cut = Strokes(robot=robot_of(self.robot), across_tool=True, individual=self.individual)
        speed = prepare(cut, seed=self.individual).motion.cuts[0].reached_speed
        runs = learn(cut, measure=self.measure, iterations=self.iterations, seed=self.individual)
        return by_run(runs, self.iterations) | {"reached_speed": np.array(speed)}


def by_run(runs: Iterable[Iteration], iterations: int) -> dict[str, Array]:
    """Scalar fields of `MotionError` (`iterations` + 1,) by name, NaN from a refusal or divergence
    on."""
    names = fields_of_numbers()
    found = np.full((iterations + 1, len(names)), np.nan)
    with suppress(ImuError):  # refused: it has no numbers
        for it in runs:
            if not it.diverged:
                found[it.k] = [getattr(it.motion_error, name) for name in names]
    return dict(zip(names, found.T, strict=True))


def fields_of_numbers() -> list[str]:
    """Names of the fields of `MotionError` with one number for a record."""
    return [f.name for f in fields(MotionError) if f.name not in MotionError.PER_STOP]
