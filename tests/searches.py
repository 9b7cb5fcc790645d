"""Searches that many tests ask for with the same record: each is made once in a session.

A search is a function of what it is given, bit for bit. Its result is stored under a digest of all
of that, in a folder that the workers of pytest-xdist share, and of the settings that tests change.
"""

import hashlib
import pickle
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import wraps
from importlib import import_module
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

SEARCHES = (
    ("armside.sim.estimation.commissioning", "identify"),
    ("armside.sim.laser.identification", "identify"),
    ("armside.sim.twin.commission", "identify"),
)
"""Springs of a record, and a twin of its cuts: module that calls, and the name that it calls."""


def digest(value: Any, of: "hashlib._Hash") -> None:
    """Add a value to a digest: numbers, arrays, models of MuJoCo, and what is made of them."""
    of.update(type(value).__name__.encode() + b"(")
    if isinstance(value, np.ndarray):
        of.update(f"{value.dtype}{value.shape}".encode() + value.tobytes())
    elif isinstance(value, mujoco.MjModel):
        buffer = np.empty(mujoco.mj_sizeModel(value), np.uint8)
        mujoco.mj_saveModel(value, None, buffer)
        of.update(buffer.tobytes())
    elif isinstance(value, mujoco.MjSpec):
        of.update(value.to_xml().encode())
    elif is_dataclass(value):
        for each in fields(value):
            digest(getattr(value, each.name), of)
    elif isinstance(value, Mapping):
        digest(list(value.items()), of)
    elif isinstance(value, (str, int, float, slice, Path, np.generic, type(None))):
        of.update(repr(value).encode())
    elif isinstance(value, (Sequence, frozenset)):
        for each in sorted(value) if isinstance(value, frozenset) else value:
            digest(each, of)
    else:
        raise TypeError(f"a search is given {type(value)}, which has no digest")
    of.update(b")")


def once(search: Callable[..., Any], made_once: Callable[..., Path]) -> Callable[..., Any]:
    """A search whose result is stored; without its progress where it is found."""
    from armside.ilc.estimation import prediction_error

    @wraps(search)
    def found(*given: Any, **named: Any) -> Any:
        settings = [v for k, v in vars(prediction_error).items() if k.isupper()]
        of = hashlib.sha256(search.__module__.encode())
        try:
            digest([settings, [each for each in given if not callable(each)], named], of)
        except TypeError:  # a test's own stand-in
            return search(*given, **named)

        def make(folder: Path) -> None:
            folder.mkdir(parents=True)
            (folder / "found").write_bytes(pickle.dumps(search(*given, **named)))

        return pickle.loads((made_once(of.hexdigest()[:16], make) / "found").read_bytes())

    return found


def make_once(made_once: Callable[..., Path], patch: Any) -> None:
    """Store the results of all searches."""
    for module, name in SEARCHES:
        caller = import_module(module)
        patch.setattr(caller, name, once(getattr(caller, name), made_once))
