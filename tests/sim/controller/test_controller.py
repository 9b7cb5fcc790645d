"""The virtual controller: guidance, limits, silence, rest."""

import re

import numpy as np
import pytest

from armside import kinematics
from armside.sim.controller import Answer, GuidanceLimits, Hold, Phase, VirtualController
from armside.sim.laser.experiment import prepare
from armside.sim.laser.specification import Cut

from .robots import CELL, MODEL, START, guided, path, programmed


def ends_of(controller):
    """(recording, missed answers, fallen silent) of each run of a controller, as it ends."""
    ended = []
    controller.on_end = lambda run, missed: ended.append((run, missed, controller.abandoned))
    return ended


def follow(controller, targets):
    """Guide along targets (N, 2) [rad]; the measured angles (N, 2) [rad]."""
    measured = []
    for target in targets:
        measured.append(np.deg2rad(controller.state().joints))
        controller.cycle(Answer(values=np.rad2deg(target), additive=False))
    return np.array(measured)


def until_waiting(controller, most=2000):
    for _ in range(most):
        if controller.phase is Phase.WAITING:
            return
        controller.cycle(None)
    raise AssertionError("the robot does not come to rest")


def test_a_robot_follows_where_it_is_guided_and_ends_at_rest():
    controller, targets = guided(), path(120)
    ended = ends_of(controller)
    measured = follow(controller, targets)
    late = 4  # samples: delay and lag of the correction path
    assert np.abs(measured[late:] - targets[:-late]).max() < 0.2 * np.ptp(targets)
    controller.cycle(Answer(values=None, additive=False))
    assert controller.phase is Phase.STOPPING
    until_waiting(controller)
    ((run, missed, abandoned),) = ended
    assert missed == abandoned == 0
    assert np.abs(np.diff(run.motor_angle[-5:], axis=0)).max() < 1e-5
    np.testing.assert_allclose(np.deg2rad(controller.state().joints), START, atol=1e-3)


def test_silence_stops_a_moving_robot_within_its_limits():
    controller = guided()
    ended = ends_of(controller)
    follow(controller, START + np.arange(60)[:, None] * 0.004 * np.array([2.0, -2.0]) * 0.9)
    for _ in range(controller.silence):
        assert controller.phase is Phase.GUIDED
        controller.cycle(None)
    assert controller.phase is Phase.STOPPING
    until_waiting(controller)
    ((run, _, abandoned),) = ended
    assert abandoned
    assert "joint" not in {hit[0] for hit in run.limits_hit}
    speed = np.diff(run.motor_angle, axis=0) / 0.004
    assert np.abs(speed[-1]).max() < 1e-2


def test_a_guided_motion_slows_down_evenly_to_rest_in_a_fifth_of_a_second():
    """So it goes on for half of the way that its speed would have taken it in that time."""
    controller, rate = guided(seconds=4.0), np.array([1.5, -1.5])
    ended = ends_of(controller)
    follow(controller, START + np.arange(60)[:, None] * 0.004 * rate)
    controller.cycle(Answer(values=None, additive=False))
    until_waiting(controller)
    angle, late = ended[0][0].motor_angle, 4  # samples: delay and lag of the correction path
    begin, middle, end = (60 + late + round(s / 0.004) for s in (0.0, 0.1, 0.2))
    speed = np.diff(angle, axis=0) / 0.004
    np.testing.assert_allclose(speed[middle], 0.5 * rate, atol=0.2)
    np.testing.assert_allclose(speed[end], 0.0, atol=0.1)
    np.testing.assert_allclose(angle[end] - angle[begin], 0.5 * 0.2 * rate, rtol=0.15)


@pytest.mark.parametrize(
    ("target", "reason"),
    [
        (START + np.array([0.05, 0.0]), "axis 1 must be at most .* deg/s fast here, got 716"),
        (np.array([9.0, 1.5]), "axis 1 must be -148.9.* to 148.9.* deg, got 515"),
        (np.array([np.nan, 1.5]), "not finite"),
        (np.array([0.0, 1.5, 0.0]), "needs 2 axes, got 3"),
    ],
)
def test_a_target_outside_the_limits_is_refused_by_name_and_holds_the_last(target, reason):
    controller = guided()
    follow(controller, np.tile(START, (5, 1)))
    before = controller.state().joints
    for _ in range(10):
        controller.cycle(Answer(values=np.rad2deg(target), additive=False))
    assert controller.missed == 10
    (refusal,) = controller.refusals
    assert re.search(reason, refusal), refusal
    np.testing.assert_allclose(controller.state().joints, before, atol=0.01)


