"""The square of four strokes: rest in each corner, within speed and acceleration, and learned."""

import re
from dataclasses import replace

import numpy as np
import pytest

from armside.assets import LARGE_ROBOT_XML
from armside.sim.laser.experiment import prepare
from armside.sim.laser.joint_bounds import DRIVE
from armside.sim.laser.loop import learn
from armside.sim.laser.specification import Cut
from armside.sim.laser.strokes import (
    PERIOD,
    REST_BEFORE,
    ROBOTS,
    SETTLING,
    Strokes,
    StrokesJob,
    torque_used,
)
from armside.sim.motion.timing import PathLimits
from armside.sim.robot.model import load_model
from armside.sim.robot.statics import Statics
from armside.sim.robot_file.find import find_cell

M16IB = "m16ib_like.toml"


@pytest.fixture(scope="module")
def experiment():
    return prepare(Strokes(robot=find_cell(str(ROBOTS / M16IB)), across_tool=True, individual=0))


def test_each_stroke_begins_and_ends_at_rest_within_its_limits(experiment):
    motion, h = experiment.motion, 1e-4
    for i in range(4):
        time = REST_BEFORE + PERIOD * i + np.arange(0.0, PERIOD, h)
        p = motion.position_at(time)
        speed = np.linalg.norm(np.diff(p, axis=0), axis=1) / h
        bend = np.linalg.norm(np.diff(p, n=2, axis=0), axis=1) / h**2
        # v (v / a + a / j) = 0.1 m at a = 12.5, j = 400: too short for 1 m/s
        reached = np.roots([1.0 / 12.5, 12.5 / 400.0, -0.1]).max()
        assert speed.max() == pytest.approx(reached, rel=1e-3)
        assert bend.max() == pytest.approx(12.5, rel=0.01)
        moving = time[:-1][speed > 1e-6]
        assert 0.18 < moving[-1] - moving[0] < 0.3  # 0.18 s at least, 0.2 to 0.3 s in the paper
        assert np.linalg.norm(p[-1] - p[0]) == pytest.approx(0.1)


def test_the_square_closes_in_the_plane_of_y_and_z(experiment):
    p = experiment.motion.position
    np.testing.assert_allclose(p[0], p[-1], atol=1e-12)
    np.testing.assert_allclose(np.ptp(p, axis=0), [0.0, 0.1, 0.1], atol=1e-9)
    np.testing.assert_allclose(p.mean(axis=0)[0], 1.0, atol=1e-9)


def test_a_stroke_that_would_outlast_its_period_is_refused():
    slow = Strokes(limits=PathLimits(acceleration=0.1, jerk=400.0))
    with pytest.raises(ValueError, match=r"a stroke takes 2 s, more than the time of 0.75 s"):
        prepare(slow)


def test_strokes_stop_at_each_corner_that_is_given():
    places = ((-0.1, 0.0), (0.0, 0.05), (0.1, 0.0))
    cut = Strokes(corners=places, period=1.0, limits=PathLimits(acceleration=2.0, jerk=100.0))
    motion = prepare(cut).motion
    seen = motion.position_at(np.array([0.0, REST_BEFORE + 0.95, REST_BEFORE + 1.95]))
    middle = np.array(cut.tool_pose.position)
    np.testing.assert_allclose(seen - middle, np.pad(places, ((0, 0), (0, 1))), atol=1e-9)


def test_the_error_of_motion_is_computed_when_it_is_asked_for(monkeypatch):
    asked = []
    monkeypatch.setattr("armside.sim.laser.loop.motion_error", lambda *_, **__: asked.append(1))
    (run,) = learn(Cut(), iterations=0)
    assert not asked
    assert run.motion_error is run.motion_error is None
    assert asked == [1]


@pytest.mark.parametrize("name", ["side", "speed"])
def test_a_square_needs_a_size_and_a_speed(name):
    with pytest.raises(ValueError, match=f"{name} must be > 0, got 0.0"):
        Strokes(**{name: 0.0})


def test_motors_that_follow_leave_an_arm_that_rings_more():
    """The finding of the paper, on an individual of development."""
    found = StrokesJob(M16IB, "motor", 0, iterations=3).run()
    assert found["acceleration_rms"][-1] > 1.05 * found["acceleration_rms"][0]
    assert found["tcp_rms_less_rest"][-1] < 0.5 * found["tcp_rms_less_rest"][0]
    assert found["reached_speed"] <= 1.0


