"""The cut part as measured output: deviation of the beam across each contour, by a scan.

    e(t) = -n(s) (d(s) + n(s)^T m)        s(t): foot on the contour of the path that is expected

The path by motors and springs is fitted to the contour first; m is the motion by which it is beside
it, d the deviation of the scan after a fit of its own. Along the path and in height a scan sees
nothing: there the error is what keeps the whole in the law's pass band, which a deviation across a
path that turns is not. On the leads, and within `HELD` of both ends, what the tool deviates beyond
the expected path fades to zero at rest. Without an IMU the springs, of the path and of the law, are
those that explain the first scan.
"""

import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws import Law

from ..estimation.arm_plant import PathPlants, plants_along
from ..estimation.commissioning import Commissioning, OnFault, commission
from ..estimation.deflection import Deflection, deflection
from ..estimation.elasticity import (
    ArmParameters,
    Elasticity,
    SpringPrior,
    nominal_elasticity,
    parameters_at,
)
from ..estimation.estimator import tool_path
from ..estimation.nominal import NominalArm, NominalCfg, assumed_arm
from ..estimation.relative_path import relative_to_start
from ..estimation.rigid_motion import RigidMotion, rigid_motion
from ..estimation.structure import with_structure
from ..estimation.tool_law import ToolLaw
from ..instruments.imu import ImuCfg
from ..motion.contour import ClosedCurve, outward_normal
from ..motion.path import Plane
from ..notes import Cause, Note
from ..robot.virtual_robot import LOG_PERIOD
from ..scan.reading import SheetScan
from ..scan.shape import Shape, scanned_shape, shape, taken_off, usable
from ..scan.virtual_reading import CALIBRATED, BeamPath, ScanErrors, virtual_scan
from .experiment import Experiment, Pass
from .measures import SetUp

_SLOPE = 25
"""Samples beside one among which its foot on the programmed path is looked for: 0.1 s."""
_CORRELATION = 4.3
"""Scale of residuals over their RMS, as if samples were independent: an edge lasts for 3 mm."""
_NOISE = 30e-6
"""[m], least scale: geometry and gear errors, that springs cannot explain. ESTIMATE."""
_PASSES = 40
"""Of the low pass, after which the error across the path is put back."""
_STEPS, _STEP, _LARGEST_STEP, _CONVERGED = 15, 0.05, 0.5, 0.02
_PARTS = 1.0, 0.5, 0.25, 0.1
"""Of a step, the first with which the fit is better."""
_STARTS = 0.0, 0.7, 1.2
"""Log stiffness of the structure: some end where others are far better. Chosen on robots of
development."""


class Scans(Protocol):
    """Where scans come from."""

    def __call__(self, experiment: Experiment, run: Pass) -> SheetScan:
        """The scan of the part that a run cut, contours by their names."""
        ...


@dataclass(frozen=True)
class VirtualScans:
    """Scans of virtual parts by one scanner."""

    errors: ScanErrors = CALIBRATED

    def __call__(self, experiment: Experiment, run: Pass) -> SheetScan:
        time, position = run.true
        cut = dict[str, BeamPath]()
        for one in places(experiment):
            on = (time >= one.begin) & (time < one.end)
            path = experiment.cut.plane.from_base(position[on])[:, :2]
            cut[one.name] = BeamPath(curve=one.curve, middle=one.middle, path=path)
        # The scanner stays; what differs from part to part follows from the run: the same again.
        part = zlib.crc32(np.ascontiguousarray(run.recording.motor_angle).tobytes())
        unit, own = (np.random.default_rng([experiment.seed, 0x5CA, n]) for n in (0, 1 + part))
        return virtual_scan(cut, own, self.errors, unit=unit, beam_measured=False)


@dataclass(frozen=True, kw_only=True)
class Place:
    """A contour in a motion."""

    name: str
    curve: ClosedCurve
    plane: Plane
    """Its origin at the contour's middle."""
    middle: tuple[float, float]
    """[m], in the plane of the part."""
    begin: float
    end: float
    """[s]."""


def places(experiment: Experiment) -> list[Place]:
    """Contours of an experiment, in their order."""
    motion: Any = experiment.motion
    each = getattr(motion, "places", (motion,))
    found = list[Place]()
    for timed, one in zip(experiment.cut.contours(motion), each, strict=True):
        x, y, _ = experiment.cut.plane.from_base(one.plane.origin)
        middle = float(x), float(y)
        found.append(
            Place(
                name=timed.name,
                curve=one.curve,
                plane=one.plane,
                middle=middle,
                begin=timed.begin,
                end=timed.end,
            )
        )
    return found


