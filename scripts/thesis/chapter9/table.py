"""The experiments of thesis 9.4.1-9.4.5 as data: options that vary, and options that are fixed."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import Any

from armside.sim.laser.design import Design
from armside.sim.laser.job import LearningJob
from armside.sim.laser.specification import Cut

from .bands import POSES, SPEEDS


@dataclass(frozen=True)
class Study:
    """A set of experiments that differ in one or two options."""

    over: Mapping[str, tuple[Any, ...]]
    """Options of `learning_job` that vary, all combinations."""
    fixed: Mapping[str, Any] = field(default_factory=dict)
    """Options that are not the default (40 mm/s, gamma 0.9, delta 3, 10 Hz, five updates)."""
    repetitions: int = 1

    def jobs(self, seed: int) -> dict[Any, LearningJob]:
        """The experiments by their varied values (a tuple where several vary) and repetition."""
        jobs = {}
        for *values, repetition in product(*self.over.values(), range(self.repetitions)):
            options = {**self.fixed, **dict(zip(self.over, values, strict=True))}
            varied = [*values, repetition] if self.repetitions > 1 else values
            job = learning_job(seed, repetition=repetition, **options)
            jobs[tuple(varied) if len(varied) > 1 else varied[0]] = job
        return jobs


def learning_job(
    seed: int,
    *,
    speed: float = 40.0,
    gamma: float | tuple[float, ...] = 0.9,
    delta: int | tuple[int, ...] = 3,
    cutoff: float | tuple[float, ...] = 10.0,
    iterations: int = 5,
    repetition: int = 0,
    series: bool = True,
    **cut: Any,
) -> LearningJob:
    """An experiment in the units of the thesis: speed [mm/s], cutoff [Hz]; cut: fields of `Cut`."""
    variables = {"gamma": gamma, "delta": delta, "cutoff": cutoff}
    each: dict[str, Any] = {k: v if isinstance(v, tuple) else (v,) for k, v in variables.items()}
    run: dict[str, Any] = {"iterations": iterations, "repetition": repetition, "series": series}
    return LearningJob(cut=Cut(speed=1e-3 * speed, **cut), design=Design(**each), seed=seed, **run)


STUDIES: Mapping[str, Study] = {
    # 9.4.1, Fig 9.5: nominal error by position
    "position": Study({"pose": POSES}, {"speed": 50.0, "iterations": 0}),
    # 9.4.1, Fig 9.6: nominal error by velocity; p3 is ours
    "velocity": Study(
        {"speed": tuple(map(float, range(10, 101, 10))), "pose": POSES}, {"iterations": 0}
    ),
    # 9.4.1, (9.10): identical experiments; the thesis has two
    "repeatability": Study({"pose": ("p1",)}, repetitions=12),
    # 9.4.2, Fig 9.7: ten iterations
    "stability": Study({"pose": POSES}, {"speed": 50.0, "iterations": 10}),
    # 9.4.2, (9.11), Fig 9.8: learning at several velocities, two positions
    "identification": Study({"pose": ("p1", "p2"), "speed": SPEEDS}),
    # 9.4.3, Figs 9.9-9.11: learning at each position
    "operating point": Study({"pose": POSES}),
    # 9.4.4, Fig 9.12: the time shift, motor side
    "shift": Study({"delta": tuple(range(1, 9))}, {"speed": 50.0}),
    # 9.4.4, Fig 9.13: the time shift, arm side
    "shift, arm": Study({"pose": ("p1", "p2"), "delta": (3, 6)}),
    # 9.4.5, Figs 9.14, 9.16, 9.17: the cutoff
    "cutoff": Study({"pose": ("p1", "p2"), "cutoff": (10.0, 15.0)}),
    # 9.4.5, Fig 9.15: the cutoff in small steps
    "cutoff, spread": Study(
        {"cutoff": (5.0, 7.5, 10.0, 12.5, 15.0, 17.5, 20.0, 22.5)}, {"speed": 50.0}
    ),
}
"""By name. Experiments that several figures share are run once."""
