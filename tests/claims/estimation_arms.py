"""The estimate on every robot file beside those of the thesis, at each of its poses.

As `estimation-irb1400`; nothing was chosen on these arms.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from armside.assets import IRB1400_XML

from . import estimation_irb1400 as irb1400
from ._engine import Claim
from .estimation_irb1400 import Place, at_poses, of_every_arm


def robot_files() -> Sequence[Path]:
    """Robot files that ship beside the robots of the thesis."""
    thesis = ("irb1400.toml", "large_robot.toml")
    return [file for file in sorted(IRB1400_XML.parent.glob("*.toml")) if file.name not in thesis]


def cases(seeds: Sequence[int]) -> Iterator[Place]:
    yield from at_poses([str(file) for file in robot_files()], seeds)


CLAIM: Claim = replace(
    irb1400.CLAIM,
    title="Learning from an estimate of the tool on other arms: tool deviation RMS in µm",
    seeds=2,
    cases=cases,
    checks=of_every_arm,
)
