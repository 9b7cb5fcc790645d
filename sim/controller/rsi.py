"""Messages of KUKA's Robot Sensor Interface, XML of one element each: Rob out, Sen in.

The tags are those of KUKA's own example of an RSI configuration: AIPos and ASPos are measured
and programmed axes, AKorr is the axis correction, IPOC a time stamp that the answer repeats.
Digout o1 is on from the first answer until the robot waits at its start again.
"""

import math
import re
import xml.etree.ElementTree as ET

import mujoco
import numpy as np

from armside.arrays import Array

from .messages import Answer, Phase, State, WireError

CLIENT = "ImFree"
"""Name of the sensor system, SENTYPE in KUKA's example."""
_TAGS, _PLACE = ("Digout", "RIst", "Delay"), ("X", "Y", "Z", "A", "B", "C")
_NUMBER = re.compile(r"\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?\s*\Z", re.ASCII)


class RsiWire:
    """Both directions of RSI with axis corrections, absolute or relative (they add up), as the
    object AXISCORR of a controller is configured."""

    additive = True

    def __init__(self, relative: bool = False) -> None:
        self._relative = relative
        self._sum: Array | None = None

    def encode_state(self, state: State) -> bytes:
        """Rob: pose (RIst; programmed RSol), axes (AIPos, ASPos), late answers (Delay), guidance,
        IPOC."""
        root = ET.Element("Rob", Type="KUKA")
        places = {"RIst": (state.position, state.quaternion), "RSol": state.programmed}
        for tag, known in places.items():
            if known is not None:
                place = (*known[0].tolist(), *_abc(known[1]))
                ET.SubElement(root, tag, dict(zip(_PLACE, map(repr, place), strict=True)))
        for tag, values in (("AIPos", state.joints), ("ASPos", state.planned)):
            ET.SubElement(root, tag, _axes(values))
        ET.SubElement(root, "Delay", D=str(state.missed))
        resting = str(int(state.resting))
        guided = str(int(state.phase is not Phase.WAITING))
        ET.SubElement(root, "Digout", o1=guided, o2=resting, o3="0")
        ET.SubElement(root, "IPOC").text = str(state.time)
        return ET.tostring(root, encoding="utf-8")

    def decode_state(self, datagram: bytes) -> State:
        """State in a Rob. Raises WireError for anything else."""
        root = _root(datagram, "Rob")
        joints, planned = _values(root, "AIPos"), _values(root, "ASPos")
        if joints is None:
            raise WireError("a Rob has measured axes, AIPos")
        digital, place, delay = ({} if (e := root.find(tag)) is None else e.attrib for tag in _TAGS)
        on = [digital.get(name, "0").strip() in ("1", "1.0", "TRUE") for name in ("o1", "o2")]
        ipoc, where = _stamp(root), [_number(place.get(axis, "0")) for axis in _PLACE]
        return State(
            number=ipoc // 4,
            time=ipoc,
            phase=Phase.GUIDED if on[0] else Phase.WAITING,
            joints=joints,
            planned=joints if planned is None else planned,
            position=np.array(where[:3]),
            quaternion=_quaternion(where[3:]),
            missed=int(_number(delay.get("D", "0"))),
            resting=on[1],
        )

    def encode_answer(self, answer: Answer, time: int) -> bytes:
        """Sen with the axis correction and the IPOC of the message it answers."""
        root, values = ET.Element("Sen", Type=CLIENT), answer.values
        if values is None:
            ET.SubElement(root, "EStr").text = "Error: the guidance is over"
        else:
            step = values if self._sum is None or not self._relative else values - self._sum
            self._sum = values
            ET.SubElement(root, "AKorr", _axes(step))
        ET.SubElement(root, "IPOC").text = str(time)
        return ET.tostring(root, encoding="utf-8")

    def decode_answer(self, datagram: bytes, to: State) -> Answer | None:
        """Answer in a Sen; None for the answer to another message. Raises WireError otherwise."""
        root = _root(datagram, "Sen")
        if _stamp(root) != to.time:
            return None
        message = root.find("EStr")
        if message is not None and (message.text or "").lstrip().startswith("Error"):
            return Answer(values=None, additive=True)
        values = _values(root, "AKorr")
        if values is None:
            raise WireError("a Sen has an axis correction, AKorr")
        values = values[: len(to.joints)] if not values[len(to.joints) :].any() else values
        if self._relative:
            if self._sum is not None and len(self._sum) == len(values):
                values = self._sum + values
            self._sum = values
        return Answer(values=values, additive=True)

    def forget(self) -> None:
        """A run begins: corrections that add up begin at zero."""
        self._sum = None


def _axes(values: Array) -> dict[str, str]:
    return {f"A{i + 1}": repr(value) for i, value in enumerate(values.tolist())}


def _root(datagram: bytes, tag: str) -> ET.Element:
    if b"<!" in datagram or b"<?" in datagram:
        raise WireError("declarations are not read")
    try:
        root = ET.fromstring(datagram.decode("utf-8"))
    except (ET.ParseError, UnicodeDecodeError, ValueError) as error:
        raise WireError(f"not XML: {error}") from error
    if root.tag != tag:
        raise WireError(f"needs the element {tag}, got {root.tag[:40]}")
    return root


def _values(root: ET.Element, tag: str) -> Array | None:
    element = root.find(tag)
    if element is None:
        return None
    names = [f"A{i + 1}" for i in range(len(element.attrib))]
    if not names or set(names) != set(element.attrib):
        raise WireError(f"{tag} needs the attributes A1, A2 and so on")
    return np.array([_number(element.attrib[name]) for name in names])


def _number(text: str) -> float:
    if len(text) > 60 or not _NUMBER.match(text):
        raise WireError(f"needs a number, got {text[:40]!r}")
    value = float(text)
    if not math.isfinite(value):
        raise WireError(f"needs a finite number, got {text[:40]!r}")
    return value


def _stamp(root: ET.Element) -> int:
    text = root.findtext("IPOC")
    if text is None or not re.fullmatch(r"\s*\d{1,18}\s*", text, re.ASCII):
        raise WireError("needs an IPOC, a whole number")
    return int(text)


def _abc(quaternion: Array) -> tuple[float, float, float]:
    """KUKA's A, B, C [deg]: turns about z, y and x; C is zero where the y turn is 90 degrees."""
    R = np.empty(9)
    mujoco.mju_quat2Mat(R, quaternion)
    across = math.hypot(R[0], R[3])
    B = math.atan2(-R[6], across)
    if across < SINGULAR:
        return math.degrees(math.atan2(-R[1], R[4])), math.degrees(B), 0.0
    A, C = math.atan2(R[3], R[0]), math.atan2(R[7], R[8])
    return math.degrees(A), math.degrees(B), math.degrees(C)


SINGULAR = 1e-9
"""Cosine of the y turn below which A and C are one angle."""


def _quaternion(abc: list[float]) -> Array:
    from scipy.spatial.transform import Rotation

    return Rotation.from_euler("ZYX", abc, degrees=True).as_quat(scalar_first=True)
