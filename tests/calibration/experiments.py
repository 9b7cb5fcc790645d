"""Experiments of calibration: the nominal robot with its gear effects, without noise."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from armside.arrays import Array
from armside.scripts.thesis.chapter9 import bands
from armside.scripts.thesis.chapter9.bands import POSES, Result
from armside.sim.evaluation.check import Check
from armside.sim.instruments.laser_tracker import TrackerSamples
from armside.sim.laser.design import Design
from armside.sim.laser.experiment import Experiment, Pass, prepare
from armside.sim.laser.job import arrays_of
from armside.sim.laser.loop import iterate
from armside.sim.laser.measures import MotorAngles
from armside.sim.laser.results import notes
from armside.sim.laser.specification import Cut
from armside.sim.notes import Note
from armside.sim.robot.effects import Effect
from armside.sim.robot.model import RobotModel


@dataclass(frozen=True)
class _NoiseFree:
    """The robot without noise, its tool measured as it is."""

    experiment: Experiment

    def run(self, correction: Array, /) -> Pass:
        recording = self.experiment.loaded.run(correction)
        truth = recording.truth
        rate = self.experiment.plant.tracker.cfg.rate
        every = slice(None, None, round(1.0 / (rate * float(truth.time[1]))))
        time, position = truth.time[every], truth.tool_position[every]
        valid = np.ones(len(time), dtype=bool)
        tracker = TrackerSamples(time=time, position=position, valid=valid)
        return Pass(recording=recording, tracker=tracker)


Say = Callable[[list[Note]], None]


def _nothing(_: list[Note]) -> None: ...


def learned(
    model: RobotModel,
    effects: frozenset[Effect],
    pose: str,
    *,
    speed: float = 0.040,
    cutoff: float = 10.0,
    delta: int = 3,
    iterations: int = 5,
    note: Say = _nothing,
) -> Result:
    """Run one experiment of the nominal robot; a result as `bands` reads it, of the true tool.

    speed: [m/s]. cutoff: [Hz]. note: called with the notes of the experiment.
    """
    without = tuple(effect for effect in Effect if effect not in effects)
    cut = Cut(pose=pose, speed=speed, friction_spread=0.0, without=without)
    experiment = prepare(cut, nominal=model)
    design = Design(gamma=(0.9,), delta=(delta,), cutoff=(cutoff,))
    set_up = MotorAngles(design).prepare(experiment)
    found = list(iterate(experiment, set_up, iterations, plant=_NoiseFree(experiment)))
    note(notes(experiment, found))
    fixed = {"gear": model.drives.gear, "motion_end": np.array(experiment.motion_end)}
    return arrays_of(found, experiment) | fixed


def learning_checks(
    model: RobotModel, effects: frozenset[Effect], note: Say = _nothing
) -> Iterator[Check]:
    """Motor side and arm side at 40 mm/s over poses, cutoff and shift: (a) to (d)."""
    run = partial(learned, model, effects, note=note)
    base = {pose: run(pose) for pose in POSES}
    yield from bands.motor_side(base)
    yield from bands.arm_side(base)
    fast = run("p1", cutoff=15.0)
    yield from bands.cutoff_arm(base["p1"], fast)
    yield from bands.cutoff_motor(base["p1"], fast)
    yield from bands.shift_arm(base, {pose: run(pose, delta=6) for pose in ("p1", "p2")})


def nominal_checks(
    model: RobotModel, effects: frozenset[Effect], note: Say = _nothing
) -> Iterator[Check]:
    """Errors without learning by position and velocity: (f)."""
    at_10, at_50, at_80 = (
        {
            pose: learned(model, effects, pose, speed=speed, iterations=0, note=note)
            for pose in POSES
        }
        for speed in (0.010, 0.050, 0.080)
    )
    yield from bands.nominal_by_position(at_50)
    yield from bands.growth(at_10, at_80)


def model_checks(
    model: RobotModel, effects: frozenset[Effect], note: Say = _nothing
) -> Iterator[Check]:
    """The response to corrections of the motors that move most, at p1: (e)."""
    runs = {v: learned(model, effects, "p1", speed=1e-3 * v, note=note) for v in bands.SPEEDS}
    yield from bands.fitted_model(runs)


Checks = Callable[[RobotModel, frozenset[Effect], Say], Iterator[Check]]
CHECKS: tuple[Checks, ...] = (learning_checks, nominal_checks, model_checks)
"""Those that exclude most candidates first."""
