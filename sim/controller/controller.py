"""A virtual controller: the robot behind a protocol, one cycle of 4 ms at a time.

It repeats one program, from its start each time. The robot waits at the start until a client
answers, and follows the client then: absolute angles, or corrections that are added to the program.
An answer that does not come holds the last correction. Silence, or the wish of the client, ends the
run: the robot comes to rest, and the program starts anew.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import mujoco
import numpy as np

from armside import kinematics
from armside.arrays import Array

from ..cell import Cell
from ..robot.model import RobotModel
from ..robot.recording import Recording
from ..robot.run import LoadedReference
from ..robot.statics import Statics
from ..robot.virtual_robot import LOG_PERIOD, VirtualRobot
from .limits import GuidanceLimits
from .messages import Answer, Phase, State
from .streamed_run import StreamedRun

SILENCE = 25
"""Answers missing in a row after which a run ends."""
STOPPING_CYCLES = 50
"""Cycles in which a guided motion slows down to rest: 0.2 s."""
AT_REST = 1e-3
"""[rad/s], below which the robot stands."""
MOST_REFUSALS = 100
"""Reasons that are kept."""
REST_CYCLES = 500
"""Longest wait for rest."""
STANDS = 1e-5
"""Step of the tool in a cycle [m], 2.5 mm/s, below which it keeps its direction. ESTIMATE"""
ALONG = 1e-3
"""Sine of the angle between tool and path, below which they are one direction. ESTIMATE"""
NEWTON = 3
"""Steps from an offset to motor angles: a millimetre is exact to rounding after two."""


@dataclass(frozen=True, kw_only=True)
class Hold:
    """A program that stands at motor angles (n,) [rad] until a client guides the robot."""

    start: Array
    seconds: float = 60.0
    """Longest run."""


@dataclass
class VirtualController:
    """The robot of a cell behind a controller's protocol."""

    loaded: LoadedReference
    cell: Cell
    rng: np.random.Generator | None = None
    """Noise of drives and encoders; None: there is none."""
    guiding: Statics | None = None
    """Nominal robot, for a program that stands still (`StreamedRun`)."""
    limits: GuidanceLimits | None = None
    on_end: Callable[[Recording, int], None] = lambda recording, missed: None
    """Called with the record of each run and the number of answers that it missed."""
    silence: int = SILENCE
    missed: int = field(default=0, init=False)
    """Answers missing in this run."""
    refusals: list[str] = field(default_factory=list[str], init=False)
    """Reasons why answers were refused, of all runs, the first of each."""
    runs: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        model, self._number, self._cycles = self.loaded.model, 0, 0
        self._limits = self.limits or GuidanceLimits.of(model, self.cell)
        robot = kinematics.compile(self.cell.robot)
        self._pose, self._jacobian = robot.pose, robot.jacobian
        # Code that a cycle is the first to call is compiled here: it would take seconds there.
        StreamedRun(self.loaded, None, self.guiding).advance(np.zeros(model.n_axes))
        self._start()

    @classmethod
    def standing(
        cls, model: RobotModel, cell: Cell, program: Hold, rng: np.random.Generator | None = None
    ) -> "VirtualController":
        """Controller of a robot that stands still until it is guided.

        Raises ValueError for a start outside the ranges or a run of less than two samples.
        """
        count = round(program.seconds / LOG_PERIOD) + 1
        if count < 2:
            raise ValueError(f"seconds must be at least {LOG_PERIOD:g}, got {program.seconds:g}")
        if program.start.shape != (model.n_axes,):
            raise ValueError(f"start must have {model.n_axes} angles, got {program.start.shape}")
        wrong = GuidanceLimits.of(model, cell).refusal(program.start, program.start)
        if wrong is not None:
            raise ValueError(f"start: {wrong}")
        nominal, reference = Statics(model), np.tile(program.start, (count, 1))
        loaded = VirtualRobot(model, nominal=nominal).load(reference)
        return cls(loaded, cell, rng, guiding=nominal)

    @property
    def abandoned(self) -> bool:
        """The client of this run fell silent."""
        return self._silent >= self.silence

    def state(self) -> State:
        """The message of this cycle."""
        measured, planned = self._run.motor_angle, self._run.planned
        position, quaternion = self._place(measured)
        return State(
            number=self._number,
            time=round(1e3 * LOG_PERIOD) * self._cycles,
            phase=self.phase,
            joints=np.rad2deg(measured),
            planned=np.rad2deg(planned),
            position=position,
            quaternion=quaternion,
            missed=self.missed,
            resting=self._resting(),
            programmed=self._place(planned),
        )

    def _place(self, phi: Array) -> tuple[Array, Array]:
        frame, quaternion = self._pose(phi), np.empty(4)
        mujoco.mju_mat2Quat(quaternion, frame[:3, :3].ravel())
        return 1e3 * frame[:3, 3], quaternion

    def ahead(self) -> None:
        """Run the physics of this cycle while its answer is awaited."""
        self._run.ahead()

    def cycle(self, answer: Answer | None) -> None:
        """Take the answer to the message of this cycle, or none, and run one period."""
        self._number += 1
        correction = None
        if answer is not None and self.phase is not Phase.STOPPING:
            if answer.values is None:
                self._leave()
                return
            values = answer.values
            asked = self._across(1e-3 * values) if answer.of_path else np.deg2rad(values)
            correction = self._allowed(asked, answer.additive)
        if self.phase is Phase.WAITING:
            if correction is None:
                return
            self.phase = Phase.GUIDED
        if self.phase is Phase.GUIDED:
            self._silent = 0 if correction is not None else self._silent + 1
            self.missed += correction is None
            if self.abandoned:
                self._leave()
        if self.phase is Phase.STOPPING:
            correction = self._slowing()
        if correction is not None:
            self._step = correction - self._correction
            self._correction = correction
        if self._run.finished or self._stopped():
            self.runs += 1
            self.on_end(self._run.recording(), self.missed)
            self._start()
            return
        self._run.advance(self._correction)
        self._cycles += 1

    def _allowed(self, values: Array, additive: bool) -> Array | None:
        """The correction (n,) [rad] of an answer within the limits, or None."""
        run, limits, correction = self._run, self._limits, values
        if values.shape != self._correction.shape:
            wrong = limits.refusal(values, self._correction)
        else:
            correction = values if additive else values - run.planned
            target = run.planned + values if additive else values
            before = run.loaded.reference[max(run.sample - 1, 0)] + self._correction
            wrong = limits.refusal(target, before)
            if wrong is None and self.guiding is None:
                wrong = limits.correction_refusal(correction)
        if wrong is None:
            return correction
        if wrong not in self.refusals and len(self.refusals) < MOST_REFUSALS:
            self.refusals.append(wrong)
        return None

    @cached_property
    def _tangents(self) -> Array:
        """(N, 3), of the program's path; at rest that of the motion before, or of the first."""
        position = np.ascontiguousarray(self._pose(self.loaded.reference)[:, :3, 3])
        step = np.gradient(position, axis=0)
        size = np.linalg.norm(step, axis=1)
        moving = np.flatnonzero(size > STANDS)
        if not len(moving):
            return np.full_like(step, np.nan)
        last = np.clip(np.searchsorted(moving, np.arange(len(step)), side="right") - 1, 0, None)
        return (step / np.maximum(size, STANDS)[:, np.newaxis])[moving[last]]

    def _across(self, offset: Array) -> Array:
        """Correction (n,) [rad] for an offset (3,) [m] in the frame of the path; NaN where there is
        none, or where the tool's axis lies along it."""
        planned, x = self._run.planned, self._tangents[self._run.sample]
        frame = self._pose(planned)
        y = np.cross(frame[:3, 2], x)
        if not (np.linalg.norm(y) > ALONG and np.isfinite(offset).all()):
            return np.full_like(planned, np.nan)
        y /= np.linalg.norm(y)
        target, phi = frame[:3, 3] + offset[1] * y + offset[2] * np.cross(x, y), planned
        for _ in range(NEWTON):
            now = self._pose(phi)
            turn = 0.5 * np.cross(now[:3, :3], frame[:3, :3], axis=0).sum(axis=1)  # of small ones
            left = np.concatenate([target - now[:3, 3], turn])
            rows = slice(None) if len(phi) >= 6 else slice(3)  # fewer axes turn as they must
            phi = phi + np.linalg.lstsq(self._jacobian(phi)[rows], left[rows], rcond=1e-6)[0]
        return phi - planned

    def _leave(self) -> None:
        if self.phase is Phase.GUIDED:
            self.phase, self._slow, self._last_step = Phase.STOPPING, 0, self._step

    def _slowing(self) -> Array:
        """The correction while the guided motion slows down to rest."""
        self._slow += 1
        step = max(0.0, 1.0 - self._slow / STOPPING_CYCLES) * self._last_step
        bounds, planned = self._limits, self._run.planned
        return np.clip(planned + self._correction + step, bounds.lower, bounds.upper) - planned

    def _stopped(self) -> bool:
        """A robot that stood still before it was guided is at rest again."""
        if self.phase is not Phase.STOPPING or self.guiding is None:
            return False
        waited = self._slow - STOPPING_CYCLES
        return waited > 0 and (self._resting() or waited > REST_CYCLES)

    def _resting(self) -> bool:
        return bool(np.abs(self._run.speed).max() < AT_REST)

    def _start(self) -> None:
        self._run = StreamedRun(self.loaded, self.rng, self.guiding)
        self._correction = self._step = np.zeros(self.loaded.model.n_axes)
        self._silent = self.missed = 0
        self.phase = Phase.WAITING
