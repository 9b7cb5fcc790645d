"""Folders that `--twin` names: a twin, and damaged or foreign copies of it."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from armside.sim.robot.mjcf import N_AXES
from armside.sim.twin.identification import parameters_of
from armside.sim.twin.twin import Twin, design_of, robot_digest

Content = dict[str, Any]
CHANGES: Mapping[str, Callable[[Content], Any]] = {
    "twin-list": lambda c: [c],
    "twin-empty": lambda c: {},
    "twin-format": lambda c: c | {"format": 99},
    "twin-robot": lambda c: c | {"robot": "irb1400"},
    "twin-other": lambda c: c | {"robot": ["large"]},
    "twin-file": lambda c: c | {"digest": "0" * 16},
    "twin-payload": lambda c: c | {"payload": -1e308},
    "twin-friction": lambda c: c | {"friction": [1e308] * 7},
    "twin-nan": lambda c: c | {"torque_residual": [float("nan")] * N_AXES},
    "twin-huge": lambda c: c | {"parameters": dict.fromkeys(c["parameters"], 1e308)},
    "twin-names": lambda c: c | {"parameters": {"a": 1.0}},
}
"""Changes of twin.json, by the name of the folder."""
BAD = (*CHANGES, "twin-torn", "twin-bare", "twin-covariance", "twin-pipe")
TWINS = ("twin", *BAD)
"""Names of all folders."""


def make(folder: Path) -> None:
    """Fill a folder: the twin is the design itself, as certain as a data sheet."""
    known = parameters_of(design_of("large", None))
    twin = Twin(
        robot="large",
        digest=robot_digest("large"),
        payload=None,
        sensor="tracker",
        theta=known.mean,
        covariance=np.diag(known.standard_deviation**2),
        held_out=np.full(2, 20e-6),
        torque_residual=np.full(N_AXES, 1e-2),
        names=("cut-1", "cut-2"),
    )
    for name in TWINS:
        (folder / name).mkdir()
        twin.save(folder / name)
    for name, change in CHANGES.items():
        file = folder / name / "twin.json"
        file.write_text(json.dumps(change(json.loads(file.read_text()))), encoding="utf-8")
    (folder / "twin-torn" / "twin.json").write_text("{")
    (folder / "twin-bare" / "covariance.npy").unlink()
    np.save(folder / "twin-covariance" / "covariance.npy", -twin.covariance[:7])
    (folder / "twin-pipe" / "twin.json").unlink()
    (folder / "twin-pipe" / "twin.json").symlink_to("../fifo.toml")
