"""Transmission error of an arm from recordings, judged on those that it was not learned from.

A sample is usable for a joint if the sensor saw it, without a hole as long as half a period of the
band's end, and if the joint moves at a rate at which an order of the scan falls into the band.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array, check_numbers
from armside.kinematics import Arm, compile

from ..recordings.alignment.encoder_motion import RATE
from ..recordings.recorded_motion import (
    SHORTEST,
    MotionRecording,
    Stream,
    check_angles,
    check_times,
)
from .aligned import SHORTEST_SEEN, Aligned, Sensor, align
from .judgement import (
    InBand,
    Remaining,
    Spectra,
    fused,
    in_bands,
    judged_rows,
    remaining,
    sensor_ratio,
    spectra,
)
from .residual_spectra import Observation
from .scan import SMALLEST, Scan, resolution
from .several_observations import CANDIDATES, CHANCE, Course
from .transmission import Transmission


@dataclass(frozen=True, kw_only=True)
class GearsCfg:
    """Choices of an analysis."""

    sensor: Sensor | None = None
    """Sensor to learn from; None takes the IMU where there is one."""
    band: tuple[float, float] = (2.5, 16.0)
    """[Hz] Band that is learned from."""
    judged: tuple[float, float] = (4.0, 12.0)
    """[Hz] Band in which a tracker judges."""
    largest_order: float = 420.0
    per_joint: int = 4
    """Most terms of one joint."""
    elastic: bool = False
    """The arm's first resonance is near enough to the band to amplify errors, and is found too."""

    def __post_init__(self) -> None:
        check_numbers(self, "band", "judged", several=True)
        for name in ("band", "judged"):
            if len(getattr(self, name)) != 2:
                raise ValueError(f"{name} must be two frequencies, got {getattr(self, name)}")
            low, high = getattr(self, name)
            if not 0.1 <= low < high <= 40.0:
                said = f"{name} must be two frequencies from 0.1 to 40 Hz"
                raise ValueError(f"{said}, the lower first, got {low:g} {high:g}")
        if not 30.0 <= self.largest_order <= 2000.0:
            raise ValueError(f"largest order must be 30 to 2000, got {self.largest_order:g}")
        if not 1 <= self.per_joint <= CANDIDATES:
            raise ValueError(f"per_joint must be 1 to {CANDIDATES}, got {self.per_joint}")


VIRTUAL = GearsCfg(band=(0.6, 3.3), judged=(0.6, 3.0), largest_order=520.0, elastic=True)
"""For the virtual large robot in the motion of `excitation`. Chosen on seeds 100, 101 and 103; its
first resonances lie at 6 to 7 Hz, and its gears have orders up to 485."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Judgement:
    """A recording judged by the transmission error that others, or its first half, taught."""

    recording: str
    learned_from: tuple[str, ...]
    found: Transmission
    sham: Transmission | None
    """Fit of orders that no gear has, as a control."""
    sensor: float
    sham_sensor: float
    """Residual of the learning sensor, with over without the transmission error."""
    tool: Remaining | None = None
    sham_tool: Remaining | None = None
    """The same by the tracker."""
    smoothed: Remaining | None = None
    """With the IMU of that recording smoothed into it."""
    bands: tuple[InBand, ...] = ()
    """Both in bands of frequency; empty without tracker."""
    spectra: Spectra | None = None
    unjudged: str | None = None
    """Why no tracker judges it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class GearAnalysis:
    """Result of `analyse_gears`."""

    cfg: GearsCfg
    sensor: Sensor
    aligned: tuple[Aligned, ...]
    scan: Scan
    resolution: Array
    found: Transmission | None
    """Of all recordings; None where no order stands out."""
    judgements: tuple[Judgement, ...]


def analyse_gears(
    arm: Arm,
    recordings: Sequence[MotionRecording],
    cfg: GearsCfg = GearsCfg(),
    step: Callable[[], None] = lambda: None,
) -> GearAnalysis:
    """Learn the transmission error, and judge each recording by what the others taught.

    A single recording is judged on its second half by its first. step: called n times for each
    recording or half.

    Raises:
        ValueError: recordings that do not fit the robot, or have no sensor to learn from.
    """
    sensor, robot = _sensor(recordings, cfg.sensor), compile(arm.robot)
    for recording in recordings:
        check_angles(arm.limits, recording)
        check_times(recording)
    aligned = tuple(align(robot, recording) for recording in recordings)
    alone = len(aligned) == 1
    parts = [(0.0, 0.5), (0.5, 1.0)] if alone else [(0.0, 1.0)]
    observations = [one.observation(sensor, cfg.band, part) for one in aligned for part in parts]
    apart = np.max([resolution(one.phi) for one in observations], axis=0)
    course = Course(observations, apart, cfg.largest_order, cfg.per_joint, cfg.elastic, step)
    everything = range(len(observations))
    judgements: list[Judgement] = []
    for k in [1] if alone else everything:
        lesson = [other for other in everything if other != k]
        source = tuple(aligned[other].name for other in lesson if not alone)
        found, control = course.learn(lesson)
        if found is not None:
            one = aligned[0 if alone else k]
            source = source or (f"first half of {one.name}",)
            judgements.append(_judged(one, observations[k], source, found, control, cfg))
    return GearAnalysis(
        cfg=cfg,
        sensor=sensor,
        aligned=aligned,
        scan=course.total(everything),
        resolution=apart,
        found=course.learn(everything)[0],
        judgements=tuple(judgements),
    )


