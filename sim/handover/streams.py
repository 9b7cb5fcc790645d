"""A correction as the messages of a controller's protocol, one for each of its cycles.

EGM: EgmSensor messages with absolute joints [deg], each after its length as a protobuf varint,
which protobuf's own readers of delimited messages take. RSI: one `Sen` element a line, with the
axis corrections AKorr [deg]. Time stamp and IPOC count from zero: a sender replaces them by those
of the message it answers.
"""

import numpy as np

from armside.arrays import Array

from ..controller.messages import Answer, Phase, State, degrees
from ..controller.plant import PERIOD
from ..controller.rsi import RsiWire


def rsi_lines(correction: Array) -> bytes:
    """Corrections (M, n) [rad], a sample each cycle."""
    wire = RsiWire()
    lines = [
        wire.encode_answer(Answer(values=values, additive=True), _asked(i, values))
        for i, values in enumerate(degrees(correction))
    ]
    return b"".join(line + b"\n" for line in lines)


def egm_messages(joints: Array) -> bytes:
    """Absolute angles (M, n) [rad], a sample each cycle. Raises ImportError without protobuf."""
    from ..controller.egm import EgmWire

    wire = EgmWire()
    found = [
        wire.encode_answer(Answer(values=values, additive=False), _asked(i, values))
        for i, values in enumerate(degrees(joints))
    ]
    return b"".join(varint(len(message)) + message for message in found)


def varint(value: int) -> bytes:
    """A whole number >= 0, seven bits a byte, the lowest first."""
    low, rest = value & 0x7F, value >> 7
    return bytes([low | 0x80]) + varint(rest) if rest else bytes([low])


def _asked(i: int, values: Array) -> State:
    """The message of cycle i, of which answers repeat the time."""
    return State(
        number=i,
        time=round(1e3 * i * PERIOD),
        phase=Phase.GUIDED,
        joints=values,
        planned=values,
        position=np.zeros(3),
        quaternion=np.array([1.0, 0.0, 0.0, 0.0]),
        missed=0,
        resting=False,
    )
