"""`armside identify-plant`: a model from a record or an experiment, for `learn` and `design`."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

from armside.sim.records.summary import summary

from ..shell.console import Report, run_folder
from ..shell.effort import Effort, refuse_absurd
from ..shell.errors import checking_input
from ..shell.options import SEVERAL, Common, FileToRead, Limits, check_limits, options
from ..workbench.options import SAMPLE_TIME

if TYPE_CHECKING:
    from armside.ilc.workbench.input_output import InputOutput

StructureName = Literal["arx", "armax", "oe", "bj", "subspace"]
SECONDS = 3e-5
"""[s] for each sample, structure and square of the largest order, rounded up."""
LIMITS = {
    "column": Limits(1, 100),
    "periods": Limits(3, 1000),
    "inputs": Limits(1, 20),
    "largest_order": Limits(1, 14),
    "largest_delay": Limits(0, 100),
    "band_fits": Limits(0, 1000),
    "rms": Limits(0.0, 1e100, above=True),
    "highest": Limits(0.0, 1e9, "Hz", above=True),
    "sample_time": SAMPLE_TIME,
    "period": Limits(4, unit="samples"),
}


@options
@dataclass(frozen=True, kw_only=True)
class IdentifyPlantCfg:
    """Source of the record, and the models that are compared."""

    plant: str | None = None
    """Plant to experiment on, in place of a record, as of learn: large:pose=p2, two-mass, a robot
    file FILE.toml, a model's file, file.py:Name."""
    column: int = 1
    """Motor (column of the correction) that the experiment moves."""
    rms: float | None = None
    """Size of the correction of an experiment, in the unit of the plant's correction [default: 2 %
    of the range of the reference]."""
    highest: float | None = None
    """Highest frequency of the multisine of an experiment [Hz] [default: twice the cutoff that the
    plant is learned with]."""
    periods: int = 4
    """Periods of the multisine in an experiment; the first is not used for the response."""
    inputs: int = 1
    """Columns of inputs in a CSV file; those after them are outputs."""
    sample_time: float | None = None
    """[s], where a record does not state it."""
    period: int | None = None
    """Samples of one period of a record with one periodic input: a frequency response too."""
    from_rest: bool = False
    """The record starts at rest at zero: means are not subtracted."""
    structures: Annotated[tuple[StructureName, ...], SEVERAL] = get_args(StructureName)
    """Structures to compare: oe is output error, bj is Box-Jenkins. Records with several inputs or
    outputs are for subspace alone."""
    largest_order: int = 4
    """Orders 1 to this one are tried."""
    largest_delay: int = 10
    """Delays 0 to this one are tried [samples]."""
    validation: FileToRead = None
    """Another record, on which each model is simulated."""
    band_fits: int = 30
    """Repeated fits behind the band of a subspace model in the figure; 0 draws no band."""

    def __post_init__(self) -> None:
        check_limits(self, LIMITS)
        if self.band_fits == 1:
            raise ValueError("band-fits must be 0 or at least 2, got 1")
        if not self.structures or len(set(self.structures)) < len(self.structures):
            raise ValueError("at least one structure is needed, each given once")


def identify_plant(
    record: FileToRead = None,
    /,
    *,
    cfg: IdentifyPlantCfg = IdentifyPlantCfg(),
    common: Common = Common(),
) -> None:
    """Identify a plant: its delay, and the order of each structure by BIC.

    record: CSV with columns time (perhaps), inputs, outputs; or MAT with u, y and perhaps
    sample_time. Without one, an experiment with a multisine on --plant, such as the virtual robot.
    Writes plant.json, which `learn --plant` and `design --model` take, identification.png and
    summary.json.
    """
    import numpy as np

    from armside.ilc.identification.structures import Structure, compare_structures
    from armside.ilc.models.file import write_model
    from armside.ilc.workbench.input_output import read_input_output

    from ..figures import identified_plant as shown

    report = Report(common)
    with checking_input():
        made, fresh = _record(record, cfg, common), None
        n, states = len(made.u), cfg.largest_order * (1 + made.y.shape[1])
        fits = len(cfg.structures) + cfg.band_fits / 30.0
        effort = Effort(n * fits * cfg.largest_order**2 * SECONDS, 8.0 * n * 40 * states)
        refuse_absurd(f"fits of order {cfg.largest_order} to {n} samples", effort)
        if cfg.validation is not None:
            fresh = read_input_output(cfg.validation, made.u.shape[1], cfg.sample_time)
            fresh = fresh if cfg.from_rest else fresh.centred
            if fresh.y.shape[1] != made.y.shape[1]:
                raise ValueError(f"{cfg.validation} must have {made.y.shape[1]} outputs, as the "
                                 f"record has, got {fresh.y.shape[1]}")  # fmt: skip
        measured = shown.periodic_response(made)
    with report.progress("identifying", total=1) as step, checking_input():
        found = compare_structures(  # a record that determines no model is bad input
            made.u, made.y, made.sample_time, [Structure(name) for name in cfg.structures],
            largest_order=cfg.largest_order, largest_delay=cfg.largest_delay,
        )  # fmt: skip
        step()
    outcome = summary("identify-plant", cfg, common, **shown.results(found, made, fresh, measured))
    with run_folder(outcome, common) as folder:
        write_model(folder / "plant.json", found[0].system)
        rng = np.random.default_rng(common.seed)
        shown.draw(folder / "identification.png", found[0], made, measured, cfg.band_fits, rng)
    shown.tables(report, outcome)
    report.results(outcome, folder.path)


def _record(file: Path | None, cfg: IdentifyPlantCfg, common: Common) -> "InputOutput":
    import numpy as np

    from armside.ilc.workbench.input_output import excited, read_input_output

    if (file is None) == (cfg.plant is None):
        raise ValueError("give a record, or --plant to experiment on, and not both")
    if file is not None:
        made = read_input_output(file, cfg.inputs, cfg.sample_time)
        made = made if cfg.from_rest else made.centred
        return made if cfg.period is None else made.with_period(cfg.period)
    from ..workbench.options import LearnCfg
    from ..workbench.plant_option import is_folder, named_task

    asked: dict[str, Any] = {"plant": cfg.plant, "sample_time": cfg.sample_time}
    if cfg.period is not None or is_folder(LearnCfg(**asked)):
        raise ValueError("an experiment sets its own period, and needs a plant that can be run")
    task = named_task(LearnCfg(**asked), common.seed)
    try:
        rms = cfg.rms or 0.02 * float(np.ptp(task.reference, axis=0).max())
        highest = 2.0 * task.default_cutoff if cfg.highest is None else cfg.highest
        rng = np.random.default_rng(common.seed)
        return excited(task, cfg.column, rms, highest, cfg.periods, rng)
    finally:
        task.close()
