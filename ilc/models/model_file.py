"""JSON file with a model of T_u."""

import json
from pathlib import Path

from .system import System


def read_model(file: Path) -> System:
    """T_u from `{"sample_time": 0.004, "b": [0, 0.5], "a": [1, -0.5]}`.

    b, a: coefficients in powers of q^-1; or num, den: in descending powers of q (or z). Raises
    ValueError with the name of the file and the reason.
    """
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
        raise ValueError(f"{file} is not a readable JSON file: {error}") from error
    if not isinstance(content, dict):
        raise ValueError(f"{file} must hold an object with sample_time, b and a")
    keys = ("b", "a") if "b" in content else ("num", "den")
    missing = [key for key in ("sample_time", *keys) if key not in content]
    if missing:
        raise ValueError(f"{file} lacks {', '.join(missing)}; it needs sample_time, b and a")
    build = System if keys == ("b", "a") else System.from_z
    try:
        return build(content[keys[0]], content[keys[1]], content["sample_time"])
    except (TypeError, ValueError) as error:
        raise ValueError(f"{file}: {error}") from error
