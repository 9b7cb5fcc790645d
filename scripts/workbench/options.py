"""Options of `armside learn`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from armside.sim.controller.gate import Beyond

from ..shell.options import SEVERAL, SOME, FileToRead, Limits, check_limits, options

SAMPLE_TIME = Limits(1e-9, 1e6, "s")
LIMITS = {
    "iterations": Limits(0, 10_000),
    "samples": Limits(1, 100_000),
    "repeats": Limits(1, 1000),
    "noise": Limits(0.0, 1e100),
    "sample_time": SAMPLE_TIME,
    "wait": Limits(0.0, 1e7, "s"),
}
"""Beyond them a comparison takes hours."""


@options
@dataclass(frozen=True, kw_only=True)
class LearnCfg:
    """Plant, laws and task."""

    plant: str = "two-mass"
    """two-mass[:k=4,coulomb=0.01] (joint of chapter 8), large or irb1400[:pose=p2,speed=60] or a
    robot file FILE.toml (options of laser), egm[:port=6510] or rsi[:port=59152] (a controller that
    speaks ABB's or KUKA's protocol to this port), a model's file (JSON, MAT), file.py:Name (a
    System, a model of control, or an object with run(correction)), or a folder that a person
    exchanges files in."""
    laws: Annotated[tuple[str, ...], SEVERAL] = ("heuristic",)
    """Laws to compare, each NAME, NAME:key=value,key=value or file.py:Name. Names: heuristic,
    d-type, gradient, inverse, norm-optimal, constrained, adaptive, high-order, periodic,
    disturbance-observer, model-free, splines, knob-free, basis, rational, point-to-point, kalman,
    repetitive, h-infinity."""
    iterations: int = 10
    """Updates; one run more."""
    reference: str | None = None
    """step, ramp, or a CSV file with a column for each output, and perhaps one named time [s]
    [default: that of the plant, or step]."""
    samples: int = 400
    """Length of a step or ramp."""
    sample_time: float | None = None
    """[s], where the plant does not state it."""
    model: FileToRead = None
    """Model that laws and prediction assume, JSON or MAT [default: that of the plant]."""
    noise: Annotated[tuple[float, ...], SEVERAL] = (0.0,)
    """Standard deviations of white noise on the measured output, each a comparison."""
    repeats: int = 1
    """Repetitions with other noise; the table shows the mean."""
    wait: float = 0.0
    """Seconds to wait for each log in a folder, before leaving it for later."""
    beyond: Annotated[tuple[Beyond, ...], SOME] = ()
    """On a controller: what is sent although the gate would hold it back (docs/controllers.md)."""
    start: Annotated[Path | None, Parameter(name="--from")] = None
    """Folder of an earlier run. Options not given are that run's; with none changed learning goes
    on where it ended, otherwise it starts from its corrections. Or a file with a correction, as
    `armside export RUN` writes it."""

    def __post_init__(self) -> None:
        check_limits(self, LIMITS)
        if self.reference == "":
            raise ValueError("reference must be step, ramp or the name of a file, got ''")
        if not self.laws or not self.noise:
            raise ValueError("at least one law and one noise level are needed")
        if (work := len(self.laws) * len(self.noise) * self.repeats * self.iterations) > 10**6:
            raise ValueError(f"at most a million runs can be asked for, got {work}")
        if len(set(self.laws)) < len(self.laws) or len(set(self.noise)) < len(self.noise):
            raise ValueError("each law and each noise level can be given once")
