"""Motions about home, for robots without programs."""

from dataclasses import replace

import numpy as np
import pytest

from armside import assets
from armside.kinematics import Limits
from armside.kinematics.dh import CoupledRange
from armside.sim.imu import ImuExperiment, run_imu
from armside.sim.imu.imu_specification import RestExperiment
from armside.sim.motion.about_home import (
    MOTIONS,
    OF_TORQUE,
    RISE,
    SWING,
    dynamics_of,
    programs_about,
    room,
)
from armside.sim.motion.instructions import (
    Dynamics,
    MoveJ,
    Program,
    ProgramError,
    Speed,
    Target,
    Wait,
)
from armside.sim.motion.planner import plan_program
from armside.sim.motion.program_file import parse_program
from armside.sim.robot.kinematics_check import cell_model
from armside.sim.robot_file.find import read_cell

FILE = assets.LARGE_ROBOT_XML.with_name("two_link.toml")


@pytest.fixture(scope="module")
def two_axes():
    cell = read_cell(FILE)
    return cell, cell_model(cell), np.array(cell.home)


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_motion_starts_and_ends_at_home_and_stays_within_limits_and_drives(two_axes, motion):
    cell, model, home = two_axes
    (program,) = programs_about(home, cell.limits, model, motion).values()
    made = plan_program(program, cell.robot, cell.limits)
    assert made.phi[[0, -1]] == pytest.approx(np.stack((home, home)))
    assert all(cell.limits.contain(phi) for phi in made.phi)
    assert np.abs(made.phi - home).max() == pytest.approx(SWING)
    rate = np.gradient(made.phi, 0.004, axis=0)
    assert (np.abs(rate) <= np.array(cell.limits.speed)).all()
    assert (np.ptp(made.phi, axis=0) > 0.9 * SWING).all()


def test_the_swing_of_the_synchronisation_is_a_third_of_the_way_to_either_side(two_axes):
    cell, model, home = two_axes
    (program,) = programs_about(home, cell.limits, model, "simultaneous").values()
    moves = [m.to.motors for m in program.instructions if isinstance(m, MoveJ) and m.to.motors]
    swing, whole = np.array(moves[:2]) - home, np.array(moves[2:]) - home
    ends = np.stack((whole.max(axis=0), whole.min(axis=0)))
    np.testing.assert_allclose(3.0 * swing, ends, atol=1e-12)


def test_a_sequential_motion_moves_one_motor_at_a_time_after_the_synchronisation(two_axes):
    cell, model, home = two_axes
    (program,) = programs_about(home, cell.limits, model, "sequential").values()
    pause = next(i for i, step in enumerate(program.instructions) if isinstance(step, Wait))
    for step in program.instructions[pause + 1 :]:
        if isinstance(step, MoveJ) and step.to.motors is not None:
            assert (np.array(step.to.motors) != home).sum() <= 1


def test_accelerations_are_those_that_part_of_the_torque_can_make(two_axes):
    cell, model, home = two_axes
    fast = replace(cell.limits, speed=(1e3, 1e3))
    made = dynamics_of(home, fast, model).joint_acceleration
    weaker = replace(model.drives, torque_limit=0.5 * model.drives.torque_limit)
    less = dynamics_of(home, fast, replace(model, drives=weaker)).joint_acceleration
    assert np.array(less) == pytest.approx(0.5 * np.array(made))
    # The second motor turns its own link, rotor and tool: below what its torque makes of its rotor.
    rotor = model.mj.dof_armature[model.motor[1]]
    torque = model.drives.torque_limit * np.abs(model.drives.gear)
    assert 0.0 < made[1] < OF_TORQUE * torque[1] / max(rotor, 1e-9)


def test_every_combination_of_ends_keeps_the_ranges_of_sums():
    phi = np.array([0.1, 0.2, -0.1])
    bound = CoupledRange(coefficients=(0.0, -1.0, 1.0), lower=-0.5, upper=0.2)
    ranges = {"lower": (-1.0,) * 3, "upper": (1.0, 0.3, 1.0), "speed": (1.0,) * 3}
    limits = Limits(**ranges, coupled=(bound,))
    low, high = room(phi, limits)
    corners = np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)
    assert all(limits.contain(corner) for corner in corners)
    assert (low < phi).all()
    assert (high > phi).all()


def test_a_home_without_room_is_refused():
    narrow = Limits(lower=(-1.0, -1e-4), upper=(1.0, 1e-4), speed=(1.0, 1.0))
    with pytest.raises(ValueError, match="motor 2 has no room about home: give another home"):
        room(np.zeros(2), narrow)


def test_the_kinematics_predict_what_the_imu_of_a_robot_file_measures():
    (found,) = run_imu(ImuExperiment(robot=str(FILE)), seed=0)
    error, peak = found.measures.acceleration_rms, found.measures.acceleration_peak
    assert (error[:2] < 0.05 * peak[:2]).all()  # in its plane
    assert abs(found.measures.clock_offset_error) < 1e-3
    assert found.measures.idle_peaks.shape == (2,)


def test_rest_needs_brakes():
    with pytest.raises(ValueError, match="motion rest needs brakes, which robot "):
        RestExperiment(robot=str(FILE))


def test_programs_of_a_file_have_an_angle_for_each_motor_of_the_robot():
    text = 'start = [0, 10]\n[[program]]\ndo = "MoveJ"\nto = { motors = [5, 20] }\nspeed = "50 %"\n'
    known = Dynamics(joint_acceleration=(3.0, 4.0))
    program = parse_program(text, n_axes=2, dynamics=known)
    assert program.start == pytest.approx(np.deg2rad([0.0, 10.0]))
    assert program.dynamics == known
    with pytest.raises(ProgramError, match="motors must be 6 numbers"):
        parse_program(text)


def test_a_program_whose_moves_have_another_number_of_motors_is_refused():
    move = MoveJ(to=Target(motors=(0.1,) * 3), speed=Speed(share=0.5))
    with pytest.raises(ProgramError, match="motors must be 6 numbers, one for each motor, got 3"):
        Program(instructions=(move,))


def test_the_speed_of_a_programme_is_reached_within_its_rise(two_axes):
    cell, model, home = two_axes
    slow = replace(cell.limits, speed=(1e-3, 2e-3))
    assert dynamics_of(home, slow, model).joint_acceleration == pytest.approx(
        (1e-3 / RISE, 2e-3 / RISE)
    )
