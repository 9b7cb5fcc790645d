"""The claims of `armside verify estimation-controls`: variants of sensor, model and law compared.

Estimation error (3D RMS) of the first run, and the tool's deviation after five updates.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from armside.arrays import Array
from armside.sim.estimation.arm_identification import prepared
from armside.sim.estimation.arm_springs import SpringPrior
from armside.sim.estimation.imu_health import ImuError, repaired
from armside.sim.estimation.kinematic_filter import kinematic_deviation
from armside.sim.estimation.tool_law import ToolLawKind
from armside.sim.evaluation.check import Table, all_hold
from armside.sim.instruments.imu import ImuCfg, TriadCfg
from armside.sim.laser.comparison import COMPARED, Case, rms
from armside.sim.laser.experiment import Pass
from armside.sim.laser.path_error import path_error, rigid_path
from armside.sim.laser.results import notes
from armside.sim.laser.specification import Cut
from armside.sim.laser.tool_measure import ToolOutput, ToolPath
from armside.sim.notes import Note, counted
from armside.sim.robot.effects import Effect

from ..jobs.workers import Workers

POSES = ("p1", "p2", "p3")
UPDATES = 5
_DEFAULT = "identified (the default)"
_KINEMATICS, _NO_DYNAMICS = "motor-angle kinematics", "kinematic filter, no dynamics"
SILENCED = 1e3  # noise of a sensor that is excluded from the estimate, over its own


class Variant(NamedTuple):
    """Unit at the tool, measured output, and runs averaged in each iteration."""

    unit: ImuCfg
    measure: ToolPath = COMPARED
    repeats: int = 1


def variants() -> dict[str, Variant]:
    """Variants by name."""
    unit = ImuCfg()

    def noisy(factor: float) -> Variant:
        a, omega = (_louder(triad, factor) for triad in (unit.accelerometer, unit.gyroscope))
        return Variant(replace(unit, accelerometer=a, gyroscope=omega))

    def commissioned(**options: Any) -> ToolPath:
        return replace(COMPARED, commissioning=replace(COMPARED.commissioning, **options))

    def by_law(kind: ToolLawKind) -> ToolPath:
        return replace(COMPARED, law=replace(COMPARED.law, kind=kind))

    unknown = commissioned(identified=False, law_identified=False)
    no_clock = commissioned(prior=SpringPrior(clock=1e-7))
    deaf = replace(unit, accelerometer=_louder(unit.accelerometer, SILENCED))
    found = {
        _DEFAULT: Variant(unit),
        "springs of gears only": Variant(unit, commissioned(prior=SpringPrior(coupling=0.0))),
        "not identified": Variant(unit, unknown),
        "not identified, 4 runs averaged": Variant(unit, unknown, repeats=4),
        "law from the wrong stiffness": Variant(unit, commissioned(law_identified=False)),
        "heuristic law": Variant(unit, by_law(ToolLawKind.HEURISTIC)),
        "norm-optimal law": Variant(unit, by_law(ToolLawKind.NORM_OPTIMAL)),
        # Gravity is then unobservable: its check must let everything pass.
        "gyro only": Variant(deaf, commissioned(prior=SpringPrior(mounting=1.0))),
        "accelerometer only": Variant(replace(unit, gyroscope=_louder(unit.gyroscope, SILENCED))),
        "noise / 8": noisy(1 / 8),
        "noise x 4": noisy(4.0),
    }
    for rate in (50.0, 250.0, 500.0):
        found[f"IMU at {rate:g} Hz"] = Variant(replace(unit, rate=rate))
    for limit in (0.0, 0.002, 0.005, 0.010):
        clock = replace(unit, clock_offset=limit)
        found[f"clock within {1e3 * limit:g} ms, not estimated"] = Variant(clock, no_clock)
    return found


def _louder(triad: TriadCfg, factor: float) -> TriadCfg:
    """A noisier triad, with a range that holds its noise."""
    range_ = triad.range * max(1.0, factor)
    return replace(triad, noise_density=factor * triad.noise_density, range=range_)


class Found(NamedTuple):
    """Errors of one cut with one variant; NaN where learning was refused."""

    error: float = np.nan
    """Estimation error of the first run's path [m], 3D RMS."""
    ratio: float = np.nan
    """Deviation of the tool after `UPDATES` over that before; NaN where nothing is learned."""
    notes: Sequence[Note] = ()
    """Limits that changed the cut."""


