"""Messages of EGM and RSI: round trips to the last bit, and what is no message."""

import struct
import xml.etree.ElementTree as ET
from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from armside.sim.controller import Answer, Phase, State
from armside.sim.controller.egm import EgmPathWire, EgmWire
from armside.sim.controller.messages import WireError
from armside.sim.controller.rsi import RsiWire

from .robots import CELL, START, guided

RNG = np.random.default_rng(1)


ORIENTATIONS = np.array([[0.5, -0.5, 0.5, 0.5], [0.1, 0.7, -0.1, 0.7], [1.0, 0.0, 0.0, 0.0]])


def state(n=6, time=4000, phase=Phase.GUIDED, orientation=ORIENTATIONS[0]):
    return State(
        number=1001,
        time=time,
        phase=phase,
        joints=RNG.uniform(-180, 180, n),
        planned=RNG.uniform(-180, 180, n),
        position=RNG.uniform(-2000, 2000, 3),
        quaternion=orientation,
        missed=3,
        resting=False,
    )


@pytest.mark.parametrize("wire", [EgmWire, RsiWire])
@pytest.mark.parametrize("n", [2, 6, 7])
@pytest.mark.parametrize("orientation", ORIENTATIONS)
def test_a_state_arrives_bit_for_bit(wire, n, orientation):
    sent = state(n, orientation=orientation)
    got = wire().decode_state(wire().encode_state(sent))
    np.testing.assert_array_equal(got.joints, sent.joints)
    np.testing.assert_array_equal(got.planned, sent.planned)
    np.testing.assert_array_equal(got.position, sent.position)
    assert (got.time, got.phase, got.resting) == (sent.time, sent.phase, sent.resting)
    np.testing.assert_allclose(np.abs(got.quaternion @ sent.quaternion), 1.0, atol=1e-12)


@pytest.mark.parametrize(("wire", "additive"), [(EgmWire, False), (RsiWire, True)])
def test_an_answer_arrives_bit_for_bit(wire, additive):
    to, values = state(), RNG.uniform(-5, 5, 6)
    datagram = wire().encode_answer(Answer(values=values, additive=additive), to.time)
    got = wire().decode_answer(datagram, to)
    np.testing.assert_array_equal(got.values, values)
    end = wire().encode_answer(Answer(values=None, additive=additive), to.time)
    assert wire().decode_answer(end, to).values is None


@pytest.mark.parametrize(("wire", "additive"), [(EgmWire, False), (RsiWire, True)])
def test_an_answer_to_an_earlier_message_is_late(wire, additive):
    client, controller = wire(), wire()
    answers = [
        client.encode_answer(Answer(values=np.ones(6), additive=additive), time) for time in (4, 8)
    ]
    assert controller.decode_answer(answers[0], state(time=4)) is not None
    assert controller.decode_answer(answers[1], state(time=12)) is None


def test_a_doubled_answer_of_a_client_without_time_stamps_counts_once():
    client, controller = EgmWire(), EgmWire()
    message = client._sensor()
    message.header.seqno, message.planned.joints.joints[:] = 7, [1.0] * 6
    datagram = message.SerializeToString()
    assert controller.decode_answer(datagram, state()) is not None
    assert controller.decode_answer(datagram, state()) is None


def test_a_second_of_cycles_is_a_second_by_every_clock_of_a_message():
    """Milliseconds in EGM's header and RSI's IPOC, seconds and microseconds in EGM's feedback."""
    controller = guided()
    for _ in range(312):  # of 4 ms
        controller.cycle(Answer(values=np.degrees(START), additive=False))
    egm, rsi = EgmWire(), RsiWire()
    message = egm._robot.FromString(egm.encode_state(controller.state()))
    assert message.header.tm == 1248
    for part in (message.feedBack, message.planned):
        assert (part.time.sec, part.time.usec) == (1, 248_000)
    assert ET.fromstring(rsi.encode_state(controller.state())).findtext("IPOC") == "1248"


