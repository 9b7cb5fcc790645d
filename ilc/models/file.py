"""File with a model of T_u: a transfer function or a state space, in JSON or MATLAB's MAT."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from ..records import as_real
from .conversion import as_state_space, as_system, simplest
from .state_space import StateSpace
from .system import System
from .system_matrix import Model

STATE_SPACE = ("A", "B", "C")
MOST_STATES = 200


def read_model(file: Path) -> Model:
    """T_u from `{"sample_time": 0.004, "b": [0, 0.5], "a": [1, -0.5]}`.

    b, a: coefficients in powers of q^-1; or num, den: in descending powers of q (or z); or A, B, C
    and perhaps D of a discrete state space, with as many outputs as inputs. A MAT file (up to
    version 7) holds variables of the same names.

    Raises ValueError with the name of the file and the reason.
    """
    content = _mat(file) if file.suffix.lower() == ".mat" else _json(file)
    kinds = [keys for keys in (("b", "a"), ("num", "den"), STATE_SPACE) if keys[0] in content]
    keys = kinds[0] if kinds else ("b", "a")
    missing = [key for key in ("sample_time", *keys) if key not in content]
    if missing:
        forms = "b and a, num and den, or A, B, C"
        raise ValueError(f"{file} lacks {', '.join(missing)}; it needs sample_time and {forms}")
    try:
        if keys == STATE_SPACE:
            return _state_space(content)
        build = System if keys == ("b", "a") else System.from_z
        return build(content[keys[0]], content[keys[1]], content["sample_time"])
    except (TypeError, ValueError) as error:
        raise ValueError(f"{file}: {error}") from error


def read_system(file: Path) -> System:
    """As `read_model`, for a model with one input and one output."""
    model = read_model(file)
    try:
        return as_system(model)
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from error


def write_model(file: Path, model: Model) -> None:
    """Write a model with every digit, as `read_model` reads it. JSON.

    A matrix of systems becomes a state space. One that is identified may have more inputs than
    outputs, or fewer, which `read_model` refuses. Raises ValueError for too many states.
    """
    content: dict[str, Any]
    if isinstance(model, System):
        content = {"b": model.b.tolist(), "a": model.a.tolist()}
    else:
        model = as_state_space(model)
        _check_size(len(model.A))
        matrices = {"A": model.A, "B": model.B, "C": model.C, "D": model.feedthrough}
        content = {name: M.tolist() for name, M in matrices.items()}
    content = {"sample_time": model.sample_time} | content
    file.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def _json(file: Path) -> dict[str, Any]:
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise ValueError(f"{file} is not a readable JSON file: {error}") from error
    if not isinstance(content, dict):
        raise ValueError(f"{file} must hold an object with sample_time, b and a")
    return content


def _mat(file: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    try:
        found = loadmat(file)
    except Exception as error:  # scipy raises many kinds for a damaged file
        raise ValueError(f"{file} is not a readable MAT file: {error}") from error
    arrays = {name: value for name, value in found.items() if not name.startswith("__")}
    flat = {name: np.ravel(value) for name, value in arrays.items() if name not in "ABCD"}
    if (time := flat.get("sample_time")) is not None:
        if time.size != 1 or time.dtype.kind not in "iuf":
            raise ValueError(f"{file}: sample_time must be one number")
        return arrays | flat | {"sample_time": float(time[0])}
    return arrays | flat


def _state_space(content: dict[str, Any]) -> Model:
    A, B, C = (np.atleast_2d(as_real(content[name], name)) for name in STATE_SPACE)
    n = len(A)
    B = B.T if B.shape != (n, B.shape[1]) and B.shape[1] == n and len(B) == 1 else B
    D = np.atleast_2d(as_real(content.get("D", np.zeros((len(C), B.shape[1]))), "D"))
    if A.shape != (n, n) or len(B) != n or C.shape[1] != n or D.shape != (len(C), B.shape[1]):
        shapes = ", ".join(str(matrix.shape) for matrix in (A, B, C, D))
        raise ValueError(f"A, B, C, D do not fit each other: {shapes}")
    if len(C) != B.shape[1]:
        raise ValueError(f"as many outputs as inputs are needed, got {len(C)} and {B.shape[1]}")
    _check_size(n)
    if not all(np.isfinite(matrix).all() for matrix in (A, B, C, D)):
        raise ValueError("A, B, C, D must be finite")
    return simplest(StateSpace(A, B, C, D, content["sample_time"]))


def _check_size(n_states: int) -> None:
    if n_states > MOST_STATES:
        raise ValueError(f"at most {MOST_STATES} states are taken, got {n_states}")