def controls(seeds: Iterable[int]) -> Table:
    """Medians over seeds at each pose; structure and gears of linear springs.

    Learning is refused where no springs make the model explain the readings; medians are those of
    the cuts that remain.
    """
    cases = list(product(seeds, POSES))
    with Workers() as workers:
        found = list(zip(cases, workers.map(_tried, cases), strict=True))
    errors, ratios, refused = {}, {}, {}
    for name in (_KINEMATICS, _NO_DYNAMICS, *variants()):
        cuts = [[each[name] for (_, at), each in found if at == pose] for pose in POSES]
        errors[name] = 1e6 * np.array([_median([cut.error for cut in at]) for at in cuts])
        ratios[name] = np.array([_median([cut.ratio for cut in at]) for at in cuts])
        refused[name] = sum(np.isnan(cut.error) for at in cuts for cut in at)
    said = counted((each[name].notes for _, each in found for name in variants()), "learned cuts")
    words = ("error 3D [µm]", "k = 5 over k = 0")
    larger = "negative control: without dynamics errors are more than twice as large"
    more = "negative control: without identification averaging runs leaves twice as much"
    averaged = ratios["not identified, 4 runs averaged"]
    return Table(
        "What the estimate needs: error of the tool's path, and what learning leaves",
        ("", *(f"{pose}: {what}" for what in words for pose in POSES), "refused"),
        [
            [name, *errors[name].tolist(), *ratios[name].tolist(), f"{n} of {len(cases)}"]
            for name, n in refused.items()
        ],
        [
            all_hold(larger, errors[_NO_DYNAMICS] > 2.0 * errors[_DEFAULT]),
            all_hold(more, averaged > 2.0 * ratios[_DEFAULT]),
        ],
        said,
    )


def _median(values: Sequence[float]) -> float:
    known = [value for value in values if not np.isnan(value)]
    return float(np.median(known)) if known else np.nan


def _tried(case: tuple[int, str]) -> dict[str, Found]:
    """All variants on one robot at one pose, by name."""
    seed, pose = case
    found = dict.fromkeys((_KINEMATICS, _NO_DYNAMICS, *variants()), Found())
    for name, (unit, measure, repeats) in variants().items():
        cut = Cut(pose=pose, without=tuple(Effect), imu=unit)
        try:
            learning = Case(cut=cut, seed=seed)
            output, learned = learning.from_tool(UPDATES, measure, repeats=repeats)
            iterations = list(learned)
        except ImuError:
            continue
        first, deviation = iterations[0].run, rms(iterations)
        error, ratio = path_error(output(first), first), deviation[-1] / deviation[0]
        found[name] = Found(error, ratio, notes(learning.experiment(), iterations))
        if name == _DEFAULT:
            found[_KINEMATICS] = Found(path_error(rigid_path(first), first))
            found[_NO_DYNAMICS] = Found(path_error(_kinematic(output, unit, first), first))
    return found


def _kinematic(output: ToolOutput, unit: ImuCfg, first: Pass) -> Array:
    log, estimator = first.recording, output.known.estimator
    assert first.imu is not None
    run = prepared(estimator.arm, log.time, log.motor_angle, repaired(first.imu, unit))
    at = run.imu_time + estimator.clock_offset
    twist = kinematic_deviation(estimator, run)
    moved = np.stack([np.interp(log.time, at, column) for column in twist.T], axis=1)
    return rigid_path(first) + moved