def test_a_run_that_diverges_has_no_numbers_from_there_on(monkeypatch):
    from armside.sim.laser import strokes

    def two(*_, **__):
        for k, diverged in ((0, False), (1, True)):
            error = type("", (), dict.fromkeys(strokes.fields_of_numbers(), 1.0))
            yield type("", (), {"k": k, "diverged": diverged, "motion_error": error})

    monkeypatch.setattr(strokes, "learn", two)
    found = StrokesJob(M16IB, "motor", 0, iterations=1).run()["tcp_rms"]
    assert found[0] == 1.0
    assert np.isnan(found[1])


@pytest.fixture(scope="module")
def on_the_large_robot():
    return prepare(Strokes(pose="p3"))


def test_drives_are_strong_enough_for_what_is_planned_and_what_was_lowered_is_noted(
    on_the_large_robot,
):
    """At p3 the wrist would need six times its torque for 12.5 m/s^2."""
    experiment = on_the_large_robot
    drives, run = experiment.nominal.drives, experiment.plant.run(0.0 * experiment.loaded.reference)
    moving = run.recording.time > 0.1
    torque = np.abs(run.recording.motor_torque[moving]) / drives.torque_limit
    assert (
        torque_used(Statics(experiment.nominal), experiment.loaded.reference).max() <= 1.01 * DRIVE
    )
    assert (torque > 0.999).mean() < 1e-3  # springs ring a little above the rigid arm
    speed, acceleration = experiment.cut.notes(experiment.motion)
    assert speed.text.startswith("the speed is lowered from 1000 to ")
    text = (
        r"the acceleration is lowered from 12.5 to [0-9.]+ m/s\^2: drives would need more than 90 "
    )
    assert re.match(text, acceleration.text)


def test_a_slower_stroke_still_rests_before_the_next(on_the_large_robot):
    starts = [leg.start for leg in on_the_large_robot.motion.legs]
    ends = [leg.start + leg.timing.duration for leg in on_the_large_robot.motion.legs]
    assert np.subtract(starts[1:], ends[:-1]) == pytest.approx(SETTLING)


def test_a_drive_too_weak_at_any_pace_is_named(on_the_large_robot):
    """Drive 2 with a limit that its arm's weight alone takes up."""
    experiment = on_the_large_robot
    needed = torque_used(Statics(experiment.nominal), experiment.loaded.reference, slowest=True)
    limit = experiment.nominal.drives.torque_limit.copy()
    limit[1] *= needed[1] / 0.95
    drives = replace(experiment.nominal.drives, torque_limit=limit)
    weak = Statics(replace(experiment.nominal, drives=drives))
    with pytest.raises(ValueError, match=r"^drive 2 needs 9[456] % of its torque however slow"):
        experiment.cut.planned(weak)


def test_the_torque_of_a_reference_is_that_of_its_rigid_arm():
    """Axis 1 alone, which carries no gravity, at M times phi''."""
    statics = Statics(load_model(LARGE_ROBOT_XML))
    time = np.arange(0.0, 1.0, 0.004)
    start = prepare(Strokes()).loaded.reference[0]
    phi = np.tile(start, (len(time), 1))
    phi[:, 0] += 0.4 * np.sin(np.pi * time) ** 4
    still, moving = (torque_used(statics, each).max() for each in (0.0 * phi + start, phi))
    assert still < 0.5 * moving  # gravity alone
    drives, n = statics.model.drives, statics.model.n_axes
    mass = statics.rigid_forces(start[None], np.zeros((1, n)), np.eye(1, n))
    mass = mass - statics.rigid_forces(start[None], np.zeros((1, n)), np.zeros((1, n)))
    peak = np.abs(np.gradient(np.gradient(phi[:, 0], time), time)).max()
    inertia = abs(float(statics.motor_torque(mass)[0, 0]))
    limit = abs(drives.gear[0]) * drives.torque_limit[0]
    friction = drives.coulomb_friction[0] / drives.torque_limit[0]
    assert moving == pytest.approx(inertia * peak / limit, abs=1.5 * friction + 0.05)
