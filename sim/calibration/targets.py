"""What the robot of thesis chapter 9 does, as numbers with bands: the targets of calibration.

Computed without torque noise, on the nominal robot with its gear effects. The bands are those of
an independent implementation of the same study; `docs/chapter9.md` reports them with noise.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth, recursion
from armside.ilc.laws import Heuristic
from armside.ilc.learning import Trial, learn
from armside.ilc.measures import norms as measures

from ..cell import LARGE_CELL
from ..cut.task import CircleTask
from ..cut.tool_motion import ToolMotion
from ..evaluation.tool_error import ToolError, tool_error
from ..laser.plant import plan
from ..robot.effects import Effect, with_effects
from ..robot.model import RobotModel
from ..robot.recording import Recording
from ..robot.run import LoadedReference
from ..robot.statics import Statics
from ..robot.virtual_robot import LOG_PERIOD, VirtualRobot

POSES = ("p1", "p2", "p3")
_TRACKER_STRIDE = 2  # physics steps per tracker sample


@dataclass(frozen=True)
class Finding:
    """One number and the band it should lie in."""

    name: str
    value: float
    low: float = -np.inf
    high: float = np.inf
    margin: float = 0.05
    """How far inside a calibration should bring it, relative to the end of the band."""

    @property
    def holds(self) -> bool:
        """Inside the band, ends included."""
        return self.low <= self.value <= self.high

    @property
    def outside(self) -> float:
        """How far outside its band less the margin, in parts of the band's end; 0 inside."""
        short = 0.0
        if np.isfinite(self.low):
            short = max(short, self.low + self.margin * abs(self.low) - self.value)
        if np.isfinite(self.high):
            short = max(short, self.value - self.high + self.margin * abs(self.high))
        ends = [abs(end) for end in (self.low, self.high) if np.isfinite(end)]
        return short / max([*ends, 0.05])


@dataclass(frozen=True, kw_only=True)
class Learned:
    """A learning experiment in numbers. First axis: iterations."""

    motor_inf: Array
    """(K, 6) [rad of the motor shaft]."""
    motor_two: Array
    """(K, 6)."""
    rms: Array
    """(K,) [m], (9.6) of the true tool."""
    maxdev: Array
    """(K,) [m], (9.7)."""
    radii: Array
    """(M,) [m], the last circle around its centre, every millisecond."""
    corrections: list[Array]
    outputs: list[Array]

    @property
    def ripple(self) -> float:
        """rms of the last circle's radius between 5 and 14 Hz [m]."""
        spectrum = np.fft.rfft(self.radii - self.radii.mean())
        frequency = np.fft.rfftfreq(len(self.radii), 1e-3)
        spectrum[(frequency < 5.0) | (frequency > 14.0)] = 0.0
        return float(np.sqrt(np.mean(np.fft.irfft(spectrum, len(self.radii)) ** 2)))


@dataclass(frozen=True)
class _Plant:
    loaded: LoadedReference

    def run(self, correction: Array, /) -> Recording:
        return self.loaded.run(correction)


def learned(
    model: RobotModel,
    effects: frozenset[Effect],
    pose: str,
    *,
    speed: float = 0.040,
    cutoff: float = 10.0,
    delta: int = 3,
    iterations: int = 5,
) -> Learned:
    """Run one experiment of the nominal robot, without noise."""
    task = CircleTask(pose=LARGE_CELL.poses[pose], speed=speed)
    motion, reference = plan(LARGE_CELL, Statics(model), task.path, task.pose.quaternion, speed)
    loaded = VirtualRobot(with_effects(model, effects, phi=reference[0])).load(reference)
    law = Heuristic(Q=ZeroPhaseButterworth(cutoff, LOG_PERIOD), gamma=0.9, delta=delta)
    trials = list(
        learn(_Plant(loaded), law, reference, iterations, output_of=lambda run: run.motor_angle)
    )
    sides = [_side(motion, trial) for trial in trials]
    errors = [trial.error * model.drives.gear for trial in trials]
    return Learned(
        motor_inf=np.array([measures.inf_norm(e) for e in errors]),
        motor_two=np.array([measures.two_norm(e) for e in errors]),
        rms=np.array([side.rms for side in sides]),
        maxdev=np.array([side.maxdev for side in sides]),
        radii=np.hypot(*sides[-1].path.T),
        corrections=[trial.correction for trial in trials],
        outputs=[trial.output for trial in trials],
    )


def _side(motion: ToolMotion, trial: Trial[Recording]) -> ToolError:
    truth = trial.result.truth
    every = slice(None, None, _TRACKER_STRIDE)
    return tool_error(motion, truth.time[every], truth.tool_position[every])


