"""Laser tracker: polar readings of a reflector at the tool, in the tracker's own frame.

Ideal distance and two angles -> set-up error -> noise -> quantisation -> Cartesian -> base axes by
best-fit registration on reference targets. The beam is lost where the reflector points too far away
from the tracker; lost samples are NaN and marked, never interpolated.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array, freeze_rows

from ..notes import Cause, Note
from . import noise
from .noise import rate_of, stride

ARCSEC = np.pi / 180.0 / 3600.0
"""[rad]."""


@dataclass(frozen=True, kw_only=True)
class LaserTrackerCfg:
    """Tracker of the Leica LTD500 kind; unmarked figures are of its data sheet, from memory."""

    position: tuple[float, float, float] = (4.6, -2.4, 1.2)
    """[m], base axes: about 4 m from the poses of thesis (9.3), in front of the robot. ESTIMATE."""
    heading: float = 2.5
    """Rotation of the tracker's frame about the vertical, unknown before registration [rad]."""
    rate: float = 1000.0
    """[Hz]; must divide the physics rate."""
    range_noise: float = 5e-6
    angle_noise: float = 1.25e-6
    """White, one standard deviation [m] and [rad]. ESTIMATES: 5 um a coordinate at 4 m."""
    range_scale_error: float = 5e-6
    """One standard deviation of the scale error of a set-up: half of 10 ppm (2 sigma)."""
    angle_bias: float = 5e-6
    """One standard deviation of the bias of each angle in a set-up [rad]. ESTIMATE."""
    range_resolution: float = 1.26e-6
    """[m], interferometer."""
    angle_resolution: float = 0.14 * ARCSEC
    """[rad]."""
    acceptance_angle: float = np.deg2rad(30.0)
    """Half angle of the cone in which a corner cube returns the beam [rad]. ESTIMATE."""
    target_offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Centre of the reflector in tool axes, from TCP0 [m]."""
    reference_targets: tuple[tuple[float, float, float], ...] = (
        (0.6, -1.4, 0.3),
        (0.6, 1.6, 0.4),
        (1.0, -1.0, 2.4),
        (1.2, 1.4, 2.2),
        (2.6, -0.8, 0.3),
        (2.4, 1.0, 0.6),
        (2.8, 0.4, 2.3),
        (1.8, 0.2, 1.2),
    )
    """Known points of the cell [m], base axes, around the poses. ESTIMATE."""
    readings_per_target: int = 1000

    def __post_init__(self) -> None:
        if self.rate <= 0.0:
            raise ValueError(f"tracker rate must be > 0 Hz, got {self.rate}")
        errors = ("noise", "resolution", "scale_error", "bias")
        for name in (f.name for f in fields(self) if f.name.endswith(errors)):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must be >= 0, got {getattr(self, name)}")
        if not 0.0 < self.acceptance_angle <= np.pi:
            raise ValueError(f"acceptance_angle must be in (0, pi], got {self.acceptance_angle}")
        if self.readings_per_target < 1:
            raise ValueError(f"readings_per_target must be >= 1, got {self.readings_per_target}")


@dataclass(frozen=True, kw_only=True)
class TrackerSamples:
    """Tracker samples of one run."""

    time: Array
    """(K,) [s]."""
    position: Array
    """(K, 3) [m], tool centre point in base axes after registration; NaN where the beam is lost."""
    valid: NDArray[np.bool_]
    """(K,), False where the beam is lost."""

    def __post_init__(self) -> None:
        freeze_rows(self, "time", "position", "valid")


@dataclass(frozen=True, kw_only=True)
class Registration:
    """Tracker frame to base frame: p_base = R_base_tracker @ p_tracker + p_base_tracker."""

    R_base_tracker: Array
    p_base_tracker: Array
    residual: float
    """Root mean square distance of a coordinate from its target after the fit [m]."""

    def to_base(self, p_tracker: Array) -> Array:
        """Points (..., 3) in base axes [m]."""
        return p_tracker @ self.R_base_tracker.T + self.p_base_tracker


def best_fit(p_tracker: ArrayLike, p_base: ArrayLike) -> Registration:
    """Rigid motion that fits points (M, 3) to their targets, least squares (Kabsch). Raises
    ValueError for fewer than three points, or all on one line."""
    a, b = np.asarray(p_tracker, dtype=np.float64), np.asarray(p_base, dtype=np.float64)
    if a.shape != b.shape or a.ndim != 2 or a.shape[1] != 3:
        raise ValueError(f"points must both have shape (M, 3), got {a.shape} and {b.shape}")
    centre_a, centre_b = a.mean(axis=0), b.mean(axis=0)
    U, size, Vt = np.linalg.svd((b - centre_b).T @ (a - centre_a))
    if len(a) < 3 or size[1] < 1e-9 * max(size[0], 1e-300):
        raise ValueError("registration needs three reference targets that are not on one line")
    R = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
    p = centre_b - R @ centre_a
    residual = np.sqrt(np.mean((a @ R.T + p - b) ** 2))
    return Registration(R_base_tracker=R, p_base_tracker=p, residual=float(residual))


@dataclass(frozen=True, kw_only=True)
class LaserTracker:
    """Tracker in place and registered; see `set_up`."""

    cfg: LaserTrackerCfg
    bias: Array
    """(3,): relative error of the distance, biases of azimuth and elevation [rad]."""
    registration: Registration

    def read(self, p_base: Array, rng: np.random.Generator) -> Array:
        """Noisy readings (..., 3) [m] of points in base axes, in the tracker's own frame."""

        def reading(ideal: Array, std: float, resolution: float) -> Array:
            noisy = ideal + noise.white(rng, ideal.shape, std)
            return np.rint(noisy / resolution) * resolution if resolution > 0.0 else noisy

        cfg, bias = self.cfg, self.bias
        c, s = np.cos(cfg.heading), np.sin(cfg.heading)
        R_base_tracker = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        x, y, z = np.moveaxis((p_base - np.array(cfg.position)) @ R_base_tracker, -1, 0)
        level = np.hypot(x, y)
        r = reading(np.hypot(level, z) * (1.0 + bias[0]), cfg.range_noise, cfg.range_resolution)
        azimuth = reading(np.arctan2(y, x) + bias[1], cfg.angle_noise, cfg.angle_resolution)
        elevation = reading(np.arctan2(z, level) + bias[2], cfg.angle_noise, cfg.angle_resolution)
        level, height = r * np.cos(elevation), r * np.sin(elevation)
        return np.stack([level * np.cos(azimuth), level * np.sin(azimuth), height], -1)

    def measure(
        self,
        time: Array,
        tool_position: Array,
        tool_quaternion: Array,
        rng: np.random.Generator,
    ) -> TrackerSamples:
        """Samples of a tool, (M, 3) [m] and (M, 4), base axes, during a run.

        time: (M,) [s], uniform, at a rate that is a multiple of the tracker's. The reflector points
        at the tracker at the first sample. Its offset is subtracted with the orientation of that
        sample, which is the programmed one: the tracker does not measure the tilt of the tool.
        """
        every = stride(rate_of(time), self.cfg.rate)
        time, tool_position = time[::every].copy(), tool_position[::every]
        q = tool_quaternion[::every]
        reflector = tool_position + _rotated(q, np.array(self.cfg.target_offset, dtype=np.float64))
        beam = np.array(self.cfg.position) - reflector
        sight = _rotated(q, _rotated(q[0] * [1.0, -1.0, -1.0, -1.0], beam[0]))
        size = np.linalg.norm(sight, axis=1) * np.linalg.norm(beam, axis=1)
        cosine, least = (sight * beam).sum(axis=1) / size, np.cos(self.cfg.acceptance_angle) - 1e-12
        # Once the reflector has left the cone the beam stays lost: an interferometer counts.
        valid = np.logical_and.accumulate(cosine >= least)  # false for NaN too
        position = self.registration.to_base(self.read(reflector, rng))
        position -= reflector[0] - tool_position[0]
        position[~valid] = np.nan
        return TrackerSamples(time=time, position=position, valid=valid)


