"""Tracks on the large robot: individuals of a production line cut contours by unknown parameters.

`motor`, `imu` and `tracker` learn one contour with those sensors; `first` has ten recordings of
other cuts and one run; in `drift` payload, friction and temperature change between runs; `part`
cuts several contours in one run.
"""

from collections.abc import Callable, Mapping
from dataclasses import asdict, fields, replace
from functools import cache, partial
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from armside.arrays import Array

from ..cell import LARGE_CELL, TOOL_QUATERNION, ToolPose
from ..laser.experiment import Experiment, Pass, prepare
from ..laser.part_cut import PartCut
from ..laser.specification import Cut
from ..part.arcs import Chain
from ..part.drawing import DrawnChain
from ..part.plan import Cutting
from ..robot.kinematics_check import cell_model
from ..robot.model import RobotModel
from ..robot.spread import PRODUCTION, Spread
from ..robot.spread import Drawn as DrawnRobot
from ..robot.virtual_robot import LOG_PERIOD
from ..twin.commission import MOST, plan
from .nominal import SHAPES, cut_of
from .seal import Round
from .task import Drawn, Limits, Ranges, Task, Track, last

RUNS, DRIFT_RUNS = 6, 8
MOST_CORRECTION, MOST_CHANGE = 0.02, 0.004
"""[rad], arm side, of each axis, in size and in one sample: ten times what a twin or the thesis's
design asks for, and 1 rad/s. ESTIMATES"""
RANGES: Ranges = {
    "x": ((1.4, 2.1), (1.2, 2.3)),
    "y": ((-0.6, 0.6), (-0.8, 0.8)),
    "z": ((1.1, 1.8), (1.0, 2.0)),
    "turn": ((-0.3, 0.3), (-0.5, 0.5)),
    "size": ((0.010, 0.050), (0.006, 0.080)),
    "speed": ((0.03, 0.08), (0.02, 0.10)),
    "payload": ((20.0, 80.0), (0.0, 120.0)),
    "widths": ((1.0, 1.0), (0.9, 1.3)),
    "friction step": ((-0.03, 0.05), (-0.05, 0.08)),
    "payload step": ((-5.0, 5.0), (-10.0, 10.0)),
    "cold": ((26.0, 40.0), (26.0, 50.0)),
    "warming": ((0.0, 15.0), (0.0, 25.0)),
}
"""Position of the contour [m] and turn of the tool [rad], width [m] and speed [m/s] with uniform
logarithm, payload [kg] that the controller knows, widths of the production line over
`PRODUCTION`, changes of friction and payload [kg] between runs, gears' temperature at first and
its rise over all runs [deg C]. ESTIMATES."""
PUBLIC_SHAPES = ("circle", "square")
"""Of development; judged rounds have all of SHAPES."""


@cache
def _nominal() -> RobotModel:
    return cell_model(LARGE_CELL, None)


def _robot(drawn: Drawn) -> DrawnRobot:
    """An individual of a line that is as wide as drawn."""
    by = drawn("widths")
    widths = {f.name: getattr(PRODUCTION, f.name) * by for f in fields(Spread)}
    return DrawnRobot(drawn.key("robot"), replace(PRODUCTION, **widths))


def _pose(drawn: Drawn) -> ToolPose:
    x, y, z = drawn("x"), drawn("y"), drawn("z")
    turned = Rotation.from_quat(TOOL_QUATERNION, scalar_first=True) * Rotation.from_rotvec(
        [drawn("turn") for _ in "xyz"]
    )
    w, a, b, c = turned.as_quat(scalar_first=True).tolist()
    return ToolPose((x, y, z), (w, a, b, c))


def _cut(drawn: Drawn, *, imu: bool = False) -> tuple[dict[str, Any], Cut]:
    """What the controller knows of a cut that can be made, and the cut by its individual."""
    robot = _robot(drawn)
    while True:
        pose = _pose(drawn)
        shapes = tuple(SHAPES) if drawn.judged else PUBLIC_SHAPES
        nominal = {
            **{"robot": "large", "imu": imu, "shape": str(drawn.rng.choice(shapes))},
            **{"position": pose.position, "quaternion": pose.quaternion},
            **{"size": drawn.log("size"), "speed": drawn.log("speed")},
            "payload": drawn("payload"),
        }
        cut = replace(cut_of(nominal), individual=robot)
        try:
            prepare(cut, nominal=_nominal())
        except ValueError:  # out of reach
            continue
        return nominal, cut


