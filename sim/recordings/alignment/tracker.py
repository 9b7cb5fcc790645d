"""Alignment of a tracker or of cameras with the encoders: clock, base and tool of one recording.

Only the motion below 2 Hz is used, with the nominal robot. Nothing of it depends on a gear's error.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares

from armside.arrays import Array
from armside.kinematics.calibration.measurements import procrustes

from ..recorded_motion import Stream
from .encoder_motion import RATE, EncoderMotion, coarse_lag, even, lowpass, sampled

SLOW = 2.0
"""[Hz] Band of the fit."""
STRIDE = 10
"""Samples of the grid for one of the fit."""
MARGIN = 1.0
"""[s] At both ends."""
ROBUST = 1e-3
"""[m] Residual at which the loss turns from square to linear; a nominal robot is off by as much."""
MISFIT = 0.02
"""Residual, relative to the spread of the points, that no error of a robot explains."""
SHARP = 40.0
"""[Hz] Low-pass of the tracker before it is put on the grid."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TrackerAlignment:
    """Constants of one recording that take points of its tracker to base axes."""

    offset: float
    """[s], the tracker's clock minus the encoders' in the middle of the recording."""
    rate: float
    """Rate of the tracker's clock less that of the encoders, relative."""
    R: Array
    p: Array
    """(3, 3) and (3,) [m]: p_tracker = R p_base + p."""
    target: Array
    """(3,) [m], the measured point in the tool frame."""
    rms: float
    """[m], residual of the fit, which is the nominal robot's."""

    def clock(self, motion: EncoderMotion) -> Array:
        """(M,) [s], times of the tracker's clock at the samples of the motion."""
        return motion.time + self.offset + self.rate * (motion.time - motion.time.mean())

    def residual(self, motion: EncoderMotion, tracker: Stream) -> Array:
        """(M, 3) [m], measured less encoders' position of the target, base axes."""
        own = 1.0 / float(np.median(np.diff(tracker.time)))
        time, points = even(tracker.time, tracker.values, 1.0 / own)
        points = sampled(time, lowpass(points, SHARP, own), self.clock(motion))
        return (points - self.p) @ self.R - motion.T[:, :3, 3] - motion.lever(self.target)

    def covered(self, motion: EncoderMotion, tracker: Stream) -> NDArray[np.bool_]:
        """(M,) bool, samples of the motion that the tracker saw."""
        t = self.clock(motion)
        return (t > tracker.time[0] + MARGIN / 2) & (t < tracker.time[-1] - MARGIN / 2)


def align_tracker(
    motion: EncoderMotion, tracker: Stream, fraction: float = 1.0
) -> TrackerAlignment:
    """Alignment by robust least squares on a fraction of the recording, from its start.

    Raises ValueError for a tracker that did not see this motion, or a wrong unit.
    """
    time, seen = even(tracker.time, tracker.values)
    slow = lowpass(seen, SLOW)
    reach = np.linalg.norm(motion.T[:, :3, 3].std(axis=0))
    if (ratio := np.linalg.norm(slow.std(axis=0)) / max(float(reach), 1e-9)) > 100.0:
        text = f"points spread {ratio:.3g} times as far as the robot moves"
        raise ValueError(f"tracker: {text}: are they in millimetres?")
    points = CubicSpline(time, slow)
    own, speed = (np.linalg.norm(v, axis=1) for v in (points(time, 1), motion.velocity[:, :3]))
    margin, last = int(MARGIN * RATE), int(fraction * len(motion.time))
    start = coarse_lag("tracker", (time, own), (motion.time[:last], lowpass(speed, SLOW)[:last]))
    rows = np.arange(margin, last - margin, STRIDE)
    T = lowpass(motion.T.reshape(-1, 16), SLOW)[rows].reshape(-1, 4, 4)
    t, middle = motion.time[rows], motion.time.mean()

    def fitted(x: Array) -> tuple[Array, Array, Array]:
        at = t + x[0] + x[1] * (t - middle)
        inside = (at > time[0] + MARGIN) & (at < time[-1] - MARGIN)
        if inside.sum() < len(t) / 4:
            return np.eye(3), np.zeros(3), np.full((len(t), 3), 1.0)
        own, seen = T[inside, :3, 3] + T[inside, :3, :3] @ x[2:], points(at[inside])
        R, p = procrustes(own, seen)
        residual = np.zeros((len(t), 3))
        residual[inside] = seen - own @ R.T - p
        return R, p, residual

    x = least_squares(
        lambda x: fitted(x)[2].ravel(),
        np.array([start, 0.0, 0.0, 0.0, 0.0]),
        x_scale=np.array([1e-2, 1e-4, 0.1, 0.1, 0.1]),
        loss="soft_l1",
        f_scale=ROBUST,
    ).x
    R, p, residual = fitted(x)
    rms = float(np.sqrt(3.0 * np.median(residual**2)))
    spread = float(np.linalg.norm(slow - slow.mean(axis=0), axis=1).mean())
    if rms > MISFIT * spread:
        text = f"{1e3 * rms:.3g} mm remain of a motion of {1e3 * spread:.3g} mm"
        raise ValueError(f"tracker does not fit the robot: {text}")
    return TrackerAlignment(offset=float(x[0]), rate=float(x[1]), R=R, p=p, target=x[2:], rms=rms)
