"""RAPID that `abb-motion-program-exec` writes, read by us: a second opinion of the conventions."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armside.sim.controller.programs import read_program
from armside.sim.controller.programs.scanner import Text

abb = pytest.importorskip(
    "abb_motion_program_exec",
    reason="needs abb-motion-program-exec (pip, Apache-2.0)",
    exc_type=ImportError,
)
AXES = [0.0] * 6
DRAWN = 50


def quaternion(rotation):
    return list(rotation.as_quat(scalar_first=True))


def test_its_programs_mean_what_was_given_to_it():
    rng = np.random.default_rng(0)
    lever, place = rng.uniform(-300, 300, (2, 3))
    turned, laid = Rotation.random(2, rng=rng)
    load = abb.loaddata(1.0, [0, 0, 0.1], [1, 0, 0, 0], 0, 0, 0)
    tool = abb.tooldata(True, abb.pose(list(lever), quaternion(turned)), load)
    zero = abb.pose([0, 0, 0], [1, 0, 0, 0])
    wobj = abb.wobjdata(False, True, "", abb.pose(list(place), quaternion(laid)), zero)
    program = abb.MotionProgram(tool=tool, wobj=wobj)
    angles, points = rng.uniform(-90, 90, 6), rng.uniform(-2e3, 2e3, (DRAWN, 3))
    turns, middle = Rotation.random(DRAWN, rng=rng), rng.uniform(-2e3, 2e3, 3)

    def target(p, turn):
        return abb.robtarget(list(p), quaternion(turn), abb.confdata(0, -1, 0, 1), AXES)

    program.MoveAbsJ(abb.jointtarget(list(angles), AXES), abb.v1000, abb.fine)
    for p, turn in zip(points, turns, strict=True):
        program.MoveL(target(p, turn), abb.v50, abb.z1)
    program.MoveC(target(middle, turns[0]), target(points[0], turns[0]), abb.v100, abb.fine)
    program.WaitTime(1.5)
    read = read_program(Text("a.mod", program.get_program_rapid()))
    first, *linear, circular, wait = read.program.instructions
    np.testing.assert_allclose(np.degrees(first.to.motors), angles)
    np.testing.assert_allclose(1e3 * np.array([move.to.position for move in linear]), points)
    for move, turn in zip(linear, turns, strict=True):
        found = Rotation.from_quat(move.to.quaternion, scalar_first=True)
        assert (found * turn.inv()).magnitude() < 1e-9
    assert {(move.speed.path, move.zone) for move in linear} == {(0.05, 0.001)}
    np.testing.assert_allclose(1e3 * np.array(circular.via), middle)
    assert (circular.speed.path, circular.zone, wait.seconds) == (0.1, 0.0, 1.5)
    frames = read.places[1]
    np.testing.assert_allclose(1e3 * frames.tool.pose[:3, 3], lever)
    np.testing.assert_allclose(frames.tool.pose[:3, :3], turned.as_matrix(), atol=1e-12)
    np.testing.assert_allclose(1e3 * frames.base.pose[:3, 3], place)
    np.testing.assert_allclose(frames.base.pose[:3, :3], laid.as_matrix(), atol=1e-12)
