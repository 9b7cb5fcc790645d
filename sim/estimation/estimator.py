"""The tool's path from motor angles and IMU: deflection of the identified arm, and a deviation.

What the IMU adds to what motor angles and springs explain is small, so it is estimated as a linear
deviation by a filter and smoother on a schedule: gains of the places along the first run, computed
once for all runs of a reference.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import mujoco
import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.scheduled import ScheduledSmoother

from ..instruments.imu import ImuCfg, ImuSamples
from .arm_filter import ArmFilter
from .deflection import Deflection, deflection, explained, residual
from .elasticity import ArmParameters
from .identification import filter_at
from .nominal import NominalArm
from .relative_path import REST_SAMPLES, relative_to_start
from .rigid_motion import RigidMotion, rigid_motion, segments

PLACE = 0.12
"""Change of a motor angle within which one filter serves [rad]."""


@dataclass(frozen=True, eq=False)
class ToolEstimate:
    """The tool as estimated, at the instants of the motor log."""

    displacement: Array
    """(N, 6): displacement [m] and rotation vector [rad] from rest, base axes."""
    shift: Array
    """(N, 3) [m], what the IMU adds to the path that motors and springs explain."""
    innovation: Array
    """(K, 6), whitened innovations; NaN where no reading was used. K is 0 without an IMU."""
    instants: Array
    """(K,) [s] of the innovations."""


@dataclass(frozen=True, eq=False)
class ToolEstimator:
    """Estimates the tool of one robot along one reference."""

    arm: NominalArm
    parameters: ArmParameters
    imu: ImuCfg
    along: RigidMotion
    """Of the first run: filters are those of its places."""

    @cached_property
    def models(self) -> tuple[ArmFilter, ...]:
        """Filters along the reference, from the first place to the last."""
        known = self.along, self.parameters, self.imu
        chosen = [np.flatnonzero(self.place == s)[0] for s in range(self.place[-1] + 1)]
        return tuple(filter_at(*known, int(self.along.segment[at])) for at in chosen)

    @cached_property
    def place(self) -> np.ndarray:
        """(N,) index of the filter at each sample of the log."""
        return segments(self.along.phi, PLACE)

    @cached_property
    def filter_covariance(self) -> Array:
        """(S, 3, 3) [m^2] of the displacement at each place, if the springs are right."""
        known = self.smoother(np.zeros(0)).smoothed_covariance
        tools = np.array([model.tool[:3] for model in self.models])
        return tools @ known @ np.swapaxes(tools, 1, 2)

    def of_model(self) -> "ToolEstimator":
        """The estimator of a model's runs, whose IMU has no clock and no mounting of its own."""
        own = replace(self.parameters, clock_offset=0.0, mounting=np.zeros(3))
        return replace(self, parameters=own)

    def smoother(self, instants: Array) -> ScheduledSmoother:
        """For readings at instants of robot time [s]."""
        time = self.along.time
        at = np.clip(np.searchsorted(time, instants), 0, len(time) - 1)
        processes = [model.sampled(1.0 / self.imu.rate) for model in self.models]
        return ScheduledSmoother(processes, self.place[at])

    @cached_property
    def _smoothers(self) -> dict[bytes, ScheduledSmoother]:
        return {}

    def __call__(self, time: Array, motor_angle: Array, samples: ImuSamples | None) -> ToolEstimate:
        """The tool in one run: log (N,), (N, a) and IMU samples, None without an IMU."""
        from scipy.interpolate import CubicSpline

        motion = rigid_motion(self.arm, time, motor_angle)
        bent = deflection(motion, self.parameters.springs)
        path = tool_path(motion, bent)
        if samples is None:
            return ToolEstimate(path, np.zeros_like(path[:, :3]), np.empty((0, 6)), np.empty(0))
        own = self.parameters
        known = explained(motion, bent, self.imu)
        left, bias = residual(samples, known, own.clock_offset, own.mounting)
        instants = samples.time + own.clock_offset
        key = instants.tobytes()
        if (smoother := self._smoothers.get(key)) is None:
            smoother = self._smoothers[key] = self.smoother(instants)
        start = np.zeros(len(self.models[0].A))
        start[-6:] = bias
        states = smoother(left, start)
        tools = np.array([model.tool for model in self.models])
        deviation = np.einsum("nij,nj->ni", tools[smoother.schedule], states.smoothed)
        shift = CubicSpline(instants, deviation)(np.clip(time, instants[0], instants[-1]))
        shift -= shift[:REST_SAMPLES].mean(axis=0)
        return ToolEstimate(path + shift, shift[:, :3], states.innovation, instants)


