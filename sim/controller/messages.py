"""What a controller and its client tell each other each cycle, whatever the protocol.

Angles are in degrees, as on the wire: a conversion on one side only would change the last bits.
"""

from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from armside.arrays import Array


class Phase(Enum):
    """State of the guidance."""

    WAITING = "waiting"
    """At rest at the start, until a client answers."""
    GUIDED = "guided"
    STOPPING = "stopping"
    """The client is silent: the robot comes to rest."""


@dataclass(frozen=True, kw_only=True)
class State:
    """Message of the controller in one cycle."""

    number: int
    """Of the message, from 0."""
    time: int
    """[ms], clock of the controller. It stands while the robot waits, so that the first sample of a
    run is that of the message that is answered."""
    phase: Phase
    joints: Array
    """(n,) [deg], measured motor angles, arm side."""
    planned: Array
    """(n,) [deg], motor angles of the program, which corrections are added to."""
    position: Array
    """(3,) [mm], TCP0 in base axes by the nominal kinematics at the measured angles."""
    quaternion: Array
    """(4,), w first."""
    missed: int
    """Answers of this run that did not come, came late or were refused."""
    resting: bool
    """The robot stands."""
    programmed: tuple[Array, Array] | None = None
    """Position and quaternion likewise at the planned angles; None where they are not known."""


@dataclass(frozen=True, kw_only=True)
class Answer:
    """Answer of the client to one message."""

    values: Array | None
    """(n,) [deg]; None: the client ends its guidance."""
    additive: bool
    """The values are added to the program; otherwise they are absolute angles."""
    of_path: bool = False
    """The values are (3,) [mm], an offset from the program's path in its own frame: x along it, y =
    z of the tool cross x, and z = x cross y (ESTIMATE, not verified
    against ABB's manual). Along the path nothing is corrected."""


class WireError(ValueError):
    """A datagram that is not a message of the protocol."""


class Wire(Protocol):
    """Messages of a protocol, both directions; `decode_*` raise WireError."""

    additive: bool
    """As of its answers."""

    def encode_state(self, state: State) -> bytes: ...

    def decode_state(self, datagram: bytes) -> State: ...

    def encode_answer(self, answer: Answer, time: int) -> bytes:
        """Answer to the message of a time [ms]."""
        ...

    def decode_answer(self, datagram: bytes, to: State) -> Answer | None:
        """Answer to the message `to`; None for a late or doubled one."""

    def forget(self) -> None:
        """A run begins."""
