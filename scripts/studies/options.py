"""Options of `armside tune`."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter, validators

from armside.sim.cell import CELLS
from armside.sim.records.summary import plain
from armside.sim.tuning.episode_task import FASTEST, SLOWEST
from armside.sim.tuning.rules import HORIZON, Rules

from ..jobs.resolved import robot_content
from ..jobs.store import digest_of
from ..shell.options import Count, options
from .study import Pruner, Sampler

MM = 1e-3
_SEVERAL = Parameter(consume_multiple=True)
Shape = Literal["circle", "square", "slot", "hexagon"]
Shapes = Annotated[tuple[Shape, ...], _SEVERAL]
Radius = Annotated[tuple[float, ...], _SEVERAL]
"""[mm]: none, one, or smallest and largest."""


def contour_options(shape: tuple[Shape, ...], radius: tuple[float, ...]) -> dict[str, Any]:
    """Options of the env, [m]. Raises ValueError for more than two radii."""
    if len(radius) > 2:
        raise ValueError(f"radius takes one value, or smallest and largest, got {len(radius)}")
    ends = tuple(value * MM for value in radius)
    return {"shape": shape, "radius": None if not ends else ends[0] if len(ends) == 1 else ends}


@options
@dataclass(frozen=True, kw_only=True)
class TuneCfg:
    """What to tune, on which jobs, and how to search."""

    robot: str = "large"
    """Robot: large, irb1400, or a robot file (.toml)."""
    motors: Literal["shared", "each"] = "shared"
    """One design for all motors, or one for each."""
    reward: Literal["tracker", "motor", "estimate"] = "tracker"
    """Sensor that measures how round the cut is."""
    measure: Literal["motor", "estimate", "tracker"] = "motor"
    """Output that is learned from: the motors' angles, the estimate of the tool's path or the
    tracker's. The laws of the tool have gain and cutoff, and no shift."""
    pose: str | None = None
    """Where, by name [default: drawn for each episode]."""
    speed: float | None = None
    """Programmed speed, 1 to 100 [mm/s] [default: drawn for each episode]."""
    payload: float | None = None
    """Mass of the tool [kg] [default: drawn for each episode; other robots than the large one keep
    their own]."""
    shape: Shapes = ("circle",)
    """Shapes of the contours; of several, each episode draws one."""
    radius: Radius = ()
    """Radius of a circle, half the size of another shape, or the range that each episode draws from
    [mm] [default: 5; slot 15, square and hexagon 10]."""
    episodes: Count = 4
    """Jobs and robot individuals that a design is tried on, with seeds from --seed on."""
    iterations: int = 5
    """Learning iterations on each."""
    trials: Count = 50
    """Trials that the study shall have in the end, those it has already included. Processes that
    share it end the trial they are in: it may get one more of each."""
    nominal: Annotated[int, Parameter(validator=validators.Number(gte=0))] = 0
    """Random designs that the nominal robot tries beforehand at the same jobs, refused ones left
    out; the robots try its best three first."""
    alone: bool = False
    """Leave out the random search with as many runs, and the comparison of both designs on other
    jobs."""
    sampler: Sampler = "tpe"
    """Algorithm that proposes designs."""
    pruner: Pruner = "percentile"
    """Rule that gives up a design between iterations."""
    study: str | None = None
    """Name of the study; one that exists is resumed [default: named after what is tuned]."""
    storage: str = "sqlite:///runs/tune.sqlite3"
    """Database of studies, as an SQLAlchemy URL. Processes that share it share the work."""

    def __post_init__(self) -> None:
        low, high = 1e3 * SLOWEST, 1e3 * FASTEST
        if self.speed is not None and not low <= self.speed <= high:
            raise ValueError(f"speed must be from {low:g} to {high:g} mm/s, got {self.speed:g}")
        if self.payload is not None and not 0.0 <= self.payload < float("inf"):
            raise ValueError(f"payload must be >= 0 kg, got {self.payload:g}")
        if self.study is not None and not self.study.strip():
            raise ValueError(f"study must have a name, got {self.study!r}")
        if self.measure != "motor" and (self.motors, self.nominal) != ("shared", 0):
            raise ValueError(
                f"--motors each and --nominal need --measure motor, not {self.measure}"
            )
        _ = self.rules  # raises ValueError where the options are out of range

    @property
    def rules(self) -> Rules:
        """Rules of the episodes."""
        return Rules(
            robot=self.robot,
            motors=self.motors,
            reward=self.reward,
            iterations=self.iterations,
            **contour_options(self.shape, self.radius),
        )

    @property
    def fixed(self) -> dict[str, Any]:
        """Options that are not drawn for each episode, as the env has them."""
        speed = None if self.speed is None else self.speed * 1e-3
        given = {"pose": self.pose, "speed": speed, "payload": self.payload}
        return {name: value for name, value in given.items() if value is not None}

    def identity(self, seed: int) -> dict[str, Any]:
        """Options that make two studies comparable: all of the task, nothing of the search."""
        search = ("trials", "alone", "nominal", "sampler", "pruner", "study", "storage")
        task = {key: v for key, v in plain(self).items() if key not in search}
        # Studies of before had another objective: designs were not held past the last update.
        task |= {"seed": seed, "held": HORIZON}
        # What is as it was before there was a choice has no part in the identity of older studies.
        for name, value in (("shape", ["circle"]), ("radius", []), ("measure", "motor")):
            if task[name] == value:
                del task[name]
        if self.robot not in CELLS:
            task["robot_content"] = robot_content(self.robot)
        return task

    def named(self, seed: int) -> "TuneCfg":
        """The same with the name of its study, which only comparable studies share."""
        if self.study:
            return self
        key = digest_of(self.identity(seed))[:8]
        what = self.motors if self.measure == "motor" else f"from-{self.measure}"
        return replace(self, study=f"{Path(self.robot).stem}-{what}-{self.reward}-{key}")
