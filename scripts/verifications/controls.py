"""The claims of `armside verify estimation-controls`: variants of sensor, model and law compared.

Estimation error (3D RMS) of the first run, and the tool's deviation after five updates.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from armside.arrays import Array
from armside.sim.estimation.arm_identification import prepared
from armside.sim.estimation.arm_learning import ArmLaw, ArmLearningCfg, Commissioned, measured_path
from armside.sim.estimation.arm_springs import SpringPrior
from armside.sim.estimation.imu_health import ImuError, mended
from armside.sim.estimation.kinematic_filter import kinematic_deviation
from armside.sim.evaluation.check import Table, all_hold
from armside.sim.instruments.imu import ImuCfg, TriadCfg
from armside.sim.laser.plant import Pass

from ..arm_side import GEAR_EFFECTS, Case, rms
from ..jobs.workers import Workers
from .estimation import error, fk_path

POSES = ("p1", "p2", "p3")
UPDATES = 5
_DEFAULT = "identified (the default)"
_KINEMATICS, _NO_DYNAMICS = "motor-angle kinematics", "kinematic filter, no dynamics"
SILENCED = 1e3
"""Noise of a sensor that is excluded from the estimate, over its own."""


def learned(case: Case, cfg: ArmLearningCfg) -> tuple[Commissioned, Pass, float, float]:
    """The commissioned arm, the first run, and arm RMS before and after learning [m]."""
    known, iterations = case.on_arm_side(cfg, UPDATES)
    runs = list(iterations)
    return known, runs[0].trial.result, rms(runs)[0], rms(runs)[-1]


def variants() -> dict[str, tuple[ImuCfg, ArmLearningCfg]]:
    """Sensor unit at the tool and configuration of learning, by name."""
    unit, usual = ImuCfg(), ArmLearningCfg()
    unknown = replace(usual, identified=False, law_identified=False)

    def noisy(factor: float) -> ImuCfg:
        parts = (_louder(t, factor) for t in (unit.accelerometer, unit.gyroscope))
        return replace(unit, **dict(zip(("accelerometer", "gyroscope"), parts, strict=True)))

    no_clock = replace(usual, prior=SpringPrior(clock=1e-7))
    found = {
        _DEFAULT: (unit, usual),
        "springs of gears only": (unit, replace(usual, prior=SpringPrior(coupling=0.0))),
        "not identified": (unit, unknown),
        "not identified, 4 runs averaged": (unit, replace(unknown, repeats=4)),
        "law from the wrong stiffness": (unit, replace(usual, law_identified=False)),
        "heuristic law": (unit, replace(usual, law=ArmLaw.HEURISTIC)),
        "norm-optimal law": (unit, replace(usual, law=ArmLaw.NORM_OPTIMAL)),
        "gyro only": (
            replace(unit, accelerometer=_louder(unit.accelerometer, SILENCED)),
            # Gravity is then unobservable: its check must let everything pass.
            replace(usual, prior=SpringPrior(mounting=1.0)),
        ),
        "accelerometer only": (replace(unit, gyroscope=_louder(unit.gyroscope, SILENCED)), usual),
        "noise / 8": (noisy(1 / 8), usual),
        "noise x 4": (noisy(4.0), usual),
    }
    for rate in (50.0, 250.0, 500.0):
        found[f"IMU at {rate:g} Hz"] = (replace(unit, rate=rate), usual)
    for limit in (0.0, 0.002, 0.005, 0.010):
        clock = replace(unit, clock_offset=limit)
        found[f"clock within {1e3 * limit:g} ms, not estimated"] = (clock, no_clock)
    return found


def _louder(triad: TriadCfg, factor: float) -> TriadCfg:
    """A noisier triad, with a range that holds its noise."""
    range_ = triad.range * max(1.0, factor)
    return replace(triad, noise_density=factor * triad.noise_density, range=range_)


class Found(NamedTuple):
    """Errors of one cut with one variant."""

    error: float = np.nan
    """Estimation error of the first run's path [m], 3D RMS; NaN where learning was refused."""
    ratio: float = np.nan
    """Deviation of the tool after `UPDATES` over that before; NaN where nothing is learned."""


def controls(seeds: Iterable[int]) -> Table:
    """Medians over seeds at each pose; structure and gears of linear springs.

    Learning is refused where no springs make the model explain the readings; medians are those of
    the cuts that remain.
    """
    cases = [(seed, pose) for seed in seeds for pose in POSES]
    with Workers() as workers:
        found = list(zip(cases, workers.map(_tried, cases), strict=True))
    errors, ratios, refused = {}, {}, {}
    for name in (_KINEMATICS, _NO_DYNAMICS, *variants()):
        cuts = [[each[name] for (_, at), each in found if at == pose] for pose in POSES]
        errors[name] = 1e6 * np.array([_median([cut.error for cut in at]) for at in cuts])
        ratios[name] = np.array([_median([cut.ratio for cut in at]) for at in cuts])
        refused[name] = sum(np.isnan(cut.error) for at in cuts for cut in at)
    return Table(
        "What the estimate needs: error of the tool's path, and what learning leaves",
        (
            "",
            *(f"{pose}: error 3D [µm]" for pose in POSES),
            *(f"{pose}: k = 5 over k = 0" for pose in POSES),
            "refused",
        ),
        [
            [name, *errors[name].tolist(), *ratios[name].tolist(), f"{n} of {len(cases)}"]
            for name, n in refused.items()
        ],
        [
            all_hold(
                "negative control: without dynamics errors are more than twice as large",
                errors[_NO_DYNAMICS] > 2.0 * errors[_DEFAULT],
            ),
            all_hold(
                "negative control: without identification averaging runs leaves twice as much",
                ratios["not identified, 4 runs averaged"] > 2.0 * ratios[_DEFAULT],
            ),
        ],
    )


def _median(values: Sequence[float]) -> float:
    known = [value for value in values if not np.isnan(value)]
    return float(np.median(known)) if known else np.nan


def _tried(case: tuple[int, str]) -> dict[str, Found]:
    """All variants on one robot at one pose, by name."""
    seed, pose = case
    cut = Case(pose=pose, seed=seed, without=GEAR_EFFECTS)
    found = {_KINEMATICS: Found(), _NO_DYNAMICS: Found()}
    for name, (unit, cfg) in variants().items():
        try:
            known, first, before, after = learned(replace(cut, imu=unit), cfg)
        except ImuError:
            found[name] = Found()
            continue
        found[name] = Found(error(measured_path(cfg, known, unit, first), first), after / before)
        if name == _DEFAULT:
            found[_KINEMATICS] = Found(error(fk_path(first), first))
            found[_NO_DYNAMICS] = Found(error(_kinematic(known, unit, first), first))
    return found


def _kinematic(known: Commissioned, unit: ImuCfg, first: Pass) -> Array:
    log = first.recording
    assert first.imu is not None
    run = prepared(known.estimator.arm, log.time, log.motor_angle, mended(first.imu, unit))
    at = run.imu_time + known.estimator.clock_offset
    twist = kinematic_deviation(known.estimator, run)
    moved = np.stack([np.interp(log.time, at, column) for column in twist.T], axis=1)
    return fk_path(first) + moved
