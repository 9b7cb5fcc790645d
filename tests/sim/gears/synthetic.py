"""Synthetic recordings of a three-joint arm whose gears have a known transmission error."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from armside.kinematics import Arm, Limits, Link, Robot, compile
from armside.sim.recordings import MotionRecording, Stream

ARM = Arm(
    Robot((Link(d=0.3, alpha=np.pi / 2), Link(a=0.5), Link(a=0.4)), name="three joints"),
    Limits(lower=(-3.0,) * 3, upper=(3.0,) * 3, speed=(3.0,) * 3),
)
ORDERS, AMPLITUDE, PHASE = (120.0, 100.0, 160.0), (120e-6, 100e-6, 90e-6), (0.5, 2.0, 4.0)
"""Of joints 1 to 3: output minus motor angle."""
DURATION, STEP = 40.0, 1e-3
GRAVITY = np.array([0.0, 0.0, -9.81])
LEVER, TARGET = np.array([0.03, 0.05, 0.02]), np.array([-0.05, 0.04, 0.0])
MOUNTING = Rotation.from_rotvec(np.radians([3.0, -1.5, 178.7])).as_matrix()
R_TRACKER = Rotation.from_rotvec([1.2, 0.4, -0.3]).as_matrix()


@dataclass(frozen=True)
class Scene:
    """Clocks and noise of one recording."""

    seed: int
    imu_offset: float = 0.1
    imu_rate: float = 0.0
    accelerometer_late: float = 0.0
    """[s] Delay of the accelerometer beyond that of the gyro."""
    tracker_offset: float = -3.0
    tracker_rate: float = 30e-6
    gear: float = 1.0
    """Factor on the transmission error."""
    shake: float = 0.0
    """[m] Vibration of the tool along the vertical, 8 Hz, that no motor makes."""
    held: int | None = None
    """Motor that does not move."""
    tilt: tuple[float, float] = (0.0, 0.0)
    """[rad] Of gravity in the axes of the base, towards x and y."""


def angles(rng, t):
    """Smooth motion of the motors (N, 3) [rad] at the times t."""
    out = np.zeros((len(t), 3))
    for joint in range(3):
        for _ in range(4):
            f, a = rng.uniform(0.1, 0.3), rng.uniform(0.15, 0.3)
            out[:, joint] += a * np.sin(2 * np.pi * f * t + rng.uniform(0, 6.0))
    return out + np.array([0.0, 0.8, -1.0])


def recording(scene):
    """Encoders, IMU and tracker of one scene."""
    rng, robot = np.random.default_rng(scene.seed), compile(ARM.robot)
    t = np.arange(0.0, DURATION, STEP)
    phi = angles(rng, t)
    if scene.held is not None:
        phi[:, scene.held] = phi[0, scene.held]
    error = scene.gear * np.array(AMPLITUDE) * np.sin(np.array(ORDERS) * phi + PHASE)
    output = CubicSpline(t, phi + error)
    q, rate, second = output(t), output(t, 1), output(t, 2)
    T, a = robot.pose(q), robot.acceleration(q, rate, second)
    burst = CubicSpline(t, scene.shake * np.sin(16.0 * np.pi * t) * np.sin(0.7 * t) ** 2)
    T[:, 2, 3] += burst(t)
    a[:, 2] += burst(t, 2)
    R, omega = T[:, :3, :3], np.einsum("nij,nj->ni", robot.jacobian(q), rate)[:, 3:]
    r = R @ LEVER
    turning = np.cross(a[:, 3:], r) + np.cross(omega, np.cross(omega, r))
    gravity = GRAVITY + 9.81 * np.array([*scene.tilt, 0.0])
    force = np.einsum("nji,nj->ni", R, a[:, :3] + turning - gravity) @ (1.01 * MOUNTING).T
    gyro = np.einsum("nji,nj->ni", R, omega) @ (1.02 * MOUNTING).T
    imu_time = t + scene.imu_offset + scene.imu_rate * (t - 0.5 * DURATION)
    t_imu = np.arange(1.0, DURATION - 1.0, 1 / 113.0)
    late = scene.accelerometer_late
    ideal = np.hstack(
        [CubicSpline(imu_time + late, force)(t_imu), CubicSpline(imu_time, gyro)(t_imu)]
    )
    noise = rng.normal(size=(len(t_imu), 6)) * np.repeat([0.03, 2e-3], 3)
    t_encoder = np.sort(t[::9] + rng.uniform(-2e-3, 2e-3, len(t[::9])))[2:-2]
    own = (t + scene.tracker_offset) * (1.0 + scene.tracker_rate)
    points = CubicSpline(own, (T[:, :3, 3] + R @ TARGET) @ R_TRACKER.T + [0.3, -1.0, 2.0])
    t_tracker = np.arange(own[0] + 0.5, own[-1] - 0.5, 0.005)
    seen = points(t_tracker) + rng.normal(0.0, 5e-6, (len(t_tracker), 3))
    return MotionRecording(
        name=f"scene {scene.seed}",
        encoders=Stream(t_encoder, CubicSpline(t, phi)(t_encoder)),
        imu=Stream(t_imu, ideal + noise),
        tracker=Stream(t_tracker, seen),
        form="synthetic",
    )