@dataclass(frozen=True, kw_only=True)
class ScannedPart:
    """Deviation across the contours by a scan of each part, and a law on identified springs."""

    scans: Scans = field(default_factory=VirtualScans)
    law: ToolLaw = field(default_factory=ToolLaw)
    parameters: ArmParameters | None = None
    """Of this robot, identified earlier; None identifies springs from the first scan."""
    imu: ImuCfg | None = None
    """A unit that is lent for the first run, from which springs are identified."""
    identified: bool = True
    """Springs follow from the first scan; else they are those assumed."""
    stiffness_error: float = 0.3
    """As of `ToolPath`."""
    prior: SpringPrior = field(default_factory=SpringPrior)

    def prepare(self, experiment: Experiment) -> SetUp:
        """Raises ValueError for a model that no arm can be built on."""
        cfg = NominalCfg(structure=True, payload=experiment.added_payload)
        elastic = with_structure(experiment.nominal)
        arm = assumed_arm(elastic, self.stiffness_error, experiment.seed, cfg)
        return lambda first: self._set_up(experiment, arm, first)

    def _set_up(self, experiment: Experiment, arm: NominalArm, first: Pass) -> "ScanOutput":
        robot, log = experiment.nominal, first.recording
        if self.imu is not None or self.parameters is not None:
            cfg = Commissioning(on_fault=OnFault.REFUSE if self.imu else OnFault.GO_ON)
            unit = self.imu or ImuCfg()
            known = commission(robot, arm, unit, log, first.imu, cfg, self.parameters)
            found = known.parameters.springs if known.fault is None or self.parameters else None
            return ScanOutput(self, experiment, arm, known.plants, found)
        motion, nominal = (
            rigid_motion(arm, log.time, log.motor_angle),
            nominal_elasticity(robot, arm),
        )
        if not self.identified:
            plants = plants_along(robot, motion, nominal.on_rigid_structure, identified=False)
            return ScanOutput(self, experiment, arm, plants, None)
        scan = self.scans(experiment, first)
        springs = springs_by_scan(motion, nominal, Seen.of(experiment, scan, log.time), self.prior)
        of_law = nominal.on_rigid_structure if springs is None else springs
        plants = plants_along(robot, motion, of_law, identified=False)
        return ScanOutput(self, experiment, arm, plants, springs, unexplained=springs is None)


@dataclass(frozen=True, eq=False)
class Seen:
    """What a scan says of one run: contours as cut, and the samples of the log on each."""

    places: Sequence[Place]
    shapes: Sequence[Shape]
    on: Sequence[np.ndarray]
    start: Array
    """(3,) [m], programmed position at rest."""

    @classmethod
    def of(cls, experiment: Experiment, scan: SheetScan, time: Array) -> "Seen":
        """Raises ValueError for a scan that lacks a contour, or is of another one."""
        each = places(experiment)
        if missing := [one.name for one in each if one.name not in scan.contours]:
            known = ", ".join(scan.contours) or "none"
            raise ValueError(f"the scan has no contour {missing[0]!r}. Contours: {known}")
        shapes = [scanned_shape(one.curve, scan.contours[one.name]) for one in each]
        for one, made in zip(each, shapes, strict=True):
            if (objection := made.objection) is not None:
                raise ValueError(f"{one.name}: {objection}: another part")
        on = [np.flatnonzero((time >= one.begin) & (time < one.end)) for one in each]
        return cls(each, shapes, on, experiment.programmed[0])

    def feet(self, displacement: Array) -> list[Array]:
        """Arc lengths [m] at which a tool path (N, 3) from rest is compared with the scan."""
        found = []
        for one, made, path in self._along(displacement):
            found.append(path.arc_length[usable(one.curve, made, path.arc_length)])
        return found

    def residual(self, displacement: Array, feet: Sequence[Array]) -> Array:
        """(K,) [m], deviation by the scan less that of a tool path (N, 3) from rest, after the
        motion that fits the two."""
        found = []
        for (one, made, path), s in zip(self._along(displacement), feet, strict=True):
            left = made.at(s, one.curve.length) - path.at(s, one.curve.length)
            columns = taken_off(one.curve, s)
            found.append(left - columns @ np.linalg.lstsq(columns, left, rcond=1e-6)[0])
        return np.concatenate(found)

    def _along(self, displacement: Array) -> Iterator[tuple[Place, Shape, Shape]]:
        """Each contour, as scanned, and as a tool path has it."""
        for one, made, on in zip(self.places, self.shapes, self.on, strict=True):
            in_plane = one.plane.from_base(self.start + displacement[on])[:, :2]
            yield one, made, shape(one.curve, in_plane)


