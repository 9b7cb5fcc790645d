"""The square of four strokes: rest in each corner, within speed and acceleration, and learned."""

import numpy as np
import pytest

from armside.sim.laser.experiment import prepare
from armside.sim.laser.loop import learn
from armside.sim.laser.specification import Cut
from armside.sim.laser.strokes import PERIOD, REST_BEFORE, ROBOTS, Strokes, StrokesJob
from armside.sim.motion.timing import PathLimits
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
