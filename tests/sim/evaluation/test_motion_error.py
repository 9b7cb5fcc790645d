"""Motion error: that of a tool whose error is known, and of a run by its joint angles alone."""

import mujoco
import numpy as np
import pytest

from armside.kinematics.rotation import from_quaternion
from armside.sim.evaluation.motion_error import motion_error
from armside.sim.laser.experiment import prepare
from armside.sim.laser.loop import learn
from armside.sim.laser.specification import Cut
from armside.sim.robot.recording import Truth

H = 5e-4
TIME = np.arange(6001) * H
"""Rest, a stroke along y from 0.5 to 1 s, rest, and one back from 2 to 2.5 s."""
TURNED = np.array([0.8, 0.0, 0.6, 0.0])
MODEL = mujoco.MjModel.from_xml_string("""
<mujoco><option gravity="0 0 -9.82"/><worldbody><body name="tool"><geom size="0.1"/>
  <site name="tool0" quat="0.6 0 0.8 0"/><site name="imu" quat="0.8 0.6 0 0" pos="0.1 0 0"/>
</body></worldbody></mujoco>""")


class Strokes:
    def position_at(self, time):
        up, down = (np.clip((np.asarray(time) - t) / 0.5, 0.0, 1.0) for t in (0.5, 2.0))
        s = sum(sign * x**3 * (10.0 - 15.0 * x + 6.0 * x**2) for sign, x in ((1, up), (-1, down)))
        return np.stack([0.0 * s, 0.1 * s, 0.0 * s], axis=-1)

    def is_on_contour(self, time):
        return (np.asarray(time) >= 0.5) & (np.asarray(time) < 1.0)


def truth_of(error, acceleration):
    """Of a tool with that position error [m] and acceleration error [m/s^2], (M, 3) each."""
    wanted, h = Strokes().position_at, 1e-3
    programmed = (wanted(TIME + h) - 2.0 * wanted(TIME) + wanted(TIME - h)) / h**2
    R_tool = from_quaternion(TURNED)
    R_site, R_imu = (from_quaternion(np.array(q)) for q in ([0.6, 0, 0.8, 0], [0.8, 0.6, 0, 0]))
    force = programmed + acceleration + np.array([0.0, 0.0, 9.82])
    n, none = len(TIME), np.zeros((len(TIME), 1))
    return Truth(
        time=TIME,
        gear_angle=none,
        spring_angle=none,
        motor_torque=none,
        tool_position=wanted(TIME) + error,
        tool_quaternion=np.tile(TURNED, (n, 1)),
        imu_acceleration=force @ (R_tool @ R_site.T @ R_imu),
        imu_angular_velocity=np.zeros((n, 3)),
        qpos=none,
    )


def test_a_displaced_tool_has_its_distance_and_no_error_less_its_rest():
    off = np.tile([0.002, -0.001, 0.002], (len(TIME), 1))
    found = motion_error(Strokes(), truth_of(off, 0.0 * off), MODEL)
    for size in (found.tcp_rms, found.moving_tcp_rms, found.rest_tcp_rms, found.tcp_peak):
        assert size == pytest.approx(0.003)
    assert found.tcp_rms_less_rest < 1e-12
    assert found.acceleration_rms < 1e-9  # gravity is removed, whatever the mounting
    np.testing.assert_array_equal(found.settling, [0.0, 0.0])


def test_a_tool_that_rings_after_a_stop_settles_when_its_swing_is_below_the_bound():
    """1 mm at 10 Hz that decays by 4/s from the first stop on, along z."""
    w, since = 20.0 * np.pi, np.clip(TIME - 1.0, 0.0, None)
    ring = np.where(TIME < 2.0, 1e-3 * np.exp((1j * w - 4.0) * since), 0.0)
    bends = (1j * w - 4.0) ** 2 * ring * (TIME >= 1.0)
    error, acceleration = (np.outer(x.imag, [0.0, 0.0, 1.0]) for x in (ring, bends))
    found = motion_error(Strokes(), truth_of(error, acceleration), MODEL)
    # Its swing falls to 0.2 mm after ln(5) / 4 = 0.40 s: the last crossing is up to half a period
    # (0.05 s) before.
    assert 0.35 < found.settling[0] < 0.41
    assert found.settling[1] == 0.0
    mean_square = 0.5e-6 * (w**2 + 16.0) ** 2 * (1.0 - np.exp(-8.0)) / 8.0
    np.testing.assert_allclose(found.residual_vibration, [mean_square**0.5, 0.0], 0.01, atol=1e-9)
    # Two of the three seconds are programmed rests; the stroke has no error.
    assert found.rest_acceleration_rms == pytest.approx((mean_square / 2.0) ** 0.5, rel=0.01)
    assert found.acceleration_rms == pytest.approx((mean_square / 3.0) ** 0.5, rel=0.01)
    assert found.moving_acceleration_rms < 0.02  # but for the sample in which it stops


def test_an_error_on_the_contour_is_differentiated_there_alone():
    wave = 1e-3 * np.sin(20.0 * np.pi * TIME)
    error = np.outer(wave, [1.0, 0.0, 0.0])
    found = motion_error(Strokes(), truth_of(error, 0.0 * error), MODEL)
    # A cubic over 20 ms has 0.89 of a second derivative at 10 Hz.
    expected = 1e-3 * (20.0 * np.pi) ** 2 / 2**0.5
    assert 0.85 * expected < found.contour_acceleration_rms < expected
    assert found.tcp_rms == pytest.approx(1e-3 / 2**0.5, rel=0.01)


def test_no_acceleration_is_compared_where_the_orientation_is_free():
    zero = np.zeros((len(TIME), 3))
    found = motion_error(Strokes(), truth_of(zero, zero), MODEL, free_rotation=True)
    assert np.isnan(found.acceleration_rms)
    assert np.isnan(found.residual_vibration).all()
    assert found.tcp_rms < 1e-12


def test_measures_of_a_run_are_those_of_its_joint_angles():
    """Position of the site of the IMU by the joint angles, differentiated twice."""
    (it,) = learn(Cut(), iterations=0)
    experiment = prepare(Cut())
    truth, motion, mj = it.run.recording.truth, experiment.motion, experiment.loaded.model.mj
    data, places = mujoco.MjData(mj), np.empty((2, len(truth.time), 3))
    for i, qpos in enumerate(truth.qpos):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(mj, data)
        places[:, i] = data.site("tool0").xpos, data.site("imu").xpos
    found, off = it.motion_error, places[0] - motion.position_at(truth.time)
    assert found.tcp_rms == pytest.approx(_rms(off), rel=1e-3)
    still = off[truth.time < motion.rest_before].mean(axis=0)
    assert found.tcp_rms_less_rest == pytest.approx(_rms(off - still), rel=1e-3)
    bend = np.diff(places[1] - motion.position_at(truth.time), n=2, axis=0) / H**2
    # Truth at 1 kHz against 2 kHz; torque noise moves the tool by less than 1 % of it.
    assert found.acceleration_rms == pytest.approx(_rms(bend), rel=0.02)
    after = truth.time[1:-1] > motion.motion_end
    assert found.residual_vibration[-1] == pytest.approx(_rms(bend[after]), rel=0.03)


def _rms(vectors):
    return np.sqrt((vectors**2).sum(axis=1).mean())