def springs_by_scan(
    motion: RigidMotion, nominal: Elasticity, seen: Seen, prior: SpringPrior
) -> Elasticity | None:
    """Springs of gears and structure, and lost motion, that explain the scan of a run best; None if
    an arm without any explains it as well.

    Regularised Gauss-Newton from nominal springs on, and from stiffer structures; residuals weigh
    by what they leave.
    """
    sd, n = prior.standard_deviation(nominal), len(nominal.stiffness)
    free = np.r_[:n, n + 2]
    feet = seen.feet(_tool(motion, nominal))

    def left(theta: Array) -> Array:
        """Not finite with springs that cannot carry the arm."""
        try:
            return seen.residual(_tool(motion, parameters_at(nominal, theta).springs), feet)
        except (FloatingPointError, RuntimeError):
            return np.full(sum(map(len, feet)), np.nan)

    best, least = None, _rms(seen.residual(_tool(motion, None), feet))
    for structure in _STARTS:
        theta = np.zeros_like(sd)
        theta[:n] = structure
        theta[nominal.axes] = 0.0
        now = left(theta)
        for _ in range(_STEPS):
            moved = np.array([left(theta + _STEP * one) for one in np.eye(len(sd))[free]])
            if not (np.isfinite(now).all() and np.isfinite(moved).all()):
                break
            A, scale = (now - moved).T / _STEP, max(_CORRELATION * _rms(now), _NOISE)
            normal = A.T @ A / scale**2 + np.diag(sd[free] ** -2.0)
            step = np.linalg.solve(normal, A.T @ now / scale**2 - theta[free] / sd[free] ** 2)
            step = np.clip(step, -_LARGEST_STEP, _LARGEST_STEP)
            before = now @ now / scale**2 + np.sum((theta / sd) ** 2)
            for part in _PARTS:
                tried = theta.copy()
                tried[free] += part * step
                then = left(tried)
                if then @ then / scale**2 + np.sum((tried / sd) ** 2) < before:
                    break
            else:
                break
            theta, now = tried, then
            if np.abs(part * step).max() < _CONVERGED:
                break
        if _rms(now) < least:
            best, least = parameters_at(nominal, theta).springs, _rms(now)
    return best


def _rms(residual: Array) -> float:
    return float(np.sqrt(np.mean(residual**2)))


def _tool(motion: RigidMotion, springs: Elasticity | None) -> Array:
    """(N, 3) [m], displacement of the tool from rest, on springs or without deflection."""
    if springs is None:
        none = np.zeros((len(motion.phi), motion.arm.n_free))
        return tool_path(motion, Deflection(none, none, none))[:, :3]
    return tool_path(motion, deflection(motion, springs))[:, :3]