def _given(
    name: str, runs: int, experiment: Experiment, nominal: dict[str, Any], seed: int
) -> tuple[dict[str, Any], Limits]:
    reference = experiment.loaded.reference
    lower, upper = np.array(LARGE_CELL.limits.lower), np.array(LARGE_CELL.limits.upper)
    margin = np.minimum(reference - lower, upper - reference).min(axis=0)
    most = np.minimum(np.full(reference.shape[1], MOST_CORRECTION), np.maximum(margin, 1e-9))
    limits = Limits(correction=most, change=np.full(len(most), MOST_CHANGE))
    given = {
        **{"track": name, "runs": runs, "reference": reference, "sample_time": LOG_PERIOD},
        **{"path": experiment.programmed, "nominal": nominal, "limits": vars(limits)},
        "seed": seed,
    }
    return given, limits


def records(run: Pass, *, imu: bool, tracker: bool) -> dict[str, Any]:
    """What an entry sees of a run."""
    log = run.recording
    found: dict[str, Any] = {
        **{"error": log.error, "correction": log.correction},
        **{"motor_angle": log.motor_angle, "motor_torque": log.motor_torque},
    }
    if imu and run.imu is not None:
        found["imu"] = asdict(run.imu)
    if tracker:
        found["tracker"] = {"time": run.tracker.time, "position": run.tracker.position}
    return found


def _worst(experiment: Experiment, run: Pass) -> float:
    """True RMS [m] of the tool, of the worst contour."""
    errors = experiment.cut.errors(experiment.motion, *run.true, edges=False)
    return max(error.rms for error in errors)


def _task(
    experiment: Experiment,
    given: dict[str, Any],
    limits: Limits,
    see: Callable[[Pass], dict[str, Any]],
) -> Task:
    """A task of one robot that stays as it is."""

    def run(k: int, correction: Array) -> tuple[dict[str, Any], float]:
        made = experiment.plant.run(correction)
        return see(made), _worst(experiment, made)

    def plain() -> Array:
        return np.array([run(0, np.zeros_like(given["reference"]))[1]])

    return Task(given=given, limits=limits, run=run, plain=plain)


def draw(name: str, round: Round, index: int) -> Task:
    """Task of `motor`, `imu` or `tracker`, and of `first`."""
    drawn = Drawn(RANGES, round, name, index)
    nominal, cut = _cut(drawn, imu=name == "imu")
    seed, own = drawn.key("noise"), drawn.key("entry") % 2**32
    experiment = prepare(cut, seed=seed, nominal=_nominal())
    runs = 1 if name == "first" else RUNS
    given, limits = _given(name, runs, experiment, nominal, own)
    if name == "first":
        given["commissioning"] = [
            _recorded(cut, drawn.key("commissioning", i), c) for i, c in enumerate(plan(MOST))
        ]
    see = partial(records, imu=name == "imu", tracker=name == "tracker")
    return _task(experiment, given, limits, see)


def _recorded(task: Cut, seed: int, cut: Cut) -> dict[str, Any]:
    """An uncorrected commissioning cut of a task's robot, with a tracker."""
    experiment = prepare(replace(cut, individual=task.individual), seed=seed)
    reference = experiment.loaded.reference
    run = experiment.plant.run(np.zeros_like(reference))
    return {"reference": reference, **records(run, imu=False, tracker=True)}


