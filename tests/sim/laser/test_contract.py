"""Signals of one cut: what is logged when, with which sign and unit; and the defaults of a cut."""

import numpy as np
import pytest

from armside.sim.cell import CELLS, LARGE_ROBOT_POSES, TOOL_QUATERNION
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser import Cut, learn, prepare
from armside.sim.laser.specification import SPIRAL_START, LeadIn
from armside.sim.motion.contour import Circle
from armside.sim.motion.tool_motion import cut
from armside.sim.robot.effects import Effect


@pytest.fixture(scope="module")
def experiment():
    return prepare(Cut(imu=ImuCfg()), seed=3)


@pytest.fixture(scope="module")
def iterations():
    return list(learn(Cut(imu=ImuCfg()), iterations=1, seed=3))


def test_a_cut_is_that_of_the_thesis_unless_said_otherwise():
    """Thesis 9.3: pose p1, 5 mm at 40 mm/s in the base x-y plane, all gear effects."""
    cut = Cut()
    assert (cut.robot, cut.pose, cut.radius, cut.speed) == ("large", "p1", 0.005, 0.040)
    assert not cut.across_tool
    assert (cut.friction_spread, cut.without, cut.payload, cut.imu) == (0.02, (), None, None)
    assert cut.individual is None
    assert cut.payload_known


def test_poses_are_those_of_the_thesis():
    """Thesis (9.3) and (9.4)."""
    poses = CELLS["large"].poses
    assert poses["p1"].position == (1.3166, 0.0014, 1.5992)
    assert poses["p2"].position == (1.8, 0.1, 1.5992)
    assert poses["p3"].position == (2.2, 0.2, 1.5992)
    assert {pose.quaternion for pose in poses.values()} == {TOOL_QUATERNION}


def test_friction_of_a_drawn_robot_stays_within_its_spread():
    nominal, factors = prepare(Cut(), seed=0).nominal, []
    without = tuple(Effect)
    for seed in range(5):
        real = prepare(Cut(without=without), seed=seed, nominal=nominal).loaded.model
        factors.append(real.mj.actuator_biasprm[:, 3] / nominal.mj.actuator_biasprm[:, 3])
    factors = np.array(factors)
    assert np.abs(factors - 1.0).max() <= 0.02
    assert np.abs(factors - 1.0).max() > 0.015  # 30 draws
    assert len(np.unique(factors)) == factors.size


def test_the_log_has_250_hz_and_the_truth_2000(iterations):
    recording = iterations[0].run.recording
    assert np.diff(recording.time) == pytest.approx(np.full(len(recording.time) - 1, 0.004))
    assert np.diff(recording.truth.time[:9]) == pytest.approx(np.full(8, 0.0005))
    assert recording.truth.time[::8] == pytest.approx(recording.time)


def test_the_error_is_reference_minus_measurement_in_radians_of_the_motor(iterations):
    """Thesis (9.2) and 9.2.3."""
    it = iterations[0]
    recording, gear = it.run.recording, np.array([220, 242.73, 242.73, 145, 180, 100])
    e = recording.reference - recording.motor_angle
    assert recording.error == pytest.approx(e, abs=1e-15)
    assert it.motor_error == pytest.approx(e * gear)
    # friction and the servo's lag hold a motor back: the error has the sign of the speed
    speed = np.gradient(recording.reference, 0.004, axis=0)
    assert (np.einsum("ni,ni->i", e, speed) > 0.0).all()


def test_an_encoder_measures_the_motor_before_gear_error_and_spring(iterations):
    recording = iterations[0].run.recording
    truth = recording.truth.every(8)
    count = 2 * np.pi / 16384 / np.array([220, 242.73, 242.73, 145, 180, 100])
    # thesis 5.3.1: the log is the motor angle in whole counts
    assert (np.abs(recording.motor_angle - truth.motor_angle) <= 0.51 * count).all()
    apart = truth.gear_angle - truth.motor_angle
    assert apart == pytest.approx(truth.gear_error(truth.gear_angle), abs=1e-15)
    assert (np.abs(apart).max(axis=0) > 2 * count).any()
    assert truth.flex_angle + truth.motor_angle == pytest.approx(
        truth.spring_angle + truth.gear_angle, abs=1e-15
    )


