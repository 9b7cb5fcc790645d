"""Messages of ABB's Externally Guided Motion, as protobuf: EgmRobot out, EgmSensor in.

The definition is ABB's, `egm.proto` beside this file with its licence; `egm.desc` is its
descriptor, made by `protoc --descriptor_set_out=egm.desc egm.proto`.
"""

from importlib.resources import files
from typing import Any

import numpy as np

from armside.arrays import Array

from .messages import Answer, Phase, State, WireError

AXES = 6
"""Joints of a robot message; those beyond are external joints. EgmJoints and EgmExternalJoints."""
_STATES = {Phase.WAITING: 2, Phase.GUIDED: 3, Phase.STOPPING: 3}
"""EgmMCIState.MCIStateType: MCI_STOPPED and MCI_RUNNING."""
REORDERED = 1000
"""Sequence numbers by which a message may be late; one further back is of a client that begins."""


class EgmWire:
    """Both directions of EGM's joint guidance. Raises ImportError without the package protobuf."""

    additive = False

    def __init__(self) -> None:
        self._robot, self._sensor, self._path, self._error = _messages()
        self._sequence = 0
        self.forget()

    def encode_state(self, state: State) -> bytes:
        """EgmRobot. Angles in degrees, positions in millimetres."""
        message = self._robot()
        message.header.seqno = state.number % 2**32
        message.header.tm = state.time % 2**32
        message.header.mtype = 2  # MSGTYPE_DATA
        for part, values in ((message.feedBack, state.joints), (message.planned, state.planned)):
            part.joints.joints.extend(values[:AXES].tolist())
            part.externalJoints.joints.extend(values[AXES:].tolist())
            part.time.sec, part.time.usec = divmod(1000 * state.time, 1_000_000)
        place = message.feedBack.cartesian
        place.pos.x, place.pos.y, place.pos.z = state.position.tolist()
        turn = place.orient
        turn.u0, turn.u1, turn.u2, turn.u3 = state.quaternion.tolist()
        message.motorState.state = 1  # MOTORS_ON
        message.mciState.state = _STATES[state.phase]
        message.mciConvergenceMet = state.resting
        message.rapidExecState.state = 2  # RAPID_RUNNING
        return message.SerializeToString()

    def decode_state(self, datagram: bytes) -> State:
        """State in an EgmRobot. Raises WireError for anything else."""
        message = self._parsed(self._robot, datagram)
        if not message.header.HasField("seqno") or not message.HasField("feedBack"):
            raise WireError("an EgmRobot has a sequence number and feedback")
        joints, planned = _joints(message.feedBack), _joints(message.planned)
        if not len(joints) or len(planned) not in (0, len(joints)):
            raise WireError(f"needs joints, got {len(joints)} measured and {len(planned)} planned")
        place, turn = message.feedBack.cartesian.pos, message.feedBack.cartesian.orient
        guided = message.mciState.state == _STATES[Phase.GUIDED]
        return State(
            number=message.header.seqno,
            time=message.header.tm,
            phase=Phase.GUIDED if guided else Phase.WAITING,
            joints=joints,
            planned=planned if len(planned) else joints,
            position=np.array([place.x, place.y, place.z]),
            quaternion=np.array([turn.u0, turn.u1, turn.u2, turn.u3]),
            missed=0,
            resting=message.mciConvergenceMet,
        )

    def encode_answer(self, answer: Answer, time: int) -> bytes:
        """EgmSensor with absolute joints; without joints it ends the guidance."""
        message = self._header(self._sensor, time, 3)  # MSGTYPE_CORRECTION
        if answer.values is not None:
            message.planned.joints.joints.extend(answer.values[:AXES].tolist())
            message.planned.externalJoints.joints.extend(answer.values[AXES:].tolist())
        return message.SerializeToString()

    def decode_answer(self, datagram: bytes, to: State) -> Answer | None:
        """Answer in an EgmSensor; None for one that came before. Raises WireError otherwise.

        A client that repeats the time stamp of a message in its own header, which EGM does not ask
        for, is held to it: its answer to an earlier message is late.
        """
        message = self._parsed(self._sensor, datagram)
        if not self._is_new(message, to):
            return None
        values = _joints(message.planned)
        if not len(values) and message.planned.HasField("cartesian"):
            raise WireError("guidance by poses is not served: send joints")
        return Answer(values=values if len(values) else None, additive=False)

    def _is_new(self, message: Any, to: State) -> bool:
        """The answer is one to this message, and was not there before."""
        if not message.HasField("header"):
            raise WireError(f"an {message.DESCRIPTOR.name} has a header")
        number = message.header.seqno
        if 0 <= self._heard - number < REORDERED:
            return False
        self._heard = number
        if message.header.HasField("tm"):
            echo = message.header.tm == to.time % 2**32
            self._echoes = self._echoes or echo
            return echo or not self._echoes
        return True

    def _header(self, kind: Any, time: int, mtype: int) -> Any:
        message = kind()
        self._sequence += 1
        message.header.seqno = self._sequence % 2**32
        message.header.tm = time % 2**32
        message.header.mtype = mtype
        return message

    def forget(self) -> None:
        """Another client may begin to count."""
        self._heard, self._echoes = -1, False

    def _parsed(self, kind: Any, datagram: bytes) -> Any:
        message = kind()
        try:
            message.ParseFromString(datagram)
        except self._error as error:
            raise WireError(f"not a message of EGM: {error}") from error
        return message


class EgmPathWire(EgmWire):
    """EGM's path correction: offsets from the path of the program, as EGMMoveL takes them.

    Frame and axes are an ESTIMATE, not verified against ABB's application manual: `Answer.of_path`.
    An offset is that from the programmed path, and none adds to the last.
    """

    def encode_answer(self, answer: Answer, time: int) -> bytes:
        """EgmSensorPathCorr; without values it ends the correction."""
        message = self._header(self._path, time, 4)  # MSGTYPE_PATH_CORRECTION
        if answer.values is not None:
            pos = message.pathCorr.pos
            pos.x, pos.y, pos.z = answer.values.tolist()
            message.pathCorr.age = 0
        return message.SerializeToString()

    def decode_answer(self, datagram: bytes, to: State) -> Answer | None:
        """Answer in an EgmSensorPathCorr; as of `EgmWire`."""
        message = self._parsed(self._path, datagram)
        if not self._is_new(message, to):
            return None
        pos, values = message.pathCorr.pos, None
        if message.HasField("pathCorr"):
            values = np.array([pos.x, pos.y, pos.z])
        return Answer(values=values, additive=True, of_path=True)


def _joints(part: Any) -> Array:
    return np.array([*part.joints.joints, *part.externalJoints.joints], dtype=np.float64)


def _messages() -> tuple[Any, ...]:
    """EgmRobot, EgmSensor, EgmSensorPathCorr and the error of a parser, from a descriptor pool of
    their own."""
    from google.protobuf import descriptor_pb2, descriptor_pool, message, message_factory

    described = descriptor_pb2.FileDescriptorSet()
    described.ParseFromString(files("armside.sim.controller").joinpath("egm.desc").read_bytes())
    pool = descriptor_pool.DescriptorPool()
    for file in described.file:
        pool.Add(file)
    names = ("EgmRobot", "EgmSensor", "EgmSensorPathCorr")
    found = (pool.FindMessageTypeByName(f"abb.egm.{name}") for name in names)
    return *map(message_factory.GetMessageClass, found), message.DecodeError