def draw_drift(round: Round, index: int) -> Task:
    """Task of `drift`: the robot of each run is another."""
    drawn = Drawn(RANGES, round, "drift", index)
    nominal, cut = _cut(drawn)
    seed, own = drawn.key("noise"), drawn.key("entry") % 2**32
    steps = [(drawn("friction step"), drawn("payload step")) for _ in range(DRIFT_RUNS)]
    cold, warming = drawn("cold"), drawn("warming")
    base = cut.payload or 0.0
    friction, payload = np.cumsum(steps, axis=0).T
    payload = np.maximum(base + payload - payload[0], 0.0)
    asked = prepare(cut, seed=seed, nominal=_nominal())
    given, limits = _given("drift", DRIFT_RUNS, asked, nominal, own)
    plan_of_all = asked.motion, asked.loaded.reference

    @cache
    def experiment(k: int) -> Experiment:
        warm = cold + warming * k / (DRIFT_RUNS - 1)
        now = replace(
            cut, friction_drift=float(friction[k]), payload=float(payload[k]), temperature=warm
        )
        # The controller goes on with the path and the payload that it was given.
        return prepare(
            now, seed=seed, repetition=k, nominal=_nominal(), planned=lambda _: plan_of_all
        )

    def run(k: int, correction: Array) -> tuple[dict[str, Any], float]:
        made = experiment(k).plant.run(correction)
        return records(made, imu=False, tracker=False), _worst(experiment(k), made)

    def plain() -> Array:
        zero = np.zeros_like(given["reference"])
        return np.array([run(k, zero)[1] for k in range(DRIFT_RUNS)])

    return Task(given=given, limits=limits, run=run, plain=plain)


def draw_part(round: Round, index: int) -> Task:
    """Task of `part`: a square plate with a round hole and a slot. Needs the extra `parts`."""
    from ..part.part import part_of

    drawn = Drawn(RANGES, round, "part", index)
    robot = _robot(drawn)
    while True:
        pose, chains = _pose(drawn), _plate(0.02 + drawn.log("size"), drawn)
        cut = PartCut(
            **{"pose": pose, "individual": robot, "friction_spread": 0.0},
            part=part_of([DrawnChain(chain, name, "") for name, chain in chains.items()]),
            cutting=Cutting(speed=drawn.log("speed")),
            payload=drawn("payload"),
        )
        seed = drawn.key("noise")
        try:
            experiment = prepare(cut, seed=seed, nominal=_nominal())
        except ValueError:  # out of reach
            continue
        break
    nominal = {
        **{"robot": "large", "position": pose.position, "quaternion": pose.quaternion},
        **{"speed": cut.cutting.speed, "payload": cut.payload},
        "contours": [
            {"name": name, "points": chain.points, "bulge": chain.bulge}
            for name, chain in chains.items()
        ],
    }
    given, limits = _given("part", RUNS, experiment, nominal, drawn.key("entry") % 2**32)
    return _task(experiment, given, limits, partial(records, imu=False, tracker=True))


def _plate(side: float, drawn: Drawn) -> dict[str, Chain]:
    """Contours of a plate [m]: its square, a hole and a slot beside it."""
    a, r, w = 0.5 * side, side * drawn.rng.uniform(0.08, 0.18), side * drawn.rng.uniform(0.04, 0.08)
    x, long = 0.45 * a, side * drawn.rng.uniform(0.1, 0.25)
    corners = [(-a, -a), (a, -a), (a, a), (-a, a), (-a, -a)]
    ends = [(x - w, -long), (x + w, -long), (x + w, long), (x - w, long), (x - w, -long)]
    return {
        "outline": Chain(np.array(corners), np.zeros(4)),
        "hole": Chain(np.array([(-x - r, 0.0), (-x + r, 0.0), (-x - r, 0.0)]), np.ones(2)),
        "slot": Chain(np.array(ends), np.array([1.0, 0.0, 1.0, 0.0])),
    }


def over_all_runs(errors: Array, plain: Array) -> float:
    """RMS over all runs."""
    return float(np.sqrt(np.mean(np.square(errors)) / np.mean(np.square(plain))))


def _track(
    name: str,
    score: str,
    draw: Callable[[Round, int], Task],
    runs: int = RUNS,
    left: Callable[[Array, Array], float] = last,
    goes_on: bool = False,
) -> Track:
    return Track(
        **{"name": name, "runs": runs, "seconds": SECONDS, "ranges": RANGES, "goes_on": goes_on},
        draw=draw,
        left=left,
        score=score,
    )


SECONDS = 1800.0
"""For each answer: a twin is commissioned in one, in minutes."""
_RMS = "true tool RMS left in the last run"
TRACKS: Mapping[str, Track] = {
    **{name: _track(name, _RMS, partial(draw, name)) for name in ("motor", "imu", "tracker")},
    "first": _track("first", "true tool RMS left in the first run", partial(draw, "first"), 1),
    "drift": _track(
        *("drift", "true tool RMS left over all runs", draw_drift, DRIFT_RUNS, over_all_runs, True)
    ),
    "part": _track("part", "true tool RMS left of the worst contour, last run", draw_part),
}
