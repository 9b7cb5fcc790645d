"""Motion programs of the IMU experiment: their dynamics, speeds and pauses. Thesis 5.3.2."""

import numpy as np
import pytest

from armside import assets
from armside.sim.motion.instructions import MoveC, MoveJ, MoveL, Wait
from armside.sim.motion.program_file import read_program

FOLDER = assets.IRB1400_XML.parent / "programs"
PROGRAMS = sorted(path.name for path in FOLDER.glob("*.toml"))
# ESTIMATES of the study of the IMU experiment
IRB1400 = (14, 12, 12, 50, 50, 70)  # [rad/s^2]
JERK_TIME = 0.050  # [s]


def of_kind(program, kind):
    return [step for step in program.instructions if isinstance(step, kind)]


@pytest.mark.parametrize("name", [name for name in PROGRAMS if name.startswith("irb1400")])
def test_programs_of_the_irb1400_share_their_dynamics(name):
    dynamics = read_program(FOLDER / name).dynamics
    assert dynamics.joint_acceleration == pytest.approx(IRB1400)
    assert dynamics.jerk_time == pytest.approx(JERK_TIME)


def test_the_simultaneous_motion_has_the_speeds_of_the_thesis_and_its_synchronisation():
    program = read_program(FOLDER / "irb1400_simultaneous.toml")
    assert program.dynamics.path_acceleration == 9.0
    assert [step.speed.path for step in of_kind(program, MoveC)] == [0.5, 0.5, 1.0, 1.0]
    assert {step.speed.path for step in of_kind(program, MoveL)} == {5.0}
    assert {step.speed.share for step in of_kind(program, MoveJ)} == {0.8}
    swing = [step.to.motors for step in of_kind(program, MoveJ)[:3]]
    # motor 1 alone, 0.12 rad to either side and home, then a second of rest
    assert np.array(swing)[:, 0] == pytest.approx([0.12, -0.12, 0.0], abs=1e-3)
    assert not np.any(np.array(swing)[:, 1:])
    waits = [step.seconds for step in of_kind(program, Wait)]
    assert waits[0] == 1.0
    assert set(waits[1:]) == {0.15}


@pytest.mark.parametrize(("part", "motors", "size"), [("arm", 0, 0.4), ("wrist", 3, 0.5)])
def test_sequential_motions_swing_one_motor_after_another_and_rest_between(part, motors, size):
    """Fig. 5.4: +-0.4 rad for motors 1 to 3, +-0.5 for 4 to 6."""
    program = read_program(FOLDER / f"irb1400_sequential_{part}.toml")
    targets = np.array([step.to.motors for step in of_kind(program, MoveJ)])
    for motor in range(motors, motors + 3):
        swings = targets[np.abs(targets[:, motor]) > 0.0, motor]
        assert swings == pytest.approx([size, -size], abs=1e-3)
    assert np.count_nonzero(np.abs(targets).max(axis=0)) == 3
    assert {step.speed.share for step in of_kind(program, MoveJ)} == {0.35}
    assert {step.seconds for step in of_kind(program, Wait)} == {0.5}
    assert not of_kind(program, MoveL) + of_kind(program, MoveC)
