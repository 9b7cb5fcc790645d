"""A commissioned twin: what is known of one robot individual, on disk and in use."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from hashlib import sha256
from os import PathLike
from pathlib import Path
from typing import get_args

import numpy as np

from armside.arrays import Array, real_array

from ..cell import CELLS
from ..laser.experiment import Experiment, prepare
from ..laser.specification import Cut, Setup
from ..records.files import InputError, check_file
from ..robot.effects import gear_phases
from ..robot.individual import Individual
from ..robot.mjcf import N_AXES
from ..robot.recording import Recording
from ..robot.spread import PRODUCTION
from .identification import parameters_of
from .own_servo import OwnServo
from .parameters import HYSTERESIS, SPRINGS, Parameters
from .prediction import Corrected, Evidence, correct
from .recordings import TwinSensor
from .simulation import RobotDesign, design_of, robot_digest

FORMAT = 2
"""Of the folder; raised when an older one can no longer be read."""
UNKNOWN = 50e-6
"""[m], held-out residual of a twin of a single cut. ESTIMATE."""
_FARTHEST = 100.0
"""Prior standard deviations from the design, beyond which no parameter is identified. ESTIMATE."""
_HEAVIEST = 1e4
"""[kg], of a tool: what the command line takes."""
_ROUNDING = 1e-9
"""Of a parameter, and of a covariance relative to the prior one."""
_CERTAIN = 1e-9
"""Of the prior variance, that cuts leave at least of a parameter. ESTIMATE: two cuts leave 2e-5."""
FILES = _FILE, _COVARIANCE = "twin.json", "covariance.npy"
"""That a twin is read from."""
_MEMBERS = 8
"""Two for each core of a small machine four times over: half a second. ESTIMATE."""
_LOOSENESS: Mapping[TwinSensor, float] = {
    "tracker": 5e3,
    "imu": 0.0,
    "scan": 5e3,
    "imu and scan": 0.0,
}
"""[1/m]: log(compliance) for each metre of residual, 5 % for 10 um. From individuals 1001 to 1012,
which are not the judged ones. By the tracker 5e3 ranks their errors best among 0, 2.5e3, 5e3 and
1e4. The residual of an IMU is its own noise: of 0 the predicted errors follow those of the
individuals, long contours above short ones, and 5e3 hides that."""
_SEED = 0xE5
_TWINS, _CORRECTIONS = 8, 256
"""Kept at most; a correction of two seconds of motion takes 75 kB."""


class TwinError(InputError):
    """A folder that holds no twin, or one that does not fit."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Twin:
    """A robot individual as its commissioning found it."""

    robot: str
    """Name of the cell."""
    digest: str
    """Of the robot's file."""
    payload: float | None
    """Mass of the tool at commissioning [kg]; that of the robot's file if None."""
    sensor: TwinSensor
    """What measured the tool."""
    theta: Array
    """(m,), parameters."""
    covariance: Array = field(repr=False)
    """(m, m)."""
    held_out: Array
    """(c,) [m], residual of each commissioning cut, left out of the identification; by an IMU the
    displacement that it stands for."""
    torque_residual: Array
    """(6,) [N m], motor side, root mean square over the commissioning cuts."""
    names: tuple[str, ...]
    """(c,), of the cuts."""
    servo: OwnServo | None = field(default=None, repr=False)
    """What the servo does beyond the type's, if anything."""
    hysteresis: bool = False
    """Hysteresis of the gears was identified too."""
    friction: Array = field(default_factory=lambda: np.ones(N_AXES))
    """(6,), friction over that at commissioning, as production runs show it."""

    @cached_property
    def design(self) -> RobotDesign:
        """Design with the tool of the commissioning."""
        return self._design(self.payload)

    @cached_property
    def parameters(self) -> Parameters:
        return parameters_of(self.design)

    @cached_property
    def gear_phase(self) -> Array:
        """(6, 4) [rad], phases of the gear error in the robot's file."""
        return gear_phases(self.design.model)

    @cached_property
    def individual(self) -> Individual:
        """The individual that the twin stands for."""
        found = self.parameters.individual(self.theta, self.gear_phase)
        return replace(found, friction=self.friction)

    def correction(self, cut: Cut) -> Corrected:
        """Correction for the first run of a cut, learned inside the twin.

        Raises:
            TwinError: the cut is for another robot.
            ValueError: the cut cannot be made.
        """
        self.check(cut)
        design = self.design_with(cut.payload)
        plain = replace(cut, individual=None, friction_spread=0.0)
        nominal = design.nominal if design.payload is None else None
        return self.correction_of(prepare(plain, nominal=nominal))

    def correction_of(self, experiment: Experiment) -> Corrected:
        """The same for an experiment, such as that of a whole part. Raises TwinError as
        `correction`."""
        cut = experiment.cut
        self.check(cut)
        design = self.design_with(cut.payload)
        return correct(design, self.individual, self.around, experiment, self.evidence)

    @property
    def around(self) -> list[Individual]:
        """Individuals that commissioning cannot tell from the twin, the same ones each time."""
        rng, loose = np.random.default_rng(_SEED), _LOOSENESS[self.sensor] * self.uncertainty
        known, found = self.parameters, []
        root = np.linalg.cholesky(self.covariance + 1e-12 * np.diag(known.standard_deviation**2))
        for _ in range(_MEMBERS):
            drawn = self.theta + root @ rng.standard_normal(len(self.theta))
            for name in SPRINGS:
                at = known.at(name)
                factor = np.exp(loose * rng.standard_normal(at.stop - at.start))
                drawn[at] = (1.0 + drawn[at]) * factor - 1.0
            damping = np.exp(PRODUCTION.damping * rng.standard_normal(N_AXES))
            one = known.individual(np.clip(drawn, known.lower, known.upper), self.gear_phase)
            found.append(replace(one, gear_damping=damping, friction=self.friction))
        return found

    def run(self, cut: Setup, reference: Array, correction: Array) -> Recording:
        """Noise-free run of the twin in the robot's place; signals (N, 6) [rad], arm side."""
        return self.design_with(cut.payload).run([self.individual], reference, correction)[0]

    def design_with(self, payload: float | None) -> RobotDesign:
        """Design with a tool of that mass [kg]; that of the robot's file if None."""
        return self.design if payload == self.payload else self._design(payload)

    def _design(self, payload: float | None) -> RobotDesign:
        return design_of(self.robot, payload).besides(self.servo, self.hysteresis)

    def check(self, cut: Setup) -> None:
        """Raise TwinError for a cut of another robot."""
        if cut.cell is not CELLS[self.robot] or cut.model is not None:
            raise TwinError(f"the twin is of the robot {self.robot}, the cut is for another")

    @property
    def evidence(self) -> Evidence:
        """What it was identified from."""
        n_cuts = len(self.names)
        return Evidence(sensor=self.sensor, n_cuts=n_cuts, residual=self.uncertainty)

    @property
    def uncertainty(self) -> float:
        """Residual of a cut that the twin was not identified from [m]."""
        left = self.held_out[np.isfinite(self.held_out)]
        return float(np.median(left)) if len(left) else UNKNOWN

    def save(self, folder: Path) -> None:
        """Write the twin's files into a folder."""
        content = {
            "format": FORMAT,
            "robot": self.robot,
            "digest": self.digest,
            "payload": self.payload,
            "sensor": self.sensor,
            "cuts": list(self.names),
            "held_out": self.held_out.tolist(),
            "torque_residual": self.torque_residual.tolist(),
            "friction": self.friction.tolist(),
            "servo": None if self.servo is None else self.servo.content(),
            "parameters": dict(zip(self.parameters.names, self.theta.tolist(), strict=True)),
        }
        (folder / _FILE).write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
        np.save(folder / _COVARIANCE, self.covariance, allow_pickle=False)

    @classmethod
    def load(cls, folder: str | PathLike[str]) -> "Twin":
        """The twin of a folder. Raises TwinError where there is none that this version can use."""
        folder = Path(folder)
        file = folder / _FILE
        if not file.is_file():
            raise TwinError(f"{folder} holds no {_FILE}: `armside commission` makes a twin")
        try:
            content = json.loads(check_file(file).read_text(encoding="utf-8"))
        except (ValueError, OSError, RecursionError) as error:
            raise TwinError(f"{file} cannot be read: {error}") from error
        found = content.get("format") if isinstance(content, dict) else None
        if found != FORMAT:
            raise TwinError(f"{folder} is a twin of format {found}; this armside reads {FORMAT}")
        covariance = folder / _COVARIANCE
        try:
            known = cls(
                robot=content["robot"],
                digest=content["digest"],
                payload=None if content["payload"] is None else float(content["payload"]),
                sensor=content["sensor"],
                names=tuple(content["cuts"]),
                held_out=_numbers("held_out", content["held_out"]),
                torque_residual=_numbers("torque_residual", content["torque_residual"]),
                friction=_numbers("friction", content["friction"]),
                hysteresis=HYSTERESIS.name in " ".join(content["parameters"]),
                servo=None if (servo := content.get("servo")) is None else OwnServo.of(**servo),
                theta=_numbers("parameters", list(content["parameters"].values())),
                covariance=real_array(
                    "covariance", np.load(check_file(covariance), allow_pickle=False)
                ),
            )
        except Exception as error:  # damaged files raise many kinds
            raise TwinError(f"{folder} is a damaged twin: {error}") from error
        known._check(folder, tuple(content["parameters"]))
        return known

    def _check(self, folder: Path, names: tuple[str, ...]) -> None:
        if self.robot not in tuple(CELLS):
            raise TwinError(f"{folder} is the twin of a robot {self.robot!r}, which is not known")
        if self.digest != robot_digest(self.robot):
            changed = f"the file of the robot {self.robot} has changed since: commission it again"
            raise TwinError(f"{folder} does not fit: {changed}")
        if self.payload is not None and not 0.0 <= self.payload <= _HEAVIEST:
            heavy = f"payload must be from 0 to {_HEAVIEST:g} kg, got {self.payload:g}"
            raise TwinError(f"{folder} is a damaged twin: {heavy}")
        m = self.parameters.size
        if names != self.parameters.names or self.covariance.shape != (m, m):
            raise TwinError(f"{folder} was commissioned by another version: commission it again")
        if (reason := self._nonsense()) is not None:
            raise TwinError(f"{folder} is a damaged twin: {reason}")

    def _nonsense(self) -> str | None:
        """Why these values cannot be those of a twin; None if they can."""
        if self.sensor not in get_args(TwinSensor):
            return f"its sensor is {self.sensor!r}, not one of {', '.join(get_args(TwinSensor))}"
        drives = (self.friction, self.torque_residual)
        if not all(np.isfinite(values).all() for values in (self.theta, self.covariance, *drives)):
            return "it holds values that are not finite"
        if any(values.shape != (N_AXES,) or values.min() < 0.0 for values in drives):
            return f"friction and torque_residual must be {N_AXES} positive values"
        if self.servo is not None and (reason := self.servo.nonsense()) is not None:
            return reason
        left = self.held_out[~np.isnan(self.held_out)]
        if self.held_out.shape != (len(self.names),) or not ((left > 0.0) & (left < np.inf)).all():
            given = self.held_out.tolist()
            return f"held_out must be {len(self.names)} residuals > 0 m or null, got {given}"
        known = self.parameters
        farthest = _FARTHEST * known.standard_deviation
        low = np.maximum(known.lower, known.mean - farthest)
        high = np.minimum(known.upper, known.mean + farthest)
        if (wrong := (self.theta < low - _ROUNDING) | (self.theta > high + _ROUNDING)).any():
            return f"{known.names[int(wrong.argmax())]} is that of no robot of this type"
        prior = np.outer(known.standard_deviation, known.standard_deviation)
        scaled = self.covariance / prior
        symmetric = np.allclose(scaled, scaled.T, atol=_ROUNDING)
        if not symmetric or (least := np.linalg.eigvalsh(scaled).min()) < 0.0:
            return "its covariance is not symmetric and positive"
        if least < _CERTAIN:
            return f"its covariance must be at least {_CERTAIN:g} of the prior one, got {least:.3g}"
        return None


