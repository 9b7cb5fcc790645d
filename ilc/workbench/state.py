"""State of a learning experiment on disk: loop, memory of the law, sources of noise.

One .npz file without pickled objects. A memory may be None, a number, text, an array, and tuples,
lists and dicts of these; named tuples of our laws come back as themselves.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array

from ..laws.by_segment import SegmentMemory
from ..laws.guarded import Best
from ..laws.knob_free import Known
from ..learning import LoopState

NAMED: Mapping[str, Callable[..., Any]] = {
    "Best": Best,
    "Known": Known,
    "SegmentMemory": SegmentMemory,
}
"""Named tuples that a memory may hold."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RunState:
    """State after the last run of one law."""

    loop: LoopState
    generators: Sequence[Mapping[str, Any]] = ()
    """States of the bit generators of all noise, in a fixed order."""
    start: Array | None = None
    """u_0, (N, n), that the law learns around; None for a loop from zero."""

    def restore(self, generators: Sequence[np.random.Generator]) -> None:
        """Set sources of noise to the stored states. ValueError if they are others."""
        if len(generators) != len(self.generators):
            counts = f"{len(self.generators)} sources of noise, this one has {len(generators)}"
            raise ValueError(f"the stored run had {counts}")
        for generator, state in zip(generators, self.generators, strict=True):
            generator.bit_generator.state = state


def states_of(generators: Sequence[np.random.Generator]) -> tuple[Mapping[str, Any], ...]:
    """States of bit generators, to be stored."""
    return tuple(dict(generator.bit_generator.state) for generator in generators)


def save_states(file: Path, states: Mapping[str, RunState]) -> list[str]:
    """Write states by key; the keys of those that cannot be stored, for their law's memory."""
    arrays: dict[str, Any] = {}
    trees: dict[str, Any] = {}
    unstored: list[str] = []
    for key, state in states.items():
        loop = state.loop
        content = {
            "k": loop.k,
            "correction": loop.correction,
            "error": loop.error,
            "memory": loop.memory,
            "first_size": loop.first_size,
            "generators": [dict(each) for each in state.generators],
            "start": state.start,
        }
        try:
            trees[key] = _packed(content, arrays)
        except TypeError:
            unstored.append(key)
            trees[key] = _packed(content | {"memory": None, "unstored": True}, arrays)
    with file.open("wb") as stream:
        np.savez(stream, tree=np.array(json.dumps(trees)), **arrays)  # type: ignore[arg-type]
    return unstored


def read_states(file: Path) -> dict[str, RunState | None]:
    """States by key; None where a memory could not be stored. ValueError for a damaged file."""
    try:
        with np.load(file, allow_pickle=False) as stored:
            trees = json.loads(str(stored["tree"]))
            contents = {key: _unpacked(tree, stored) for key, tree in trees.items()}
            return {key: _state(content) for key, content in contents.items()}
    except Exception as error:  # numpy, zipfile and json raise many kinds
        raise ValueError(f"{file} holds no state of a learning run: {error}") from error


def _state(content: dict[str, Any]) -> RunState | None:
    if content.get("unstored"):
        return None
    names = ("k", "correction", "error", "memory", "first_size")
    loop = LoopState(**{name: content[name] for name in names})
    generators = tuple(content["generators"])
    return RunState(loop=loop, generators=generators, start=content.get("start"))


def _packed(value: Any, arrays: dict[str, Any]) -> Any:
    if value is None or isinstance(value, (bool, int, float, str)):
        return {"plain": value}
    if isinstance(value, (np.ndarray, np.generic)):
        array = np.asarray(value)
        if array.dtype.kind not in "biufcU":
            raise TypeError(f"an array of {array.dtype}")
        name = f"array_{len(arrays)}"
        arrays[name] = array
        return {"array": name}
    if isinstance(value, Mapping):
        return {"dict": [[_packed(k, arrays), _packed(v, arrays)] for k, v in value.items()]}
    if isinstance(value, (tuple, list)):
        kind = type(value).__name__
        if kind not in ("tuple", "list", *NAMED):
            raise TypeError(f"a {kind}")
        return {"items": [_packed(item, arrays) for item in value], "kind": kind}
    raise TypeError(f"a {type(value).__name__}")


def _unpacked(tree: Any, arrays: Any) -> Any:
    if "plain" in tree:
        return tree["plain"]
    if "array" in tree:
        return arrays[tree["array"]]
    if "dict" in tree:
        return {_unpacked(k, arrays): _unpacked(v, arrays) for k, v in tree["dict"]}
    items = [_unpacked(item, arrays) for item in tree["items"]]
    if tree["kind"] in NAMED:
        return NAMED[tree["kind"]](*items)
    return tuple(items) if tree["kind"] == "tuple" else items
