"""Sections whose experiments end as told to; imported by the tests and by worker processes."""

import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from armside.scripts.thesis.report import Entry, Part, Section
from armside.sim.evaluation.check import Check


@dataclass(frozen=True)
class ProbeJob:
    """Notes that it ran, then ends."""

    name: str
    log: str
    end: str = "well"
    size: int = 1

    @property
    def cost(self) -> float:
        return 1.0

    def run(self) -> dict[str, np.ndarray]:
        with open(self.log, "a") as log:
            log.write(self.name + "\n")
        if self.end == "killed" and not Path(self.log + ".spare").exists():
            time.sleep(0.5)  # so that others have finished
            os.kill(os.getpid(), signal.SIGKILL)
        if self.end == "raised":
            raise ValueError("this experiment cannot be done")
        if self.end == "slow":
            time.sleep(0.3)
        noise = np.random.default_rng(0).random(self.size - 1)  # takes its space on disk
        return {"value": np.concatenate([[2.0], noise])}


def part(jobs: list[ProbeJob], high: float = 1.0) -> Part:
    def draw(read, folder: Path) -> Section:
        from armside.scripts.figures.canvas import new_figure, save  # workers need no matplotlib

        value = float(np.sum([read(job)["value"][0] for job in jobs]))
        figure = new_figure(2.0, 1.0)
        figure.subplots().plot([0, value])
        save(figure, folder / "probe.png")
        return Section(
            "probe",
            "A <probe> & more",
            "Twos, added.",
            ["probe.png"],
            [Check("p1", "sum", "small", value, high=high, reason="twos")],
        )

    return Part(jobs, draw)


def _log() -> str:
    return str(Path("ran.log").absolute())


SEEDS: list[int] = []
"""That `three` was made with."""


def three(seed: int) -> Part:
    SEEDS.append(seed)
    return part([ProbeJob(name, _log()) for name in "abc"])


def one_killed(seed: int) -> Part:
    return part([*(ProbeJob(name, _log()) for name in "abc"), ProbeJob("k", _log(), "killed")])


def one_raised(seed: int) -> Part:
    return part([ProbeJob("a", _log()), ProbeJob("r", _log(), "raised")])


def slow(seed: int) -> Part:
    return part([ProbeJob(f"{i}", _log(), "slow") for i in range(12)])


def large(seed: int) -> Part:
    return part([ProbeJob("a", _log()), ProbeJob("b", _log(), "slow", size=100_000)])


def entries(names: tuple[str, ...]) -> tuple[Entry, ...]:
    """The probe sections of these names, as `armside reproduce` knows sections."""
    made = globals()
    return tuple(Entry(name, lambda asked, make=made[name]: make(asked.seed)) for name in names)
