"""`armside calibrate`: choose what no source tells of the large robot, from what it should do."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from armside import assets
from armside.sim.calibration.parameters import Trim, apply, numbers, rewrite
from armside.sim.calibration.targets import (
    Finding,
    learning_findings,
    model_findings,
    nominal_findings,
)
from armside.sim.records.atomic import write_whole
from armside.sim.records.summary import summary
from armside.sim.robot.effects import Effect
from armside.sim.robot.model import RobotModel, load_model

from ..jobs.workers import Workers
from ..shell.console import Report, keep
from ..shell.errors import RunFailed
from ..shell.options import Common, options

START = Trim(
    servo_frequency=(6.5, 6.1, 3.8, 8.6, 10.7, 10.4),
    servo_damping=1.14,
    velocity_feedforward=(0.89, 0.89, 0.84, 0.91, 0.77, 0.905),
    correction_delay=0.0138,
    elastic_compensation=0.57,
    gear_stiffness=1.04,
    gear_damping=0.7,
    gear_soft=0.15,
    lost_motion=0.14,
    structure_stiffness=1.01,
    structure_damping=0.30,
    gear_error=0.45,
    ripple=1.0,
    friction=(1.0, 0.86, 0.84, 0.72, 0.47, 0.37),
    static_excess=0.23,
    temperature=33.0,
    bristle_stiffness=20.0,
)
"""Where the search starts: rounded from earlier searches of the same kind, the first of which
started from a set without gear effects."""

CHANCE = {
    "servo_frequency": 0.03,
    "servo_damping": 0.04,
    "velocity_feedforward": 0.01,
    "correction_delay": 0.03,
    "elastic_compensation": 0.08,
    "gear_stiffness": 0.06,
    "gear_soft": 0.1,
    "lost_motion": 0.2,
    "structure_damping": 0.15,
    "gear_error": 0.2,
    "ripple": 0.15,
    "friction": 0.1,
    "static_excess": 0.2,
    "temperature": 0.03,
    "bristle_stiffness": 0.2,
}
"""What the search varies, and by how much: standard deviation relative to the value."""

LEAST = {"structure_damping": 0.25, "lost_motion": 0.14, "gear_error": 0.4, "ripple": 0.7}
"""What must not be calibrated away: modes keep 0.6 % of critical damping, gears their faults."""
CHILDREN = 4
"""Candidates of one generation; the best of them is the next parent if it is better."""
DIGITS = 3
EFFECTS = frozenset(Effect)


@options
@dataclass(frozen=True, kw_only=True)
class CalibrateCfg:
    """How long to search, and what to do with what was found."""

    generations: int = 12
    """Generations of four candidates; 0 checks the numbers in the file and searches nothing."""
    file: Path = assets.LARGE_ROBOT_XML
    """MJCF that the numbers are compared with."""
    write: bool = False
    """Write the numbers found into that file."""

    def __post_init__(self) -> None:
        if self.generations < 0:
            raise ValueError(f"generations must be >= 0, got {self.generations}")


@dataclass(frozen=True)
class Candidate:
    """A trim, what it makes the robot do, and how far that is from the bands."""

    trim: Trim
    findings: tuple[Finding, ...]
    score: float


def findings(model: RobotModel) -> Iterator[Finding]:
    """All targets, the cheap and telling ones first."""
    yield from learning_findings(model, EFFECTS)
    yield from nominal_findings(model, EFFECTS)
    yield from model_findings(model, EFFECTS)


def score(found: Iterable[Finding]) -> float:
    """Sum of how far each number is outside its band, margins included."""
    return sum(one.outside for one in found)


def evaluate(trim: Trim, give_up_at: float = np.inf) -> Candidate:
    """Run the experiments of a trim; stop where its score cannot get better than `give_up_at`."""
    mj = mujoco.MjModel.from_xml_path(str(assets.LARGE_ROBOT_XML))
    apply(mj, trim)
    model = load_model(mj)
    found: list[Finding] = []
    for part in (learning_findings, nominal_findings, model_findings):
        found.extend(part(model, EFFECTS))
        if score(found) > give_up_at:
            break
    return Candidate(trim, tuple(found), score(found))


def _evaluate(task: tuple[Trim, float]) -> Candidate:
    return evaluate(*task)


def mutate(trim: Trim, rng: np.random.Generator) -> Trim:
    """Another trim: one to three of the quantities drawn anew around their values."""
    chosen = rng.choice(list(CHANCE), size=rng.integers(1, 4), replace=False)
    changes: dict[str, Any] = {}
    for name in map(str, chosen):
        value = np.asarray(getattr(trim, name), dtype=np.float64)
        which = rng.random(value.shape) < 0.5 if value.ndim else True
        factor = 1.0 + CHANCE[name] * rng.standard_normal(value.shape) * which
        changed = _rounded(value * factor)
        changed = np.maximum(changed, LEAST.get(name, 0.0))
        if name == "velocity_feedforward":
            changed = np.minimum(changed, 1.0)
        changes[name] = tuple(map(float, changed)) if value.ndim else float(changed)
    return replace(trim, **changes)


def _rounded(values: Any) -> Any:
    """Three significant digits: what is written is what was run."""
    magnitude = 10.0 ** (DIGITS - 1 - np.floor(np.log10(np.maximum(np.abs(values), 1e-12))))
    return np.round(np.abs(values) * magnitude) / magnitude


def search(start: Trim, generations: int, seed: int, workers: Workers) -> Iterator[Candidate]:
    """The best candidate after each generation; stops when every number is well inside its band."""
    rng = np.random.default_rng(seed)
    best = evaluate(start)
    for _ in range(generations):
        if best.score == 0.0:
            return
        children = [(mutate(best.trim, rng), best.score) for _ in range(CHILDREN)]
        best = min([best, *workers.map(_evaluate, children)], key=lambda c: c.score)
        yield best


def calibrate(*, cfg: CalibrateCfg = CalibrateCfg(), common: Common = Common()) -> None:
    """Calibrate the large robot to the phenomena of thesis chapter 9, and compare with its file.

    The search is the same for the same seed, whatever the number of cores. With --generations 0
    the numbers in the file are held against the targets.
    """
    report = Report(common)
    if cfg.generations == 0:
        found = tuple(findings(load_model(cfg.file)))
        trim = None
    else:
        best = evaluate(START)
        with Workers() as workers, report.progress("calibrating", cfg.generations) as step:
            for candidate in search(START, cfg.generations, common.seed, workers):
                best = candidate
                step()
        found, trim = best.findings, best.trim
    rows = [(f.name, f.value, _end(f.low), _end(f.high), "yes" if f.holds else "NO") for f in found]
    report.table("Targets", ("number", "value", "from", "to", "holds"), rows)
    differs = [] if trim is None else _compare(report, cfg.file, trim)
    if cfg.write and trim is not None:
        write_whole(cfg.file, rewrite(cfg.file.read_text(encoding="utf-8"), trim))
    outcome = summary("calibrate", cfg, common, score=score(found), trim=trim, findings=rows)
    keep(outcome, common)
    report.summary(outcome)
    failed = [f.name for f in found if not f.holds]
    if failed:
        raise RunFailed(f"{len(failed)} of {len(found)} targets are missed: {', '.join(failed)}")
    if differs and not cfg.write:
        raise RunFailed(f"{cfg.file} has other numbers: {', '.join(differs)}")


def _end(value: float) -> str:
    return f"{value:g}" if np.isfinite(value) else ""


def _compare(report: Report, file: Path, trim: Trim) -> list[str]:
    """Print what was found; return the names of what the file has otherwise."""
    rows = [(f.name, str(getattr(trim, f.name))) for f in fields(trim)]
    report.table("Found", ("quantity", "value"), rows)
    mj = mujoco.MjModel.from_xml_path(str(file))
    wanted = mujoco.MjModel.from_xml_path(str(file))
    apply(wanted, trim)
    same = {
        "springs": np.allclose(mj.jnt_stiffness, wanted.jnt_stiffness, rtol=1e-6)
        and np.allclose(mj.dof_damping, wanted.dof_damping, rtol=1e-6),
        "controllers": np.allclose(mj.actuator_gainprm, wanted.actuator_gainprm, rtol=1e-6),
        "friction": np.allclose(mj.actuator_dynprm, wanted.actuator_dynprm, rtol=1e-6),
    } | {
        name: np.allclose(mj.numeric(name).data, values, rtol=1e-6)
        for name, values in numbers(trim).numerics.items()
    }
    return [name for name, equal in same.items() if not equal]