def test_a_message_of_the_controller_has_degrees_and_millimetres():
    """Of a planar arm, whose tool follows from its two angles and lengths alone."""
    controller = guided()
    egm = EgmWire()
    message = egm._robot.FromString(egm.encode_state(controller.state()))
    phi = np.array(message.feedBack.joints.joints) * np.pi / 180.0
    np.testing.assert_allclose(phi, START, atol=1e-4)  # a step of the encoder
    links = CELL.robot.links
    angles = np.cumsum(phi + [link.theta for link in links])
    reach = np.array([link.a for link in links])
    place = message.feedBack.cartesian.pos
    expected = 1e3 * np.array([reach @ np.cos(angles), reach @ np.sin(angles)])
    np.testing.assert_allclose([place.x, place.y], expected, atol=1e-6)


def test_a_message_cannot_be_changed():
    with pytest.raises(FrozenInstanceError):
        state().number = 1
    with pytest.raises(FrozenInstanceError):
        Answer(values=None, additive=False).additive = True


def test_relative_corrections_add_up():
    client, controller, to = RsiWire(relative=True), RsiWire(relative=True), state()
    wanted = [np.full(6, value) for value in (0.5, 0.75, 0.25)]
    for values in wanted:
        datagram = client.encode_answer(Answer(values=values, additive=True), to.time)
        answer = controller.decode_answer(datagram, to)
        assert answer is not None
        np.testing.assert_array_equal(answer.values, values)


WRONG_XML = (
    b"",
    b"<Sen/>",
    b"<Rob><IPOC>4000</IPOC></Rob>",
    b"<Sen><AKorr A1='1'/><IPOC>4000</IPOC>",
    b"<Sen><AKorr A2='1'/><IPOC>4000</IPOC></Sen>",
    b"<Sen><AKorr A1='nan'/><IPOC>4000</IPOC></Sen>",
    b"<Sen><AKorr A1='1e400'/><IPOC>4000</IPOC></Sen>",
    b"<Sen><AKorr A1='1'/><IPOC>-4</IPOC></Sen>",
    b"<Sen><AKorr A1='1'/><IPOC>" + b"9" * 500 + b"</IPOC></Sen>",
    b"<!DOCTYPE x [<!ENTITY a 'aaaa'>]><Sen><IPOC>4000</IPOC></Sen>",
    b"<?xml version='1.0' encoding='utf-7'?><Sen/>",
    b"\xff\xfe\x00",
    b"<Sen>" * 3000,
)


@pytest.mark.parametrize("datagram", WRONG_XML)
def test_what_is_no_message_of_rsi_is_refused(datagram):
    with pytest.raises(WireError):
        RsiWire().decode_answer(datagram, state())


def test_guidance_by_poses_is_refused_by_name():
    message = EgmWire()._sensor()
    message.header.seqno = 1
    place = message.planned.cartesian.pos
    place.x = place.y = place.z = 1.0
    with pytest.raises(WireError, match="send joints"):
        EgmWire().decode_answer(message.SerializeToString(), state())


def test_a_path_correction_is_abbs_message_byte_for_byte():
    """Tags and wire types by hand, of egm.proto: header 1 (seqno 1, tm 2, mtype 3), pathCorr 2 (pos
    1 of three doubles, age 2)."""
    to, offset = state(time=4000), np.array([0.0, 1.5, -0.25])
    answer = Answer(values=offset, additive=True, of_path=True)
    double = [bytes([8 * field + 1]) + struct.pack("<d", x) for field, x in enumerate(offset, 1)]
    pos = b"".join(double)
    header = b"\x0a\x07" + b"\x08\x01" + b"\x10\xa0\x1f" + b"\x18\x04"
    corrected = b"\x0a" + bytes([len(pos)]) + pos + b"\x10\x00"
    sent = EgmPathWire().encode_answer(answer, to.time)
    assert sent == header + b"\x12" + bytes([len(corrected)]) + corrected
    wire = EgmPathWire()
    got = wire.decode_answer(sent, to)
    np.testing.assert_array_equal(got.values, offset)
    assert (got.of_path, wire.decode_answer(sent, to)) == (True, None)
    end = EgmPathWire().encode_answer(Answer(values=None, additive=True), to.time)
    assert EgmPathWire().decode_answer(end, to).values is None
