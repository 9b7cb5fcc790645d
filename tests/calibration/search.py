"""Search for the trim of the large robot that brings every number of chapter 9 into its band."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from armside import assets
from armside.sim.evaluation.check import Check
from armside.sim.notes import Note, Tally
from armside.sim.robot.effects import Effect
from armside.sim.robot.model import RobotModel, load_model

from .experiments import CHECKS
from .parameters import Trim, compiled

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
"""Start of the search: rounded from earlier searches of the same kind, the first of which started
from a set without gear effects."""

DEVIATIONS: Mapping[str, float] = {
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
"""Standard deviation of a mutation, relative to the value, of each quantity that is varied."""

LOWER_BOUNDS = {"structure_damping": 0.25, "lost_motion": 0.14, "gear_error": 0.4, "ripple": 0.7}
"""Calibration must not remove the faults of gears; modes keep 0.6 % of critical damping."""
MARGIN = 0.05
"""Wanted distance from the end of the band to a number inside, relative to that end."""
MARGINS: Mapping[str, float] = {"a3": 0.0, "c5": 0.0, "e2": 0.0, "f1": 0.0}
"""By id of the check, where it is another."""
CHILDREN = 4  # Candidates of one generation; the best of them is the next parent if it is better
DIGITS = 3
EFFECTS = frozenset(Effect)
_EXPERIMENTS = "experiments"


@dataclass(frozen=True)
class Candidate:
    """A trim, the checks of the robot that it makes, and their distance from the bands."""

    trim: Trim
    checks: tuple[Check, ...]
    score: float
    notes: tuple[Note, ...] = ()
    """Limits that changed its experiments, with their number."""


Task = tuple[Trim, float]
"""A trim to evaluate, and the score at which to give up."""
Map = Callable[[Callable[[Task], Candidate], Iterable[Task]], Iterable[Candidate]]


def checks(model: RobotModel) -> tuple[list[Check], list[Note]]:
    """All targets of calibration for a robot, and notes of the experiments."""
    said = Tally()
    found = [check for part in CHECKS for check in part(model, EFFECTS, said.add)]
    return found, said.notes(_EXPERIMENTS)


def outside(check: Check) -> float:
    """Distance from the band less its margin, in parts of the band's larger end; 0 inside."""
    margin = MARGINS.get(check.id, MARGIN)
    short, ends = 0.0, [0.05]
    if check.low is not None:
        short = max(short, check.low + margin * abs(check.low) - check.ours)
        ends.append(abs(check.low))
    if check.high is not None:
        short = max(short, check.ours - check.high + margin * abs(check.high))
        ends.append(abs(check.high))
    return short / max(ends)


def score(found: Iterable[Check]) -> float:
    """Sum of the distances of all numbers from their bands, margins included."""
    return sum(map(outside, found))


def evaluate(trim: Trim, give_up_at: float = np.inf) -> Candidate:
    """Run the experiments of a trim; stop where its score cannot get better than `give_up_at`."""
    model = load_model(compiled(assets.LARGE_ROBOT_XML, trim))
    found, said = list[Check](), Tally()
    for part in CHECKS:
        found.extend(part(model, EFFECTS, said.add))
        if score(found) > give_up_at:
            break
    return Candidate(trim, tuple(found), score(found), tuple(said.notes(_EXPERIMENTS)))


def _evaluate(task: Task) -> Candidate:
    return evaluate(*task)


def mutate(trim: Trim, rng: np.random.Generator) -> Trim:
    """Another trim: one to three of its quantities drawn around their values."""
    chosen = rng.choice(list(DEVIATIONS), size=rng.integers(1, 4), replace=False)
    changes: dict[str, Any] = {}
    for name in map(str, chosen):
        value = np.asarray(getattr(trim, name), dtype=np.float64)
        which = rng.random(value.shape) < 0.5 if value.ndim else True
        factor = 1.0 + DEVIATIONS[name] * rng.standard_normal(value.shape) * which
        changed = np.maximum(_rounded(value * factor), LOWER_BOUNDS.get(name, 0.0))
        if name == "velocity_feedforward":
            changed = np.minimum(changed, 1.0)
        changes[name] = tuple(map(float, changed)) if value.ndim else float(changed)
    return replace(trim, **changes)


def _rounded(values: Any) -> Any:
    """Three significant digits: the numbers that are written are those that were run."""
    magnitude = 10.0 ** (DIGITS - 1 - np.floor(np.log10(np.maximum(np.abs(values), 1e-12))))
    return np.round(np.abs(values) * magnitude) / magnitude


def search(start: Trim, generations: int, seed: int, map_: Map) -> Iterator[Candidate]:
    """The best candidate after each generation; stops when every number is well inside its band.

    map_: runs the candidates of a generation, such as `map` or that of a pool of processes.
    """
    rng = np.random.default_rng(seed)
    best = evaluate(start)
    for _ in range(generations):
        if best.score == 0.0:
            return
        children = [(mutate(best.trim, rng), best.score) for _ in range(CHILDREN)]
        best = min([best, *map_(_evaluate, children)], key=lambda c: c.score)
        yield best
