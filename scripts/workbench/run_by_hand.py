"""`armside learn` on a folder: a person runs the task and brings the logs."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from armside.arrays import Array
from armside.ilc.divergence import has_diverged
from armside.ilc.laws.first_order import Law
from armside.ilc.measures.norms import two_norm
from armside.ilc.models.file import read_model
from armside.ilc.workbench.compare import LawRun
from armside.ilc.workbench.exchange import ByHand, Folder
from armside.ilc.workbench.laws import MEASURING, build_law
from armside.ilc.workbench.signals import file_reference, read_signal
from armside.ilc.workbench.task import Setting
from armside.ilc.workbench.words import Words
from armside.sim.records.files import check_can_write

from ..shell.errors import InputError
from .options import LearnCfg

REFERENCE = "reference.csv"


@dataclass(frozen=True, eq=False)
class Session:
    """An experiment by hand."""

    cfg: LearnCfg
    folder: Folder
    reference: Array
    name: str
    """Words that name the law."""
    law: Law

    @classmethod
    def begin(cls, cfg: LearnCfg) -> "Session":
        """Raises ValueError for a folder or options that cannot be used."""
        name, *others = cfg.laws
        if others or cfg.repeats > 1 or cfg.noise != (0.0,) or cfg.start is not None:
            raise InputError("by hand takes one law, without --noise, --repeats and --from")
        if Words.parse(name).name in MEASURING:
            raise InputError(f"{name} needs runs of its own: it cannot be used by hand")
        path = Path(cfg.plant)
        check_can_write(path)
        file = Path(cfg.reference) if cfg.reference else path / REFERENCE
        if not file.is_file():
            raise InputError(f"no reference {file}: put {REFERENCE} there, or give --reference")
        model = None if cfg.model is None else read_model(cfg.model)
        T = cfg.sample_time or read_signal(file).sample_time
        if T is None:
            raise InputError(f"{file} has no column time: give --sample-time")
        reference = file_reference(file, None, T)

        def no_run(correction: Array) -> Array:
            raise ValueError("a plant run by hand takes no runs beside the loop's own")

        setting = Setting(
            sample_time=T,
            reference=reference,
            model=model,
            cutoff=0.1 / T,
            experiment=no_run,
        )
        return cls(cfg, Folder(path, T), reference, name, build_law(name, setting))

    def advance(self) -> ByHand:
        """Read the logs that are there; write the correction that is waited for."""
        return self.folder.advance(self.law, self.reference, self.cfg.iterations)

    def request(self, k: int) -> str:
        """The sentence that asks for a log."""
        u, y = self.folder.correction(k), self.folder.output(k)
        return f"Run the task with {u}, put its log into {y}, and give this command again."

    def result(self, state: ByHand) -> LawRun:
        """Result of a finished experiment."""
        errors = state.errors
        sizes = [two_norm(error) for error in errors]
        return LawRun(
            law=self.name,
            noise=0.0,
            repetition=0,
            first_k=0,
            norms=np.array([float(np.linalg.norm(error)) for error in errors]),
            largest=np.array([np.abs(error).max() for error in errors]),
            measures=[],
            correction=state.corrections[len(errors) - 1],
            diverged=has_diverged(sizes[-1], sizes[0]),
            state=None,
        )