def set_up(cfg: LaserTrackerCfg, rng: np.random.Generator) -> LaserTracker:
    """Tracker with the constant errors of a set-up, registered on its targets."""
    bias = noise.white(rng, (3,), [cfg.range_scale_error, cfg.angle_bias, cfg.angle_bias])
    targets = np.repeat(np.array(cfg.reference_targets), cfg.readings_per_target, axis=0)
    unknown = Registration(R_base_tracker=np.eye(3), p_base_tracker=np.zeros(3), residual=0.0)
    tracker = LaserTracker(cfg=cfg, bias=bias, registration=unknown)
    return replace(tracker, registration=best_fit(tracker.read(targets, rng), targets))


def _rotated(q: Array, v: Array) -> Array:
    """Vectors (..., 3) rotated by quaternions (..., 4) of any length."""
    w, r = q[..., :1], q[..., 1:]
    twice = 2.0 / (q * q).sum(axis=-1, keepdims=True)
    return v + twice * np.cross(r, w * v + np.cross(r, v))


def beam(samples: TrackerSamples) -> Iterator[Note]:
    """A note where the beam was lost."""
    if not samples.valid.all():
        lost = "the laser tracker lost its beam: no error of the tool is known"
        yield Note(cause=Cause.BEAM, text=lost)