def _sensor(recordings: Sequence[MotionRecording], asked: Sensor | None) -> Sensor:
    asked_for: tuple[Sensor, ...] = ("imu", "tracker") if asked is None else (asked,)
    for sensor in asked_for:
        if all(getattr(one, sensor) is not None for one in recordings):
            return sensor
    sensors = " or ".join(asked_for)
    raise ValueError(f"gears need a sensor in every recording: {sensors}")


def _judged(
    one: Aligned,
    seen: Observation,
    source: tuple[str, ...],
    found: Transmission,
    control: Transmission | None,
    cfg: GearsCfg,
) -> Judgement:
    assert control is not None
    judged = Judgement(
        recording=one.name,
        learned_from=source,
        found=found,
        sham=control,
        sensor=sensor_ratio(found, seen),
        sham_sensor=sensor_ratio(control, seen),
    )
    if one.tracker is None:
        return replace(judged, unjudged="it has no samples of a tracker or of cameras")
    rows = judged_rows(one)
    if rows.sum() < SHORTEST_SEEN * RATE:
        saw = f"the tracker saw {rows.sum() / RATE:.3g} s of its second half"
        return replace(judged, unjudged=f"{saw}, {SHORTEST_SEEN:g} s are needed")
    residual = one.tool_residual()[0]
    gears, sham = (x.tool_error(one.motion, one.target).sum(axis=2) for x in (found, control))
    both = None if one.imu is None else fused(one, found)
    return replace(
        judged,
        tool=remaining(residual, gears, rows, cfg.judged),
        sham_tool=remaining(residual, sham, rows, cfg.judged),
        smoothed=None if both is None else remaining(residual, both, rows, cfg.judged),
        bands=in_bands(residual, gears, both, rows),
        spectra=spectra(residual, gears, both, rows),
    )


WHOLE = 0.9
"""Fraction of the motion that a sensor saw, below which it is said."""


class Coverage(NamedTuple):
    """What the recordings show of one joint."""

    usable: float
    """Fraction of the samples of the motion."""
    seconds: float
    """[s] The same as a time."""
    smallest: float
    """[rad] Amplitude from which on an order stands out from chance; median over the orders."""


def coverage(done: GearAnalysis) -> tuple[Coverage, ...]:
    """Coverage of each joint by all recordings."""
    low, high = 2.0 * np.pi * np.array(done.cfg.band)
    rate = np.abs(np.concatenate([one.motion.rate for one in done.aligned]))
    seen = np.concatenate([_seen(done, one) for one in done.aligned])
    shown = (rate * done.cfg.largest_order >= low) & (rate * SMALLEST <= high)
    usable = shown & seen[:, None]
    smallest = [
        np.median(np.sqrt(CHANCE * typical / np.maximum(unit, np.finfo(np.float32).tiny)))
        for typical, unit in zip(done.scan.typical, done.scan.unit, strict=True)
    ]
    return tuple(
        Coverage(float(own.mean()), float(own.sum() / RATE), float(amplitude))
        for own, amplitude in zip(usable.T, smallest, strict=True)
    )


def coverage_notes(done: GearAnalysis) -> tuple[str, ...]:
    """A line for each recording that a sensor saw a part of or no tracker judges, and each joint of
    which nothing was found, with the median over the orders of what is missed."""
    found = set() if done.found is None else {term.joint for term in done.found.terms}
    notes = []
    for one in done.aligned:
        if (fraction := float(_seen(done, one).mean())) < WHOLE:
            saw = f"encoders and {done.sensor} saw {100 * fraction:.0f} % of the motion"
            notes.append(f"{one.name}: {saw} without holes")
    for joint, own in enumerate(coverage(done), 1):
        if joint not in found:
            usable = f"{100 * own.usable:.0f} % of samples usable"
            missed = f"no order found: {usable}, errors below {1e6 * own.smallest:.0f} µrad missed"
            if own.seconds < SHORTEST:
                seconds = f"{own.seconds:.2g} s of {SHORTEST:g} needed"
                missed = f"cannot be judged: {usable}, {seconds}"
            notes.append(f"joint {joint}: {missed}")
    for one in done.judgements:
        if one.unjudged:
            notes.append(f"{one.recording}: not judged at the tool: {one.unjudged}")
    return tuple(notes)


def _seen(done: GearAnalysis, one: Aligned) -> NDArray[np.bool_]:
    """(M,), samples of a recording's motion that encoders and sensor saw."""
    hole, motion = 0.5 / done.cfg.band[1], one.motion
    by_encoders = _without_holes(one.recording.encoders, motion.time, hole)
    stream: Stream | None = getattr(one.recording, done.sensor)
    assert stream is not None
    return by_encoders & _without_holes(stream, one.clock(done.sensor), hole)


def _without_holes(stream: Stream, time: NDArray[np.float64], hole: float) -> NDArray[np.bool_]:
    """True where a time lies between two samples that are at most `hole` apart [s]."""
    place = np.searchsorted(stream.time, time)
    inside = (place > 0) & (place < len(stream.time))
    place = np.clip(place, 1, len(stream.time) - 1)
    return inside & (stream.time[place] - stream.time[place - 1] <= hole)
