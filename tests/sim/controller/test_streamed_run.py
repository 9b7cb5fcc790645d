"""A run in pieces of one sample is the run in one piece."""

from dataclasses import replace

import numpy as np
import pytest

from armside.sim.controller.streamed_run import StreamedRun
from armside.sim.laser import Cut
from armside.sim.laser.experiment import prepare
from armside.sim.robot.statics import Statics
from armside.sim.robot.virtual_robot import VirtualRobot


@pytest.mark.parametrize("robot", ["large", "irb1400"])
def test_a_streamed_run_is_the_whole_run_bit_for_bit(robot):
    loaded = prepare(Cut(robot=robot, radius=0.002), seed=1).loaded
    samples = np.arange(len(loaded.reference))[:, None]
    u = 1e-3 * np.sin(0.05 * samples) * np.ones(6)
    u[-1] = 0.0  # acts after the end
    whole = loaded.run(u, np.random.default_rng(7))
    run, angles = StreamedRun(loaded, np.random.default_rng(7)), []
    for correction in u[:-1]:
        angles.append(run.motor_angle)
        run.advance(correction)
    angles.append(run.motor_angle)
    streamed = run.recording()
    assert run.finished
    np.testing.assert_array_equal(np.array(angles), whole.motor_angle)
    for name in ("time", "reference", "correction", "motor_angle", "motor_torque"):
        np.testing.assert_array_equal(getattr(streamed, name), getattr(whole, name))
    np.testing.assert_array_equal(streamed.truth.tool_position, whole.truth.tool_position)
    np.testing.assert_array_equal(streamed.truth.motor_torque, whole.truth.motor_torque)
    assert streamed.limits_hit == whole.limits_hit


def test_a_robot_whose_correction_acts_at_once_cannot_be_streamed():
    loaded = prepare(Cut(radius=0.002)).loaded
    drives = replace(loaded.model.drives, correction_delay=0.003)
    fast = replace(loaded, model=replace(loaded.model, drives=drives))
    with pytest.raises(ValueError, match=r"acts after 0\.004 s or more, .* after 0\.003 s"):
        StreamedRun(fast)


def test_physics_ahead_of_a_correction_changes_no_bit_and_no_signal_before_its_time():
    loaded = prepare(Cut(radius=0.002)).loaded
    plain, early = (StreamedRun(loaded, np.random.default_rng(2)) for _ in range(2))
    corrections = 1e-3 * np.random.default_rng(4).standard_normal((30, 6)).cumsum(axis=0)
    for u in corrections:
        early.ahead()
        np.testing.assert_array_equal(early.motor_angle, plain.motor_angle)
        np.testing.assert_array_equal(early.speed, plain.speed)
        plain.advance(u)
        early.advance(u)
    early.ahead()  # a run that ends here has no more samples for it
    a, b = plain.recording(), early.recording()
    np.testing.assert_array_equal(a.motor_angle, b.motor_angle)
    np.testing.assert_array_equal(a.truth.tool_position, b.truth.tool_position)
    assert len(b.time) == 30


def test_guided_torque_is_that_of_the_motion_at_the_end_of_each_period():
    """Of a robot that stood still: change of the rigid torque since then, linear in between."""
    model = prepare(Cut(radius=0.002)).loaded.model
    nominal, start = Statics(model), np.array([0.1, 0.2, -0.1, 0.3, 0.5, 0.2])
    loaded = VirtualRobot(model, nominal=nominal).load(np.tile(start, (60, 1)))
    guided, plain = StreamedRun(loaded, guiding=nominal), StreamedRun(loaded)
    time = loaded.log_period * np.arange(59)
    for u in (0.02 * np.sin(2.0 * np.pi * 2.0 * time) ** 2)[:, None] * np.ones(6):
        guided.advance(u)
        plain.advance(u)
    n, gear = loaded.ratio, model.drives.gear
    added = gear * (guided._controls - plain._controls)[: 59 * n].reshape(-1, 6, 3)[:, :, 2]
    path, period = guided._path, loaded.log_period
    ends = np.arange(2 * n - 1, 59 * n, n)
    speed = path.velocity[ends]
    bend = (speed - path.velocity[ends - n + 1]) / period
    forces = nominal.rigid_forces(start + path.position[ends], speed, bend)
    rest = nominal.rigid_forces(start[None], 0.0 * speed[:1], 0.0 * speed[:1])
    rigid = nominal.motor_torque(forces) - nominal.motor_torque(rest)
    assert model.drives.friction_feedforward == 0.0
    expected = model.drives.torque_feedforward * rigid
    np.testing.assert_allclose(added[ends], expected, atol=1e-9 * np.abs(expected).max())
    within = added[ends[0] + 1 :].reshape(-1, n, 6)
    steps = np.diff(np.concatenate([added[ends[:-1]][:, None], within], axis=1), axis=1)
    np.testing.assert_allclose(steps - steps[:, :1], 0.0, atol=1e-9 * np.abs(expected).max())
