"""A plant behind a controller: it runs a path with a correction and returns the motor angles."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from armside.arrays import Array
from armside.ilc.records import records

from .client import Connection
from .controller import VirtualController
from .gate import GateError, check_names, exceeded, let_through
from .limits import GuidanceLimits
from .messages import Answer, Phase, State

PERIOD = 0.004
"""[s], of EGM and of RSI."""
AT_START = np.deg2rad(0.01)
"""Distance of the commanded angles from the start of the path above which the robot is moved."""
APPROACH = 0.25
"""Share of the speed limit at which the robot is moved to the start of a path."""
SETTLING = 50
"""Samples of rest before a path that the robot was moved to."""
MOST_LOST = 0.1
"""Share of messages of one run that may be lost."""
LONGEST = 600.0
"""[s], of a program that is listened to."""
MOST_ASKED = 250
"""Messages that ask for the answer to one sample."""
MOST_WAITED = 100_000
"""Messages until the robot is at rest."""


class LostError(RuntimeError):
    """The controller ended the run, or too many of its messages were lost."""


@dataclass
class InProcess:
    """A link to a virtual controller in this process: no socket, no clock."""

    controller: VirtualController
    additive: bool = False

    def begin(self) -> None:
        """A run begins."""
        while self.controller.phase is not Phase.WAITING:
            self.controller.cycle(None)

    def receive(self) -> State:
        """The message of this cycle."""
        return self.controller.state()

    def answer(self, answer: Answer, to: State) -> None:
        """Answer it, and run the cycle."""
        self.controller.cycle(answer)


@dataclass
class StreamedPlant:
    """Plant of a learning loop: a controller that is told path and correction sample by sample.

    With absolute angles (EGM) the robot is moved to the start of the path first, where it stands
    elsewhere. With corrections (RSI) the path is the controller's program.

    Raises GateError for a path, or a correction in `run`, that the gate does not let through:
    nothing has been sent then.
    """

    link: Connection
    path: Array
    """r, shape (N, n) [rad], one sample each period."""
    limits: GuidanceLimits | None = None
    """Of the robot, checked before anything is sent; None: the correction alone is checked."""
    beyond: tuple[str, ...] = ()
    """Names of what the gate (`gate`) lets through."""
    period: float = PERIOD
    """[s], of the controller."""
    lost: int = field(default=0, init=False)
    """Messages of the controller that did not come, in all runs; their angles are interpolated."""
    refused: int = field(default=0, init=False)
    """Answers that the controller says it missed or refused, in all runs."""

    def __post_init__(self) -> None:
        self.path = np.array(self.path, dtype=np.float64)
        if self.path.ndim != 2 or len(self.path) < 2:
            raise ValueError(f"path must have shape (N, n), got {self.path.shape}")
        check_names(self.beyond)
        self.check(np.zeros_like(self.path))

    def check(self, correction: Array, path: Array | None = None) -> None:
        """Raise ValueError for a correction (N, n) [rad] that may not be sent on a path (N, n)."""
        path = self.path if path is None else path
        if correction.shape != path.shape:
            raise ValueError(f"correction must have shape {path.shape}, got {correction.shape}")
        if not np.isfinite(path + correction).all():
            raise ValueError("path and correction must be finite")
        found = exceeded(correction, self.period, path=path, limits=self.limits)
        try:
            let_through(found, self.beyond)
        except GateError as error:
            raise GateError(f"{error}; nothing was sent") from None

    @records("correction")
    def run(self, correction: Array, /) -> Array:
        """Measured motor angles (N, n) [rad] of one run with u = correction (N, n) [rad].

        Raises TimeoutError when no controller speaks, LostError when it ends the run.
        """
        self.check(correction)
        values = correction if self.link.additive else self.path + correction
        self.link.begin()
        first = last = self._waiting()
        if not self.link.additive:
            first = self._move_to(values[0], first)
        missed, measured = first.missed, np.full(values.shape, np.nan)
        for sample, last in self._answering(values, first, len(values) - 1):
            if sample >= len(values) or (last.phase is Phase.WAITING and sample > 0):
                break
            measured[sample] = np.deg2rad(last.joints)
            missed = max(missed, last.missed)
        self._answer(None, last)
        self.refused += missed
        return self._filled(measured)

    def _answer(self, values: Array | None, to: State) -> None:
        self.link.answer(Answer(values=values, additive=self.link.additive), to)

    def _answering(self, values: Array, state: State, last: int) -> Iterator[tuple[int, State]]:
        """Samples by the controller's clock and their messages, answered by values (N, n) [rad],
        until sample `last`."""
        sent, start, sample, asked = np.rad2deg(values), state.time, 0, 0
        yield sample, state
        while sample < last:
            self._answer(sent[sample], state)
            before = sample
            state, sample = self._next(state, start, sample)
            asked = asked + 1 if sample == before else 0
            if asked >= MOST_ASKED:
                reason = "it refuses the answer, or does not hear it"
                raise LostError(f"the controller asked for sample {sample} {asked} times: {reason}")
            yield sample, state

    def _next(self, state: State, start: int, sample: int) -> tuple[State, int]:
        """The next message and its sample. One that repeats itself asks for the answer again."""
        while True:
            following = self.link.receive()
            ahead = round((following.time - start) / (1e3 * self.period))
            again = ahead == sample and (
                following.number != state.number or following.phase is Phase.WAITING
            )
            if ahead > sample or again:
                return following, ahead

    def _filled(self, measured: Array) -> Array:
        there, at = np.isfinite(measured[:, 0]), np.arange(len(measured))
        self.lost += (lost := int((~there).sum()))
        if 1.0 - float(there.mean()) > MOST_LOST:
            raise LostError(f"{lost} of {len(there)} messages of the controller were lost")
        return np.column_stack([np.interp(at, at[there], own) for own in measured[there].T])

    def _waiting(self) -> State:
        """A message of the robot at rest at its start."""
        for _ in range(MOST_WAITED):
            state = self.link.receive()
            if state.phase is Phase.WAITING:
                if len(state.joints) != self.path.shape[1]:
                    axes = f"{len(state.joints)} axes, the path has {self.path.shape[1]}"
                    raise ValueError(f"the controller's robot has {axes}")
                return state
            self._answer(None, state)
        raise LostError("the controller does not come to rest")

    def _move_to(self, target: Array, state: State) -> State:
        """Guide the robot to the start of the path, along a straight line in joint angles."""
        start = np.deg2rad(state.planned)
        away = target - start
        if np.abs(away).max() <= AT_START:
            return state
        speed = APPROACH * (self.limits.speed if self.limits else 1.0)
        seconds = 0.5 * np.pi * float((np.abs(away) / speed).max())
        count = max(2, int(np.ceil(seconds / self.period)))
        share = 0.5 - 0.5 * np.cos(np.pi * np.arange(1, count + 1) / count)
        way = np.vstack((start + share[:, None] * away, np.tile(target, (SETTLING, 1))))
        self.check(np.zeros_like(way), way)
        *_, (_, last) = self._answering(way, state, len(way))
        return last


def program_of(link: Connection) -> Array:
    """The controller's program (N, n) [rad], listened to in one run without correction.

    Raises TimeoutError when no controller speaks, LostError when it does not move or end.
    """
    link.begin()
    state = link.receive()
    while state.phase is not Phase.WAITING:
        state = link.receive()
    still, found, start = np.zeros_like(state.joints), [np.deg2rad(state.planned)], state.time
    while len(found) < LONGEST / PERIOD:
        values = still if link.additive else state.planned
        link.answer(Answer(values=values, additive=link.additive), state)
        state = link.receive()
        ahead = round((state.time - start) / (1e3 * PERIOD))
        if state.phase is Phase.WAITING and len(found) > 1 and ahead == len(found) - 1:
            return np.array(found)
        if ahead > len(found):
            raise LostError("a message of the program was lost: listen again")
        if ahead == len(found):
            found.append(np.deg2rad(state.planned))
    raise LostError(f"the program does not end within {LONGEST:g} s")
