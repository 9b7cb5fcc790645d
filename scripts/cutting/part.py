"""A part as the options of `armside cut` ask: read, planned, and prepared for its first run."""

from pathlib import Path
from typing import Any

from armside.sim.laser.learning import MEASURES
from armside.sim.laser.measures import Measure, MotorAngles, SetUp
from armside.sim.part.chain import MM
from armside.sim.part.file import read_part
from armside.sim.part.plan import Plan
from armside.sim.part_run.experiment import Job, PartExperiment, prepare
from armside.sim.part_run.experiment import planned as plan_of
from armside.sim.part_run.learning import learn
from armside.sim.part_run.results import results, rows_of
from armside.sim.records.files import check_file

from ..shell.effort import refuse_absurd
from ..shell.errors import InputError
from .earlier import Earlier
from .effort import effort
from .first_cut import ByTwin, corrected_part
from .part_options import CutCfg, cutting, reading, setup


def part_of(file: Path | None, before: Earlier | None) -> Path:
    """The drawing that was given, or that of the earlier run. Raises InputError for none."""
    if file is not None:
        return file
    if before is None:
        raise InputError("a drawing is needed (.dxf, .svg, .toml), or --from RUN")
    return check_file(Path(before.run.summary["part"]))


def planned(file: Path, cfg: CutCfg) -> tuple[Job, Plan]:
    """A drawing in its cell, and its plan.

    Raises ValueError for a drawing that cannot be cut, with the place, and InputError for one that
    would take too long.
    """
    try:
        part = read_part(file, reading(cfg))
    except ModuleNotFoundError as error:
        raise ValueError(
            f"drawings need packages: pip install 'armside[parts]' ({error})"
        ) from error
    length, runs = sum(contour.chain.length for contour in part.contours), cfg.iterations + 1
    what = f"{runs} runs along {length / MM:.4g} mm at {cfg.speed:g} mm/s"
    estimated = cfg.measure == "estimate"
    refuse_absurd(what, effort(length, cfg.speed * MM, runs, estimated=estimated))
    job = Job(part=part, cutting=cutting(cfg), setup=setup(cfg), across_tool=cfg.plane == "tool")
    return job, plan_of(job)


def prepared(job: Job, plan: Plan, cfg: CutCfg, seed: int) -> tuple[PartExperiment, SetUp]:
    """The part before its first run, and what is learned from.

    Raises ValueError where the part leaves the reach or the limits, with the place.
    """
    experiment = prepare(job, plan, seed=seed)
    return experiment, _measure(cfg).prepare(experiment)


def by_twin_of(folder: Path, experiment: PartExperiment, cfg: CutCfg) -> tuple[ByTwin, SetUp]:
    """A twin's correction along the part, and what is learned from around it.

    Raises InputError for a folder without a twin, or one of another robot.
    """
    found = corrected_part(folder, experiment)
    return found, found.around(_measure(cfg), experiment).prepare(experiment)


def _measure(cfg: CutCfg) -> Measure:
    return MotorAngles() if cfg.measure == "motor" else MEASURES[cfg.measure]


def uncorrected(job: Job, plan: Plan, cfg: CutCfg, seed: int) -> dict[str, Any]:
    """Measures of all contours in a first run without correction."""
    experiment, set_up = prepared(job, plan, cfg, seed)
    (first,) = learn(experiment, set_up, 0)
    return results(experiment, [rows_of(first)])["iterations"][0]


def plan_entries(found: Plan) -> dict[str, Any]:
    """The plan as summary.json has it. SI units."""
    return {
        "seconds": found.seconds,
        "contours": [
            {
                "name": cut.contour.name,
                "kind": cut.contour.kind,
                "length": cut.path.length - 2.0 * cut.lead,
                "asked_speed": found.cutting.speed,
                "reached_speed": cut.reached_speed,
                "seconds": cut.seconds,
                "iterations": [],
            }
            for cut in found.cuts
        ],
    }