def test_the_first_run_has_no_correction_and_the_second_has(iterations):
    assert not iterations[0].correction.any()
    assert not iterations[0].run.recording.correction.any()
    assert iterations[1].correction.any()
    assert np.array_equal(iterations[1].run.recording.correction, iterations[1].correction)


def test_tool_error_is_that_of_one_turn_and_its_radius(iterations):
    """(9.6), (9.7) of 0.785 s at 1 kHz: 5 mm at 40 mm/s."""
    for tool in (error for it in iterations for error in (it.tool, it.tool_true)):
        turn = round(2 * np.pi * 0.005 / 0.040 * 1000)
        assert abs(len(tool.path) - turn) <= 1
        deviation = 0.005 - np.hypot(*tool.path.T)
        assert tool.rms == pytest.approx(np.sqrt(np.mean(deviation**2)))
        assert tool.maxdev == pytest.approx(np.abs(deviation).max())


def test_instruments_start_with_the_run_and_use_streams_of_their_own(experiment):
    first = experiment.plant.run(np.zeros_like(experiment.loaded.reference))
    assert first.tracker.time[0] == 0.0
    assert first.imu is not None
    assert np.diff(first.imu.time) == pytest.approx(np.full(len(first.imu.time) - 1, 0.01))
    # without an IMU the robot and its tracker get the same noise
    alone = prepare(Cut(), seed=3)
    other = alone.plant.run(np.zeros_like(alone.loaded.reference))
    assert np.array_equal(first.recording.motor_angle, other.recording.motor_angle)
    assert np.array_equal(first.tracker.position, other.tracker.position)


def test_another_seed_is_another_robot_set_up_and_noise():
    one, two = (prepare(Cut(imu=ImuCfg()), seed=seed) for seed in (0, 1))
    friction = [e.loaded.model.mj.actuator_biasprm[:, 3] for e in (one, two)]
    assert (friction[0] != friction[1]).all()
    assert (one.plant.tracker.bias != two.plant.tracker.bias).all()
    assert one.plant.imu.unit.clock_offset != two.plant.imu.unit.clock_offset
    draws = [e.plant.rng.standard_normal(3) for e in (one, two)]
    assert (draws[0] != draws[1]).all()


POSE = LARGE_ROBOT_POSES["p1"]


def motion_of(specification):
    return cut(specification.path, POSE.quaternion, specification.speed)


def test_a_spiral_starts_inside_and_the_contour_is_the_same():
    arc = Cut(pose=POSE)
    spiral = Cut(pose=POSE, lead_in=LeadIn.SPIRAL)
    centre = np.array(POSE.position)
    assert np.linalg.norm(spiral.path.position(0.0) - centre) == pytest.approx(SPIRAL_START * 0.005)
    motion = motion_of(spiral)
    assert motion.reached_speed == 0.040
    on_contour = np.linalg.norm(motion.position[motion.on_contour] - centre, axis=1)
    np.testing.assert_allclose(on_contour, arc.radius, rtol=0, atol=1e-15)


def test_a_circle_has_a_lead_in_of_a_tenth():
    circle = Cut(pose=POSE, radius=0.007)
    assert circle.curve == Circle(0.007)
    assert circle.path.lead_in == pytest.approx(0.1 * 2 * np.pi * 0.007)


@pytest.mark.parametrize("without", [["ripple"], "ripple", ("lost-motion", Effect.RIPPLE)])
def test_a_text_in_place_of_an_effect_is_refused(without):
    with pytest.raises(ValueError, match=r"got '.*'. Effects: Effect.LOST_MOTION"):
        Cut(without=without)


@pytest.mark.parametrize(("known", "added"), [(True, 35.0), (False, 0.0)])
def test_a_controller_that_knows_the_payload_knows_what_it_has_beyond_the_tool_of_40_kg(
    known, added
):
    made = prepare(Cut(payload=75.0, payload_known=known), seed=0)
    assert made.added_payload == pytest.approx(added)
