"""Residual of one recording in a band, and what an error of a joint would add to it, as spectra.

A joint's error e(t) moves a point at the tool by J e and turns the tool by z e. Of that an
accelerometer sees d^2(J e)/dt^2 + (z e) x g and a gyro d(z e)/dt, both in base axes; a tracker sees
J e. Derivatives are exact in the frequency domain. Each channel is divided by the smoothed
amplitude of its own residual, so that each frequency counts by its noise: that of the final fit is
what a first one leaves.

An elastic arm follows more than it is asked for as its first resonance comes near: an error of
joint j arrives at the tool 1 / (1 - softness_j f^2) times as large.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..recordings.alignment.imu_alignment import GRAVITY

Spectrum = NDArray[Any]
"""Complex, frequency first."""
Single = NDArray[np.float32]
TAPER = 2.0
"""[s] Of the window at both ends."""
_GRAVITY_CROSS = np.cross(np.eye(3), GRAVITY).T.astype(np.float32)
SMOOTHED = 0.3
"""[Hz] Width over which the noise's amplitude is averaged."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Observation:
    """Residual of a stretch of a recording, M even samples, and the motion of its sensor."""

    phi: Array
    rate: Array
    """(M, n) [rad] and [rad/s]."""
    J_point: Array
    J_rotation: Array
    """(M, 3, n), of the measured point and of the tool's rotation, base axes."""
    residual: Array
    """(M, 6) of an IMU [m/s^2, rad/s] or (M, 3) of a tracker [m], base axes."""
    band: tuple[float, float]
    """[Hz]."""
    sampling: float
    """[Hz], of the samples."""
    softness: Array | None = None
    """(n,) [s^2], 1 / f_j^2 of each joint's first resonance; None for a rigid arm."""
    explained: Spectrum | None = None
    """(B, c) complex, part of the residual's spectrum that is no noise, as far as it is known."""

    @cached_property
    def target(self) -> Spectrum:
        """(B, c) complex, weighted spectrum of the residual in the band."""
        return self._spectrum_of_residual / self._weight

    def columns(self, joint: int, order: float) -> Spectrum:
        """(B, c, 2) complex, weighted spectra of the errors sin and cos(order phi) of a joint."""
        return self._columns(joint, self._factor(joint, order))

    def order_slope(self, joint: int, order: float, coefficients: Array) -> Spectrum:
        """(B, c) complex, derivative by the order of the columns times coefficients (2,)."""
        angle = self.phi[self._rows, joint].astype(np.float32)
        turned = self._columns(joint, self._factor(joint, order) * angle)
        return turned @ np.array([-coefficients[1], coefficients[0]])

    def softness_slope(self, joint: int, seen: Spectrum) -> Spectrum:
        """(B, c) complex, derivative by the softness of what a joint's terms add (B, c)."""
        f = self._omega / (2.0 * np.pi)
        return (f**2 * self._gain(joint))[:, None] * seen

    def _columns(self, joint: int, factor: Spectrum) -> Spectrum:
        from scipy.fft import fft

        whole: Any = fft(factor * self._jacobians[joint], axis=1, overwrite_x=True)
        bins = self._bins
        positive, negative = whole[:, bins], np.conj(whole[:, -bins])
        pair = np.stack([(positive - negative) / 2j, (positive + negative) / 2.0], axis=2)
        weight = self._weight / self._gain(joint)[:, None]
        return self._sensed(pair.transpose(1, 0, 2)) / weight[:, :, None]

    def _gain(self, joint: int) -> Single:
        """(B,), amplification by the structure."""
        if self.softness is None:
            return np.ones_like(self._omega)
        f = self._omega / (2.0 * np.pi)
        return (1.0 / (1.0 - self.softness[joint] * f**2)).astype(np.float32)

    def _factor(self, joint: int, order: float) -> Spectrum:
        """exp(i order phi) where it is slow enough not to be folded into the band, else zero."""
        angle = (order * self.phi[self._rows, joint]).astype(np.float32)
        fastest = 2.0 * np.pi * (0.95 * self.sampling - self.band[1])
        slow = np.abs(order * self.rate[self._rows, joint]) < fastest
        out = np.empty(len(angle), dtype=np.complex64)
        out.real, out.imag = np.cos(angle) * slow, np.sin(angle) * slow
        return out

    def _sensed(self, moved: Spectrum) -> Spectrum:
        if self.residual.shape[1] == 3:
            return moved[:, :3]
        omega, turned = self._omega[:, None, None], moved[:, 3:]
        force = _GRAVITY_CROSS @ turned - omega**2 * moved[:, :3]
        return np.concatenate([force, 1j * omega * turned], axis=1)

    @cached_property
    def _rows(self) -> slice:
        """Even samples whose number the transform likes."""
        from scipy.fft import next_fast_len

        n = len(self.phi)
        while next_fast_len(n, real=True) != n:
            n -= 1
        return slice(0, n)

    @cached_property
    def _jacobians(self) -> Single:
        """(n, 6, M) single precision, windowed."""
        both = np.concatenate([self.J_point, self.J_rotation], axis=1)[self._rows]
        return (both * self._window[:, None, None]).transpose(2, 1, 0).astype(np.float32)

    @cached_property
    def _window(self) -> Array:
        n = len(self.phi[self._rows])
        return tapered(n, 0, n - 1, self.sampling)

    @cached_property
    def _bins(self) -> NDArray[np.intp]:
        from scipy.fft import rfftfreq

        f: Any = rfftfreq(len(self._window), 1.0 / self.sampling)
        return np.flatnonzero((f >= self.band[0]) & (f <= self.band[1]))

    @cached_property
    def _omega(self) -> Single:
        omega = 2.0 * np.pi * self.sampling / len(self._window) * self._bins
        return omega.astype(np.float32)

    @cached_property
    def _spectrum_of_residual(self) -> Spectrum:
        from scipy.fft import rfft

        whole: Any = rfft(self._window[:, None] * self.residual[self._rows], axis=0)
        return whole[self._bins]

    @cached_property
    def _weight(self) -> Single:
        """(B, c), smoothed amplitude of the noise."""
        known = 0.0 if self.explained is None else self.explained
        power = np.abs(self._spectrum_of_residual - known) ** 2
        half = int(0.5 * SMOOTHED / self.sampling * len(self._window))
        return np.sqrt(smoothed(power, half)).astype(np.float32)

    def reweighted(self, weighted: Spectrum) -> "Observation":
        """The same with its noise taken from what a model (B, c), weighted, leaves of it: signal
        and noise together as weights make every amplitude too small."""
        return replace(self, explained=weighted * self._weight)

    def in_time(self, spectrum: Spectrum) -> Array:
        """(M', c, ...) real, the signal of a weighted spectrum in the band."""
        from scipy.fft import irfft

        whole = np.zeros((len(self._window) // 2 + 1, *spectrum.shape[1:]), dtype=complex)
        whole[self._bins] = spectrum
        out: Any = irfft(whole, len(self._window), axis=0)
        return out


def tapered(n: int, first: int, last: int, rate: float) -> Array:
    """Window (n,) of samples at a rate [Hz], zero up to `first` and from `last` on."""
    place = np.arange(n)
    edge = np.minimum(place - first, last - place) / (TAPER * rate)
    return np.sin(0.5 * np.pi * np.clip(edge, 0.0, 1.0)) ** 2


def smoothed(power: Array, half: int) -> Array:
    """Moving mean of the columns of a power (F, c) over 2 half + 1 lines, mirrored at the ends."""
    half = max(1, half)
    padded = np.pad(power, ((half, half), (0, 0)), mode="reflect")
    kernel = np.full(2 * half + 1, 1.0 / (2 * half + 1))
    return np.column_stack([np.convolve(column, kernel, "valid") for column in padded.T])


def as_real(spectrum: Spectrum) -> NDArray[Any]:
    """Rows of real and imaginary parts, (2 B c, ...), of a spectrum (B, c, ...)."""
    flat: Any = spectrum.reshape(-1, *spectrum.shape[2:])
    return np.concatenate([flat.real, flat.imag])
