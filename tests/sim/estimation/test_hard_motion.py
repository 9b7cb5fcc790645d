"""What counts as hard motion, and what is allowed there: a wider law, and a wider bound."""

from dataclasses import replace

import numpy as np
import pytest
from tests.claims._estimates import path_error, rigid_path

from armside.sim.estimation.arm_filter import FRACTION
from armside.sim.estimation.imu_health import ImuError
from armside.sim.estimation.nominal import nominal_arm
from armside.sim.estimation.rigid_motion import rigid_motion
from armside.sim.estimation.tool_law import HARD, OF_HARD
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser import Cut, ToolPath, prepare
from armside.sim.laser.loop import first_run
from armside.sim.laser.strokes import ROBOTS
from armside.sim.motion.contour import square
from armside.sim.motion.timing import PathLimits
from armside.sim.robot_file.find import find_cell

FAST = Cut(
    contour=square(0.1, 0.015), speed=1.0, limits=PathLimits(acceleration=12.5), imu=ImuCfg()
)
AT_P2 = replace(FAST, pose="p2")
CUTS = {
    "large and slow": (Cut(pose="p1", contour=square(0.3, 0.015), speed=0.05), False),
    "p2": (AT_P2, True),
    "kr16": (replace(FAST, robot=find_cell(str(ROBOTS / "kr16_like.toml"))), True),
} | {
    f"{pose}, {speed} m/s": (Cut(pose=pose, speed=speed), False)
    for pose in ("p1", "p2", "p3")
    for speed in (0.040, 0.081)
}


def excitation(cut, seed=0):
    experiment = prepare(cut, seed=seed)
    log, nominal = first_run(experiment).recording, experiment.nominal
    arm = ToolPath().assumed(experiment) if seed else nominal_arm(nominal)
    return rigid_motion(arm, log.time, log.motor_angle).excitation(nominal)


@pytest.mark.parametrize(("cut", "hard"), CUTS.values(), ids=CUTS)
def test_hard_is_a_motion_that_twists_gears_by_inertia(cut, hard):
    """Along the large square, gravity twists them by 2.5 times `TWIST`."""
    assert (excitation(cut) >= HARD) is hard


def test_robots_that_are_assumed_differently_are_judged_alike():
    """Assumed stiffnesses are up to 30 % apart; the motors of two robots move almost alike."""
    found = [excitation(AT_P2, seed) for seed in (0, 10000, 10001)]
    assert found == pytest.approx([found[0]] * 3, rel=0.01)


def commissioned(cut, **assumed):
    experiment, measure = prepare(cut), ToolPath(**assumed)
    run = first_run(experiment)
    return experiment, run, measure.commissioned(experiment, measure.assumed(experiment), run)


def test_a_hard_cut_is_not_refused_for_what_its_springs_leave():
    """433 mm/s through corners at 12.5 m/s^2, once refused for "5 times as much unexplained"."""
    experiment, run, output = commissioned(AT_P2)
    drives, torque = experiment.nominal.drives, np.abs(run.recording.motor_torque)
    assert (torque > 0.999 * drives.torque_limit).any(axis=0).sum() >= 4  # as in the case refused
    assert output.known.parameters.process_noise / FRACTION > 4.5  # refused if it were not hard
    assert path_error(output(run), run) < 0.05 * path_error(rigid_path(run), run)
    assert output.law.law.laws[0].cutoff == OF_HARD
    assert output.known.plants.excitation == pytest.approx(excitation(AT_P2), rel=0.01)


@pytest.mark.parametrize("payload", [50.0, -35.0])
def test_a_hard_cut_with_a_wrong_payload_is_refused(payload):
    with pytest.raises(ImuError, match=r"[0-9]+ times as much unexplained as expected"):
        commissioned(AT_P2, payload_error=payload)


@pytest.mark.parametrize("axis", range(3))
def test_a_hard_cut_with_an_imu_that_is_turned_is_refused(axis):
    """By 0.2 rad, about each axis of its housing; gravity does not show that about its own."""
    experiment, measure = prepare(AT_P2), ToolPath()
    run = first_run(experiment)
    angle, (i, j) = 0.2, np.delete(np.arange(3), axis)
    turn = np.eye(3)
    turn[[i, i, j, j], [i, j, i, j]] = np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)
    turned = {
        name: getattr(run.imu, name) @ turn.T for name in ("acceleration", "angular_velocity")
    }
    with pytest.raises(ImuError, match=r"deg|unexplained|innovations"):
        measure.commissioned(
            experiment, measure.assumed(experiment), replace(run, imu=replace(run.imu, **turned))
        )
