"""A user's own law from a file: an object with `step`, or a function of (correction, error)."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from armside.arrays import Array

from ..laws.law import Law
from ..records import as_record, records
from .own import built, in_code_of, load
from .setting import Setting
from .words import Words, guessed


@dataclass(frozen=True, eq=False)
class OwnLaw:
    """A user's law, what it returns checked and what it raises reported with its line."""

    law: Any
    file: Path

    def check(self, n_samples: int, n_columns: int) -> None:
        if hasattr(self.law, "check"):
            with in_code_of(self.file):
                self.law.check(n_samples, n_columns)

    @records("correction", "error")
    def step(self, correction: Array, error: Array, memory: Any = None, /) -> tuple[Array, Any]:
        with in_code_of(self.file):
            if hasattr(self.law, "step"):
                found, memory = self.law.step(correction.copy(), error.copy(), memory)
            else:
                found = self.law(correction.copy(), error.copy())
            following = as_record(found, "the next correction")
            if following.shape != correction.shape:
                shapes = f"{correction.shape}, got {following.shape}"
                raise ValueError(f"the next correction must have shape {shapes}")
        return following, memory


def own_law(words: Words, setting: Setting) -> Law:
    """The law `file.py:Name:key=value`.

    Name is a law, a class whose constructor may ask for any of sample_time, reference, model,
    cutoff and experiment by name, or a function law(correction, error).

    Raises ValueError for something that is no law, OwnCodeError for what the file raises.
    """
    file = Path(words.file)
    found, parameters = load(file, words.name), guessed(words.parameters)
    if isinstance(found, type):
        names = ("sample_time", "reference", "model", "cutoff", "experiment")
        found = built(found, file, {name: getattr(setting, name) for name in names}, parameters)
    elif parameters:
        raise ValueError(f"{words.text}: only a class takes parameters")
    if not (hasattr(found, "step") or callable(found)):
        needed = "an object with step(correction, error, memory), or a function (correction, error)"
        raise ValueError(f"{words.text} is no law: give {needed}")
    return OwnLaw(found, file)
