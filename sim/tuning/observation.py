"""Observation of the env: signals of a robot cell after a run, as in the table of
`armside.sim.tuning.env.IlcTuningEnv`. The tool's true position is no part of it.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from armside.arrays import Array
from armside.ilc.measures.norms import two_norm

from ..robot.virtual_robot import LOG_PERIOD
from .action import SIX, CorrectionBasis
from .episode_task import LARGEST, SMALLEST, Shapes
from .situation import Situation


@dataclass(frozen=True)
class Feature:
    """Some entries of the observation and the range that [-1, 1] stands for."""

    name: str
    size: int
    unit: str
    low: float
    high: float
    logarithmic: bool = True


BANDS = ((0.0, 3.0), (3.0, 8.0), (8.0, 16.0), (16.0, 125.0))
"""[Hz]"""
HEAVIEST = 120.0
"""[kg], of payloads that version 1 draws; 0 stands for a tool of the robot's own."""


@dataclass(frozen=True)
class Layout:
    """Features of a robot with so many axes, of its contours where they are drawn, and of a basis
    of corrections."""

    n_axes: int = SIX
    shapes: Shapes = field(default_factory=Shapes)
    basis: CorrectionBasis | None = None
    """Functions of the actions, where these are corrections."""
    payload: bool = False
    """The payload is observed too."""

    @cached_property
    def features(self) -> tuple[Feature, ...]:
        """In their order."""
        n, turn = self.n_axes, 6.2832
        every = (
            Feature("motor error, 2-norm over the record", n, "rad", 1e-3, 1e2),
            Feature("motor error, infinity-norm", n, "rad", 1e-4, 1e1),
            *(
                Feature(f"motor error, RMS in {low:g}-{high:g} Hz", n, "rad", 1e-6, 1e1)
                for low, high in BANDS
            ),
            Feature("correction, 2-norm over the record", n, "rad", 1e-3, 1e2),
            Feature("joint position at the start, motors, arm side", n, "rad", -turn, turn, False),
            Feature("commanded speed", 1, "m/s", 0.0, 0.1, False),
            Feature("iteration k", 1, "-", 0.0, 10.0, False),
        )
        if self.payload:
            every = (*every, Feature("payload", 1, "kg", 0.0, HEAVIEST, False))
        if self.shapes.are_drawn:
            radius = Feature("radius of the contour", 1, "m", SMALLEST, LARGEST)
            shape = Feature("shape", len(self.shapes.names), "-", 0.0, 1.0, False)
            every = (*every, radius, shape)
        if self.basis is None:
            return every
        size, names = n * self.basis.count, ("error", "correction")
        of_basis = (Feature(f"{name} in the basis", size, "-", -1.0, 1.0, False) for name in names)
        return (*every, *of_basis)

    @cached_property
    def size(self) -> int:
        """Number of entries."""
        return sum(feature.size for feature in self.features)

    @cached_property
    def _scales(self) -> tuple[Array, Array, Array]:
        """Logarithmic or not, low and high of each entry."""
        sizes = [f.size for f in self.features]
        rows = [
            [f.logarithmic for f in self.features],
            [np.log(f.low) if f.logarithmic else f.low for f in self.features],
            [np.log(f.high) if f.logarithmic else f.high for f in self.features],
        ]
        logarithmic, low, high = (np.repeat(np.array(row), sizes) for row in rows)
        return logarithmic, low, high

    def normalised(self, values: Array) -> Array:
        """Physical values (..., size) to [-1, 1], clipped; not finite becomes +1."""
        logarithmic, low, high = self._scales
        with np.errstate(divide="ignore", invalid="ignore"):
            scaled = np.where(logarithmic, np.log(values), values)
        part = np.where(np.isfinite(values), (scaled - low) / (high - low), 1.0)
        return 2.0 * np.clip(part, 0.0, 1.0) - 1.0

    def of(self, situation: Situation) -> np.ndarray:
        """(size,) float32 in [-1, 1]."""
        loaded, task = situation.experiment.loaded, situation.task
        values = [
            situation.two_norm,
            situation.inf_norm,
            *band_rms(situation.motor_error, LOG_PERIOD, BANDS),
            two_norm(situation.correction * loaded.model.drives.gear),
            loaded.reference[0],
            np.array([situation.experiment.motion.programmed_speed]),
            np.array([float(situation.k)]),
        ]
        if self.payload:
            values.append(np.array([task.payload or 0.0]))
        if self.shapes.are_drawn:
            values.append(np.array([task.radius]))
            values.append(np.array([float(name == task.shape) for name in self.shapes.names]))
        if self.basis is not None:
            own = situation.correction - situation.centre
            for signal in (situation.error, own):
                values.append(self.basis.fit(signal, situation.size).ravel())
        return self.normalised(np.concatenate(values)).astype(np.float32)


def band_rms(signal: Array, period: float, bands: tuple[tuple[float, float], ...]) -> Array:
    """(len(bands), n): part of the RMS of each column of a signal (N, n), every `period` [s], in
    each band [low, high) Hz; the Nyquist frequency counts to one that ends there."""
    n = len(signal)
    power = np.abs(np.fft.rfft(signal, axis=0) / n) ** 2
    power[1 : (n + 1) // 2] *= 2.0  # both halves of the spectrum, mean and Nyquist but once
    frequency = np.fft.rfftfreq(n, period)
    nyquist = 0.5 / period
    inside = [(frequency >= low) & ((frequency < high) | (high >= nyquist)) for low, high in bands]
    return np.sqrt(np.stack([power[band].sum(axis=0) for band in inside]))