def tool_path(motion: RigidMotion, bent: Deflection) -> Array:
    """(N, 6): displacement and rotation vector of the tool from rest."""
    free = motion.arm.motion
    data, site = free.data(), free.mj.site("tool0").id
    position, quaternion = np.empty((len(motion.phi), 3)), np.empty((len(motion.phi), 4))
    q = bent.angle.copy()
    q[:, motion.arm.axes] += motion.phi
    for i, angles in enumerate(q):
        free.place(data, angles)
        mujoco.mj_kinematics(free.mj, data)
        position[i] = data.site_xpos[site]
        mujoco.mju_mat2Quat(quaternion[i], data.site_xmat[site])
    return relative_to_start(position, quaternion)


WINDOW = 1.0
"""[s], of the record that is judged as one: a hundred readings."""
SHORT = 4.0
"""Length of a run [s] up to which it is short: a window is half of it, and what the model lacks has
no time to grow. ESTIMATE: contours of 8 to 40 mm take 2 to 3 s, long paths from 5 s on."""


class Limits(NamedTuple):
    """Beyond which an estimate is not valid."""

    innovation: float
    """RMS of whitened innovations in a window."""
    shift: float
    """Distance [m] by which an IMU moves the path that motors and springs explain."""


OF_LONG = Limits(5.0, 0.5e-3)
"""Sound runs have 1 to 3, the largest at corners. Where a gear without load moves within its lost
motion as no model foresees, there are more, and learned from they grow. ESTIMATE"""
OF_SHORT = Limits(30.0, 2e-3)
"""Here the smoother mends that: sound runs have up to 19 and 1.1 mm. A knock of 5 m/s^2 for 40 ms
has 52, one of 50 m/s^2 4 mm. Seeds from 100 on. ESTIMATE"""
FADE = 0.1
"""[s], over which validity is lost before such a window and gained after it."""


@dataclass(frozen=True, eq=False)
class Validity:
    """Validity of one estimate."""

    weight: Array
    """(N,) in [0, 1]."""
    text: str
    """Where it is not valid; empty where it is everywhere."""


def validity(estimate: ToolEstimate, time: Array) -> Validity:
    """Of an estimate at the instants (N,) of the motor log."""
    limits = OF_SHORT if time[-1] < SHORT else OF_LONG
    window = (time / WINDOW).astype(int)
    good = np.ones(window[-1] + 1, dtype=bool)
    for at in range(len(good)):
        innovation = estimate.innovation[(estimate.instants / WINDOW).astype(int) == at]
        known = np.isfinite(innovation).all(axis=1)
        if known.any():
            good[at] = np.sqrt(np.square(innovation[known]).mean(axis=0)).max() < limits.innovation
        shift = np.linalg.norm(estimate.shift[window == at], axis=1)
        good[at] &= bool((shift < limits.shift).all())
    samples = round(FADE / float(time[1] - time[0]))

    def nearby(values: Array) -> Array:
        padded = np.pad(values, samples, mode="edge")
        return np.lib.stride_tricks.sliding_window_view(padded, 2 * samples + 1)

    weight = good[window].astype(float)
    weight = nearby(nearby(weight).min(axis=1)).mean(axis=1)  # the smallest nearby, smoothed
    if good.all():
        return Validity(weight, "")
    places = ", ".join(f"{WINDOW * at:g}" for at in np.flatnonzero(~good))
    seconds = "second that begins" if (~good).sum() == 1 else "seconds that begin"
    said = f"the estimate is not valid, and nothing learned, in the {seconds} at {places} s"
    return Validity(weight, said)