@dataclass(frozen=True, eq=False)
class ScanOutput:
    """Paths (N, 6) from rest, displacement [m] and rotation [rad], that differ from the reference
    by what a scan shows across the contours."""

    measure: ScannedPart
    experiment: Experiment
    arm: NominalArm
    plants: PathPlants
    springs: Elasticity | None
    """None where nothing is known of them: the arm is taken to be rigid."""
    unexplained: bool = False
    """The first scan was to give springs, and did not."""

    @property
    def notes(self) -> tuple[Note, ...]:
        """Why springs are those assumed."""
        if not self.unexplained:
            return ()
        text = "no springs explain the first scan better than none: those assumed are used instead"
        return (Note(cause=Cause.SCAN, text=text),)

    @property
    def reference(self) -> Array:
        """(N, 6), the programmed path from rest."""
        return relative_to_start(self.experiment.programmed)

    @property
    def law(self) -> Law:
        return self.measure.law.along(self.plants, self.experiment.turn_rate, rotations=False)

    def __call__(self, run: Pass) -> Array:
        """Raises ValueError as `Seen.of`."""
        across, normal = self._deviation(run)
        output = self.reference.copy()
        output[:, :3] += self._in_band(across, normal)
        return output

    def across(self, run: Pass) -> Array:
        """(N, 3) [m], deviation of the tool across the path alone. Raises ValueError as
        `Seen.of`."""
        across, normal = self._deviation(run)
        return across[:, None] * normal

    def size(self, error: Array) -> Array:
        """Norm of the displacement."""
        return np.array([float(np.linalg.norm(error[:, :3]))])

    def _deviation(self, run: Pass) -> tuple[Array, Array]:
        """Of the tool across the path (N,) [m], and the normals (N, 3)."""
        log = run.recording
        seen = Seen.of(self.experiment, self.measure.scans(self.experiment, run), log.time)
        expected = self._expected(log.motor_angle)
        d, normal = self._off_path(expected)
        beyond, there = np.zeros(len(d)), np.zeros(len(d), dtype=bool)
        for one, made, on in zip(seen.places, seen.shapes, seen.on, strict=True):
            path = shape(one.curve, one.plane.from_base(expected[on])[:, :2])
            rows = usable(one.curve, made, path.arc_length)
            s, at = path.arc_length[rows], on[rows]
            n = outward_normal(one.curve.tangent(s)) @ one.plane.axes[:, :2].T
            # A contour that is cut clockwise has its right inside, as the leads have theirs.
            side = np.sign(np.vdot(n, normal[at]))
            normal[at] = side * n
            wanted = made.at(s, one.curve.length) + taken_off(one.curve, s) @ path.motion
            off = path.deviation[rows] + taken_off(one.curve, s) @ path.motion
            beyond[at], d[at], there[at] = side * (wanted - off), side * off, True
        return d + self._faded(beyond, there), normal

    def _in_band(self, across: Array, normal: Array) -> Array:
        """(N, 3) [m] with a part (N,) along normals (N, 3), the rest free but zero at rest."""
        cutoff = self.measure.law.band(self.plants, self.experiment.turn_rate)
        low_pass, found = ZeroPhaseButterworth(cutoff, LOG_PERIOD), across[:, None] * normal
        for _ in range(_PASSES):
            found = low_pass(found)
            found += (across - np.einsum("ij,ij->i", found, normal))[:, None] * normal
            found[self._at_rest] = 0.0
        return found

    @cached_property
    def _at_rest(self) -> NDArray[np.bool_]:
        """(N,)."""
        step = np.linalg.norm(np.gradient(self.experiment.programmed, axis=0), axis=1)
        return np.asarray(step < 1e-9)

    def _faded(self, beyond: Array, there: np.ndarray) -> Array:
        """What is beyond (N,), interpolated between places, and to zero where the tool rests."""
        known = np.flatnonzero(there | self._at_rest)
        x = np.arange(len(beyond))
        after = np.clip(np.searchsorted(known, x), 1, len(known) - 1)
        i, j = known[after - 1], known[after]
        w = np.clip((x - i) / np.maximum(j - i, 1), 0.0, 1.0)
        w = 0.5 - 0.5 * np.cos(np.pi * w)
        return (1.0 - w) * beyond[i] + w * beyond[j]

    def _expected(self, motor_angle: Array) -> Array:
        """(N, 3) [m], tool by motors and springs, from its programmed place at rest."""
        time: Array = np.arange(len(motor_angle), dtype=np.float64) * LOG_PERIOD
        motion = rigid_motion(self.arm, time, motor_angle)
        return self.experiment.programmed[0] + _tool(motion, self.springs)

    def _off_path(self, path: Array) -> tuple[Array, Array]:
        """Deviation (N,) [m] of a path across the programmed one, and normals (N, 3)."""
        programmed, up = self.experiment.programmed, self.experiment.cut.plane.axes[:, 2]
        rate = np.gradient(programmed, axis=0)
        speed = np.linalg.norm(rate, axis=1)
        tangent = rate / np.maximum(speed, 1e-12)[:, None]
        across = np.cross(tangent, up)
        n = len(path)
        near = np.clip(np.arange(n)[:, None] + np.arange(-_SLOPE, _SLOPE + 1), 0, n - 1)
        away = np.linalg.norm(path[:, None] - programmed[near], axis=2)
        away[speed[near] < 1e-9] = np.inf
        foot = near[np.arange(n), away.argmin(axis=1)]
        d = np.einsum("ij,ij->i", path - programmed[foot], across[foot])
        return np.where(speed > 1e-9, d, 0.0), across[foot]
