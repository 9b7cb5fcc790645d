"""Position of the tool by encoders, transmission error and IMU, smoothed without a tracker.

What the accelerometer sees beyond the transmission error is integrated twice in the frequency
domain, where it stands out from its own noise (a Wiener smoother of the same second moments):

    p(f) = -W(f) / (2 pi f)^2 a(f),   W = max(0, 1 - S_noise / S(f))

S is the smoothed power of a, S_noise its mean over 3 to 5.5 Hz, where the tool hardly vibrates.
"""

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..recordings.alignment.encoder_motion import RATE
from ..recordings.alignment.imu import GRAVITY
from .aligned import Aligned
from .observation import smoothed
from .transmission import Transmission

QUIET = (3.0, 5.5)
"""[Hz] Where the accelerometer's residual is its noise. Of the trial on the AUBO (docs/real.md)."""
BAND = (2.5, 16.0)
"""[Hz] That is integrated."""
SMOOTHED = 1.0
"""[Hz] Width over which the power is averaged. ESTIMATE."""
SHOCK = 8.0
"""Acceleration, in robust standard deviations, that is a shock or a dropout of the IMU."""
BLANKED = 0.3
"""[s] On either side of a shock that is not integrated."""
TAPER = 2.0
"""[s] Of the window at both ends."""


def fused(aligned: Aligned, found: Transmission) -> Array:
    """(M, 3) [m], error of the tool that the encoders do not see, base axes.

    Raises ValueError for a recording without IMU.
    """
    gear = found.tool_error(aligned.motion, aligned.target).sum(axis=2)
    return gear + vibration(aligned, found)


def vibration(aligned: Aligned, found: Transmission) -> Array:
    """(M, 3) [m], the part of it that is not transmission error."""
    from scipy.fft import irfft, rfft, rfftfreq

    if aligned.imu is None or aligned.recording.imu is None:
        raise ValueError(f"{aligned.name}: a smoother needs an IMU")
    motion = aligned.motion
    seen = aligned.imu.covered(motion, aligned.recording.imu)
    residual = aligned.imu.residual(motion, aligned.recording.imu)[:, :3]
    window = (_window(seen) * _undisturbed(residual))[:, None]
    a = rfft(window * residual, axis=0)
    f = np.asarray(rfftfreq(len(motion.time), 1.0 / RATE), dtype=np.float64)
    a = np.asarray(a) - _of_gears(aligned, found, window, f)
    inside = (f >= BAND[0]) & (f <= BAND[1])
    power = smoothed(np.abs(a) ** 2, int(SMOOTHED * len(motion.time) / RATE) // 2)
    noise = power[(f >= QUIET[0]) & (f <= QUIET[1])].mean(axis=0)
    W = np.clip(1.0 - noise / np.maximum(power, np.finfo(float).tiny), 0.0, 1.0)
    omega = 2.0 * np.pi * np.maximum(f, BAND[0])[:, None]
    return np.asarray(irfft(np.where(inside[:, None], -W / omega**2 * a, 0.0), len(seen), axis=0))


def _of_gears(aligned: Aligned, found: Transmission, window: Array, f: Array) -> Array:
    """Spectrum of what the transmission error adds to the accelerometer, base axes."""
    from scipy.fft import rfft

    assert aligned.imu is not None
    motion = aligned.motion
    moved = found.tool_error(motion, aligned.imu.lever).sum(axis=2)
    turned = np.einsum("mij,mj->mi", motion.J[:, 3:], found(motion.phi))
    spectrum = np.asarray(rfft(window * moved, axis=0))
    tilt = np.asarray(rfft(window * np.cross(turned, GRAVITY), axis=0))
    return tilt - (2.0 * np.pi * f[:, None]) ** 2 * spectrum


def _window(seen: NDArray[np.bool_]) -> Array:
    where = np.flatnonzero(seen)
    place = np.arange(len(seen))
    edge = np.minimum(place - where[0], where[-1] - place) / (TAPER * RATE)
    return np.sin(0.5 * np.pi * np.clip(edge, 0.0, 1.0)) ** 2


def _undisturbed(residual: Array) -> Array:
    """Window (M,) that fades to zero around shocks."""
    off = np.abs(residual - np.median(residual, axis=0))
    shock = (off > SHOCK * 1.4826 * np.median(off, axis=0)).any(axis=1)
    width = int(BLANKED * RATE)
    near = np.convolve(shock, np.ones(4 * width + 1), "same") > 0.0
    fade = np.hanning(2 * width + 1)
    return 1.0 - np.convolve(near, fade / fade.sum(), "same")