def learning_findings(model: RobotModel, effects: frozenset[Effect]) -> Iterator[Finding]:
    """Motor side and arm side at 40 mm/s over poses, cutoff and shift: (a) to (d)."""
    base = {pose: learned(model, effects, pose) for pose in POSES}
    largest = max(run.motor_inf[0].max() for run in base.values())
    last = np.array([run.motor_inf[-1] for run in base.values()])
    own = last / np.array([run.motor_inf[0] for run in base.values()])
    yield Finding("worst motor after five updates, (9.5)", float((last / largest).max()), high=0.10)
    yield Finding("best motor after five updates, (9.5)", float((last / largest).min()), high=0.02)
    yield Finding(
        "motors at a tenth of their own k = 0", float((own <= 0.10).sum()), 14, margin=1 / 14
    )
    yield Finding("worst motor of its own k = 0", float(own.max()), high=0.30)

    ratio = {pose: float(run.rms[5] / run.rms[0]) for pose, run in base.items()}
    p1, p2 = base["p1"], base["p2"]
    yield Finding("p1: RMS k = 5 of k = 0", ratio["p1"], 0.20, 0.50)
    yield Finding("p1: maximum k = 5 of k = 0", float(p1.maxdev[5] / p1.maxdev[0]), high=0.60)
    yield Finding("p2: RMS k = 5 of k = 1", float(p2.rms[5] / p2.rms[1]), low=0.95)
    yield Finding("p2: largest RMS after k = 1 of k = 1", float(p2.rms[1:].max() / p2.rms[1]), 1.03)
    yield Finding("p3: RMS k = 5 of k = 0", ratio["p3"], 0.95, 1.6)
    yield Finding("ratio of p2 less ratio of p1", ratio["p2"] - ratio["p1"], low=0.0)
    yield Finding("ratio of p3 less ratio of p2", ratio["p3"] - ratio["p2"], low=0.0)

    fast = learned(model, effects, "p1", cutoff=15.0)
    motors = fast.motor_two[5] / p1.motor_two[5]
    yield Finding("15 Hz of 10 Hz: RMS at p1", float(fast.rms[5] / p1.rms[5]), low=1.05)
    yield Finding("15 Hz of 10 Hz: maximum at p1", float(fast.maxdev[5] / p1.maxdev[5]), low=1.10)
    yield Finding("15 Hz of 10 Hz: ripple 5-14 Hz at p1", fast.ripple / p1.ripple, low=1.2)
    yield Finding("15 Hz of 10 Hz: median motor", float(np.median(motors)), high=1.0)
    yield Finding("15 Hz of 10 Hz: motors below 0.7", float((motors < 0.7).sum()), 2, margin=0.0)
    for pose, high in (("p1", 0.97), ("p2", 0.95)):
        late = learned(model, effects, pose, delta=6)
        value = float(late.rms[5] / base[pose].rms[5])
        yield Finding(f"delta 6 of delta 3: RMS at {pose}", value, high=high)


def nominal_findings(model: RobotModel, effects: frozenset[Effect]) -> Iterator[Finding]:
    """Errors without learning by position and velocity: (f)."""

    def first(pose: str, speed: float) -> Array:
        return learned(model, effects, pose, speed=speed, iterations=0).motor_inf[0]

    at_50 = {pose: first(pose, 0.050) for pose in POSES}
    largest = max(errors.max() for errors in at_50.values())
    fourth = {pose: errors[3] / largest for pose, errors in at_50.items()}
    yield Finding("motor 3 at p3 of the largest", float(at_50["p3"][2] / largest), 1.0, margin=0.0)
    yield Finding("motor 4 at p1 of the largest", float(fourth["p1"]), low=0.50)
    yield Finding("motor 4 at p3 of the largest", float(fourth["p3"]), low=0.45)
    smaller = min(fourth["p1"], fourth["p3"])
    yield Finding("motor 4 at p2 of p1 and p3", float(fourth["p2"] / smaller), high=1.0)
    growth = [(first(pose, 0.080) / first(pose, 0.010)).min() for pose in POSES]
    yield Finding("smallest growth of an error, 10 to 80 mm/s", float(min(growth)), low=1.0)


@dataclass(frozen=True, kw_only=True)
class FirstOrder:
    """T_u(q) = b q^-delay / (1 - pole q^-1), by output error, as thesis (9.11)."""

    delay: int
    """[samples]."""
    pole: float
    gain: float
    """Static: b / (1 - pole)."""
    fit: float
    """1 - ||y - model|| / ||y||, all experiments together."""

    @property
    def total_delay(self) -> float:
        """[samples], the pole's part included."""
        return self.delay + self.pole / (1.0 - self.pole)


def identify_first_order(experiments: list[Learned], motors: tuple[int, ...]) -> FirstOrder:
    """Output error over delay and pole; the response to a correction is y_k - y_0."""
    u = [run.corrections[k][:, i] for run in experiments for i in motors for k in range(1, 6)]
    y = [
        run.outputs[k][:, i] - run.outputs[0][:, i]
        for run in experiments
        for i in motors
        for k in range(1, 6)
    ]
    size = sum(float(s @ s) for s in y)
    best = None
    for delay in range(10):
        for pole in np.linspace(0.05, 0.95, 46):
            x = [_delayed_lag(signal, delay, pole) for signal in u]
            gain = sum(a @ b for a, b in zip(x, y, strict=True)) / sum(a @ a for a in x)
            left = sum(float(((b - gain * a) ** 2).sum()) for a, b in zip(x, y, strict=True))
            if best is None or left < best[0]:
                best = (left, delay, float(pole), float(gain))
    assert best is not None
    left, delay, pole, gain = best
    return FirstOrder(
        delay=delay, pole=pole, gain=gain / (1.0 - pole), fit=1.0 - np.sqrt(left / size)
    )


def _delayed_lag(signal: Array, delay: int, pole: float) -> Array:
    delayed = np.concatenate((np.zeros(delay), signal))[: len(signal)]
    return recursion(np.array([1.0]), np.array([1.0, -pole]), delayed[:, None])[:, 0]


def model_findings(model: RobotModel, effects: frozenset[Effect]) -> Iterator[Finding]:
    """The response to corrections of the motors that move most, at p1: (e)."""
    runs = [learned(model, effects, "p1", speed=speed) for speed in (0.030, 0.040, 0.060)]
    found = identify_first_order(runs, motors=(3, 5))
    yield Finding("T_u: fit", found.fit, low=0.90)
    yield Finding("T_u: static gain", found.gain, 0.97, 1.03, margin=0.0)
    yield Finding("T_u: delay and lag [samples]", found.total_delay, 5.0, 7.0)
    yield Finding("T_u: pole", found.pole, 0.20, 0.65)