def test_a_joint_driven_towards_its_limit_stays_inside():
    limits = GuidanceLimits.of(MODEL, CELL)
    start = np.array([limits.upper[0] - 0.8, 1.0])
    controller = VirtualController.standing(MODEL, CELL, Hold(start=start, seconds=4.0))
    largest, target = 0.0, start.copy()
    for _ in range(400):
        wish = target + np.array([0.004 * limits.speed[0], 0.0])
        if limits.refusal(wish, target) is None:
            target = wish
        controller.cycle(Answer(values=np.rad2deg(target), additive=False))
        largest = max(largest, np.deg2rad(controller.state().joints[0]))
    assert largest > start[0] + 0.4
    assert largest <= limits.upper[0]
    assert not controller.refusals


def test_a_correction_of_a_program_has_a_limit_of_five_degrees():
    controller = programmed()
    for k in range(30):
        values = np.array([min(0.5 * k, 5.5), 0.0])
        controller.cycle(Answer(values=values, additive=True))
    assert "the correction of axis 1 must be within 5 deg, got 5.5" in controller.refusals[0]


def test_a_program_is_waited_for_and_runs_to_its_end():
    controller = programmed()
    ended = ends_of(controller)
    for _ in range(20):
        controller.cycle(None)
    assert controller.state().time == 0
    controller.cycle(Answer(values=np.zeros(2), additive=True))
    until_waiting(controller)
    ((run, missed, _),) = ended
    np.testing.assert_array_equal(run.reference, path())
    assert missed == controller.silence


@pytest.mark.parametrize(
    ("bad", "said"),
    [
        (np.array([9.0, 0.0]), "start: axis 1 must be"),
        (np.array([0.0]), r"start must have 2 angles, got \(1,\)"),
    ],
)
def test_a_start_outside_the_robot_is_refused(bad, said):
    with pytest.raises(ValueError, match=said):
        VirtualController.standing(MODEL, CELL, Hold(start=bad))


def test_a_path_correction_moves_the_tool_across_the_path_in_its_own_frame():
    """1.5 mm along z of the tool cross the tangent of a circle, -1 mm along the third axis, nothing
    along the path, whatever is asked there: as commanded to 20 um, which the tangent of a path is
    off that anticipates its deflection, and at the tool but for a fifth, which friction holds."""
    experiment = prepare(Cut(radius=0.02), seed=0)
    controller = VirtualController(experiment.loaded, experiment.cut.cell)
    ended, plain = ends_of(controller), experiment.loaded.run()
    for k in range(len(plain.time)):
        share = 0.5 - 0.5 * np.cos(np.pi * min(1.0, k / 100))
        offset = share * np.array([7.0, 1.5, -1.0])
        controller.cycle(Answer(values=offset, additive=True, of_path=True))
    ((run, missed, _),) = ended
    assert (missed, controller.refusals) == (0, [])
    on, tool_pose = experiment.motion.on_contour, experiment.cut.tool_pose
    out = (experiment.motion.position - np.array(tool_pose.position))[on]
    x = np.cross([0.0, 0.0, 1.0], out)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    y = np.cross(tool_pose.tool_axis, x)
    y /= np.linalg.norm(y, axis=1, keepdims=True)
    frame, asked = np.stack([x, y, np.cross(x, y)], axis=1), np.array([0.0, 1.5, -1.0])
    pose = kinematics.compile(experiment.cut.cell.robot).pose
    T, before = (pose(run.reference + u) for u in (run.correction, 0.0 * run.correction))
    commanded = np.einsum("nij,nj->ni", frame, 1e3 * (T - before)[on, :3, 3])
    assert np.abs(commanded - asked).max() < 0.02
    assert np.abs((T - before)[:, :3, :3]).max() < 1e-6
    step = round(len(plain.truth.time) / len(plain.time))
    tools = [each.truth.tool_position[::step][: len(on)][on] for each in (run, plain)]
    moved = np.einsum("nij,nj->ni", frame, 1e3 * (tools[0] - tools[1]))
    assert np.sqrt(np.mean(np.sum((moved - asked) ** 2, axis=1))) < 0.2 * np.linalg.norm(asked)