def _numbers(name: str, values: list[float | None]) -> Array:
    """(m,), NaN for null."""
    return real_array(name, [np.nan if value is None else value for value in values])


def digest(folder: str | PathLike[str]) -> str:
    """Hash of the content of a twin, wherever it is. Raises TwinError for a folder without one."""
    hashed = sha256()
    try:
        for name in FILES:
            hashed.update(sha256(check_file(Path(folder) / name).read_bytes()).digest())
    except (ValueError, OSError):
        Twin.load(folder)  # says what is missing
        raise TwinError(f"{folder} cannot be read") from None
    return hashed.hexdigest()


def stored_twin(folder: str | PathLike[str]) -> Twin:
    """The twin of a folder, read once as long as it stays the same. Raises as `Twin.load`."""
    return _read(Path(folder).absolute(), digest(folder))


def learned(twin: Twin, cut: Cut) -> Corrected:
    """`Twin.correction`, learned once for all cuts that differ in the robot's state alone."""
    by_design = {"individual": None, "temperature": None, "without": (), "imu": None}
    of_robot = {"friction_spread": 0.0, "friction_drift": 0.0}
    return _learned(twin, replace(cut, **by_design, **of_robot))


@lru_cache(_TWINS)
def _read(folder: Path, _content: str) -> Twin:
    return Twin.load(folder)


@lru_cache(_CORRECTIONS)
def _learned(twin: Twin, cut: Cut) -> Corrected:
    return twin.correction(cut)
