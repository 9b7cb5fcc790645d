"""Transmission error of the virtual large robot, found with its tracker and with its IMU."""

from dataclasses import replace

import numpy as np
import pytest
from tests.claims._gear_errors import discrepancies

from armside.assets import LARGE_ROBOT_XML
from armside.kinematics import CATALOGUE
from armside.sim.gears import VIRTUAL, analyse_gears, virtual_run
from armside.sim.gears.virtual_run import excitation, posture, recorded
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.experiment import prepare
from armside.sim.laser.specification import Cut
from armside.sim.robot.effects import Effect
from armside.sim.robot_file.find import find_cell

OTHERS = tuple(effect for effect in Effect if effect is not Effect.GEAR_ERROR)
SETUP = Cut(pose="p2", imu=ImuCfg(), without=OTHERS)
"""With all effects: `make claims NAME=estimation-gears`."""
RUNS = 2


@pytest.fixture(scope="module", autouse=True)
def quicker():
    """Motions of 90 s, of a little faster sines."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(virtual_run, "DURATION", 90.0)
        patch.setattr(virtual_run, "FREQUENCY", (0.02, 0.06))
        yield


@pytest.fixture(scope="module")
def recordings(quicker):
    return [recorded(SETUP, 11, run) for run in range(RUNS)]


@pytest.fixture(scope="module")
def truth():
    still = np.tile(posture(SETUP.cell, SETUP.tool_pose), (3, 1))
    return prepare(SETUP, planned=lambda _: (None, still), seed=11).loaded.model.gear_error


@pytest.mark.parametrize(("sensor", "n"), [("imu", 2), ("tracker", 1)])
def test_each_axis_that_moves_the_tool_is_found(recordings, truth, sensor, n):
    """Amplitude within 20 %, phase at the middle of the travel within 0.2 rad."""
    done = analyse_gears(CATALOGUE["large"], recordings[:n], replace(VIRTUAL, sensor=sensor))
    axes = discrepancies(done, truth)
    assert [axis.joint for axis in axes] == [1, 2, 3]
    for axis in axes:
        assert abs(axis.amplitude) < 0.2
        assert abs(axis.phase) < 0.2


def test_each_run_is_another_motion_and_can_be_repeated(recordings, monkeypatch):
    first, second = (one.encoders.values for one in recordings)
    assert np.abs(first - second).max() > 0.05
    monkeypatch.setattr(virtual_run, "DURATION", 8.0)
    again, same = (recorded(SETUP, 11) for _ in range(2))
    np.testing.assert_array_equal(again.encoders.values, same.encoders.values)
    assert again.imu is not None
    assert same.imu is not None
    np.testing.assert_array_equal(again.imu.values, same.imu.values)


def test_a_pose_too_near_to_a_limit_is_refused_with_the_axis():
    limits = SETUP.cell.limits
    centre = 0.5 * np.add(limits.lower, limits.upper)
    centre[3] = limits.upper[3]
    with pytest.raises(ValueError, match="axis 4 of the pose is too near to a joint limit"):
        excitation(centre, limits, np.random.default_rng(0), [False] * 6)


@pytest.mark.parametrize("name", ["scara", "two_link"])
def test_an_arm_whose_axes_are_parallel_is_refused_before_it_runs(name):
    robot = str(LARGE_ROBOT_XML.with_name(f"{name}.toml"))
    with pytest.raises(ValueError, match="turn the tool about one direction alone: gears needs"):
        recorded(Cut(robot=robot, imu=ImuCfg()), 0)


def test_a_slide_moves_by_tenths_of_a_metre_where_other_axes_turn_by_a_radian():
    cell = find_cell(str(LARGE_ROBOT_XML.with_name("scara.toml")))
    centre = posture(cell, cell.poses["p1"])
    slides = cell.robot.slides
    assert slides == (False, False, True, False)
    motion = excitation(centre, cell.limits, np.random.default_rng(0), slides) - centre
    travel = np.ptp(motion, axis=0)
    assert 0.02 < travel[2] < 0.2  # of a stroke of 0.2 m
    assert (travel[[0, 1, 3]] > 0.2).all()
