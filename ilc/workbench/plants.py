"""Plants by name: a model's file, the joint of chapter 8, and a user's own, `file.py:Name`."""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array

from ..measures.norms import two_norm
from ..models.conversion import as_state_space, as_system, simplest
from ..models.file import read_model
from ..models.linear_plant import LinearPlant
from ..models.state_space import StateSpace
from ..models.system import System, require_stable
from ..models.system_matrix import Model, SystemMatrix
from ..models.two_mass import (
    FrictionPlant,
    TwoMassJoint,
    TwoMassLoop,
    TwoMassPlant,
    TwoMassRun,
    step_reference,
)
from ..records import records
from .own import built, in_code_of, load
from .signals import named_reference
from .task import Task
from .words import Words, guessed, number, unknown_name

JOINT_CUTOFF, JOINT_DESIGN = 17.0, (0.9, 5)
"""Design of thesis Figs 8.8 to 8.12 with the highest cutoff of them."""


@dataclass(frozen=True, kw_only=True)
class Record:
    """What is asked for beside the plant."""

    reference: str = ""
    """step, ramp or a CSV file; empty: the plant's own, or step."""
    n_samples: int = 400
    sample_time: float | None = None
    """[s]; None: the plant's own."""
    model: Model | None = None
    """Model in place of the plant's own."""


def linear(name: str, T_u: Model, record: Record) -> Task:
    """y = T_u (r + u). Raises ValueError for an unstable model."""
    require_stable(T_u, "the plant")
    if record.sample_time is not None and not np.isclose(record.sample_time, T_u.sample_time):
        times = f"{T_u.sample_time:g} s, got {record.sample_time:g} s"
        raise ValueError(f"{name} has a sample time of {times}")
    n = T_u.n_inputs
    r = named_reference(record.reference or "step", record.n_samples, n, T_u.sample_time)
    return Task(
        name=name,
        reference=r,
        sample_time=T_u.sample_time,
        start=lambda repetition: LinearPlant(T_u=T_u, reference=r),
        model=T_u if record.model is None else record.model,
        exact=record.model is None,
    )


def model_task(file: Path, record: Record) -> Task:
    """Task of a model's file, JSON or MAT."""
    return linear(file.name, read_model(file), record)


def joint(words: Words, record: Record) -> Task:
    """Joint of chapter 8, `two-mass:k=4,d=0.2,coulomb=0.01`: fields of `TwoMassJoint`."""
    names = [each.name for each in fields(TwoMassJoint)]
    for key in words.parameters:
        if key not in (*names, "coulomb"):
            raise ValueError(unknown_name("parameter", key, (*names, "coulomb")))
    values = {key: float(number(text, key)) for key, text in words.parameters.items()}
    coulomb = values.pop("coulomb", 0.0)
    loop = TwoMassLoop(joint=TwoMassJoint(**values))
    if record.sample_time is not None:
        loop = TwoMassLoop(joint=loop.joint, sample_time=record.sample_time)
    arm = step_reference(sample_time=loop.sample_time)
    if record.reference:
        arm = named_reference(record.reference, record.n_samples, 1, loop.sample_time)
    plant = TwoMassPlant(loop=loop, arm_reference=arm)
    rubbing = FrictionPlant(loop=loop, arm_reference=arm, coulomb=coulomb) if coulomb else plant

    def measures(run: TwoMassRun) -> dict[str, float]:
        return {"arm": float(two_norm(arm - run.arm)[0])}

    return Task(
        name=words.text,
        reference=plant.motor_reference,
        sample_time=loop.sample_time,
        start=lambda repetition: rubbing,
        output_of=lambda run: run.motor,
        measures_of=measures,
        model=loop.T_motor if record.model is None else record.model,
        exact=record.model is None and coulomb == 0.0,
        cutoff=min(JOINT_CUTOFF, 0.17 / loop.sample_time),
        design=JOINT_DESIGN if record.model is None else None,
    )


@dataclass(frozen=True, eq=False)
class OwnPlant:
    """A user's plant, what it raises reported with its line."""

    plant: Any
    file: Path

    @records("correction")
    def run(self, correction: Array, /) -> Array:
        """(N, n); a plant with one output may return (N,)."""
        with in_code_of(self.file):
            found = np.asarray(self.plant.run(correction.copy()))
        return found[:, None] if found.ndim == 1 else found


def own_plant(words: Words, record: Record, seed: int) -> Task:
    """Plant `file.py:Name`: a System, a model of `control`, or an object with run(correction).

    A class or function may ask for seed, rng, sample_time or reference by name. An object may have
    attributes reference, sample_time and model.

    Raises ValueError for something that is no plant, OwnCodeError for what the file raises.
    """
    file, parameters = Path(words.file), guessed(words.parameters)
    asked = None
    if record.reference and record.sample_time is not None:
        asked = named_reference(record.reference, record.n_samples, 1, record.sample_time)

    def start(repetition: int) -> Any:
        rng = np.random.default_rng((seed, repetition))
        offered = {"seed": seed + repetition, "rng": rng, "sample_time": record.sample_time}
        found = load(file, words.name)
        if isinstance(found, System) or (hasattr(found, "run") and not isinstance(found, type)):
            return found
        if hasattr(found, "dt"):  # a model of the package control, which may be callable
            return found
        return built(found, file, offered | {"reference": asked}, parameters)

    first = start(0)
    if not hasattr(first, "run"):
        try:
            return linear(words.text, as_model(first), record)
        except ValueError as error:
            needed = "an object with run(correction), a System or a discrete model of control"
            raise ValueError(f"{words.text} must be {needed}: {error}") from error
    T = record.sample_time or getattr(first, "sample_time", None)
    if not isinstance(T, (int, float)) or not T > 0.0:
        raise ValueError(f"{words.text} has no sample_time: add the attribute or --sample-time")
    own = getattr(first, "reference", None)
    if record.reference or own is None:
        r = named_reference(record.reference or "step", record.n_samples, 1, float(T))
    else:
        r = np.asarray(own, dtype=np.float64).reshape(len(own), -1)
    model = record.model if record.model is not None else getattr(first, "model", None)
    return Task(
        name=words.text,
        reference=r,
        sample_time=float(T),
        start=lambda repetition: OwnPlant(start(repetition), file),
        generators_of=_own_generators,
        model=None if model is None else as_model(model),
    )


def as_model(model: Any) -> Model:
    """One of ours, or of control or scipy: a System where that holds it, else a StateSpace."""
    if isinstance(model, System | SystemMatrix | StateSpace):
        return model
    known = as_state_space(model)
    has_polynomials = not hasattr(model, "A") and (known.n_inputs, known.n_outputs) == (1, 1)
    return as_system(model) if has_polynomials else simplest(known)


def _own_generators(plant: OwnPlant) -> list[np.random.Generator]:
    """Attribute `rng` of a user's plant, where its noise continues."""
    rng = getattr(plant.plant, "rng", None)
    return [rng] if isinstance(rng, np.random.Generator) else []
