"""The claims of `armside verify estimation-controls`: what helps, what does not, and what it costs.

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
from armside.sim.estimation.imu_health import ImuError, repaired
from armside.sim.estimation.kinematic_filter import kinematic_deviation
from armside.sim.instruments.imu import ImuCfg, TriadCfg
from armside.sim.laser.plant import Pass

from ..arm_side import GEAR_EFFECTS, Case, rms
from ..commands.verify import Table, Verdict
from ..jobs.workers import Workers
from .estimation import error, fk_path

POSES = ("p1", "p2", "p3")
UPDATES = 5
_DEFAULT = "identified (the default)"
_KINEMATICS, _NO_DYNAMICS = "motor-angle kinematics", "kinematic filter, no dynamics"
DEAF = 1e3
"""Noise of a sensor that is not to be listened to, over its own."""


def learned(case: Case, cfg: ArmLearningCfg) -> tuple[Commissioned, Pass, float, float]:
    """What was commissioned, the first run, and arm RMS before and after learning [m]."""
    known, iterations = case.on_arm_side(cfg, UPDATES)
    runs = list(iterations)
    return known, runs[0].trial.result, rms(runs)[0], rms(runs)[-1]


def variants() -> dict[str, tuple[ImuCfg, ArmLearningCfg]]:
    """Name: unit at the tool, and how it is learned from."""
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
            replace(unit, accelerometer=_louder(unit.accelerometer, DEAF)),
            # Nothing then tells where gravity is: the check of it must let everything pass.
            replace(usual, prior=SpringPrior(mounting=1.0)),
        ),
        "accelerometer only": (replace(unit, gyroscope=_louder(unit.gyroscope, DEAF)), usual),
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
    """With a range that holds its noise."""
    range_ = triad.range * max(1.0, factor)
    return replace(triad, noise_density=factor * triad.noise_density, range=range_)


class Found(NamedTuple):
    """What one way of measuring and learning leaves of one cut."""

    error: float = np.nan
    """Of the first run's path [m], 3D RMS; NaN where learning was refused."""
    ratio: float = np.nan
    """Of the tool's deviation after `UPDATES` over that before; NaN where nothing is learned."""


def controls(seeds: Iterable[int]) -> Table:
    """Medians over seeds at each pose; structure and gears of linear springs.

    Learning is refused where no springs make the model explain the readings; medians are those of
    the cuts that are left.
    """
    cases = [(seed, pose) for seed in seeds for pose in POSES]
    with Workers() as workers:
        found = list(zip(cases, workers.map(_tried, cases), strict=True))
    by_pose = {
        name: [[each[name] for (_, at), each in found if at == pose] for pose in POSES]
        for name in (_KINEMATICS, _NO_DYNAMICS, *variants())
    }
    errors = {
        name: 1e6 * np.array([_median([f.error for f in at]) for at in cuts])
        for name, cuts in by_pose.items()
    }
    left = {
        name: np.array([_median([f.ratio for f in at]) for at in cuts])
        for name, cuts in by_pose.items()
    }
    refused = {
        name: sum(np.isnan(cut.error) for at in cuts for cut in at)
        for name, cuts in by_pose.items()
    }
    return Table(
        title="What the estimate needs: error of the tool's path, and what learning leaves",
        columns=(
            "",
            *(f"{pose}: error 3D [µm]" for pose in POSES),
            *(f"{pose}: k = 5 over k = 0" for pose in POSES),
            "refused",
        ),
        rows=[
            [
                name,
                *errors[name].tolist(),
                *left[name].tolist(),
                f"{refused[name]} of {len(cases)}",
            ]
            for name in by_pose
        ],
        verdicts=[
            Verdict(
                "negative control: without dynamics errors are more than twice as large",
                bool((errors[_NO_DYNAMICS] > 2.0 * errors[_DEFAULT]).all()),
            ),
            Verdict(
                "negative control: without identification averaging runs leaves twice as much",
                bool((left["not identified, 4 runs averaged"] > 2.0 * left[_DEFAULT]).all()),
            ),
        ],
    )


def _median(values: Sequence[float]) -> float:
    known = [value for value in values if not np.isnan(value)]
    return float(np.median(known)) if known else np.nan


def _tried(case: tuple[int, str]) -> dict[str, Found]:
    """Every way, on one robot at one pose, by name."""
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
    run = prepared(known.estimator.arm, log.time, log.motor_angle, repaired(first.imu, unit))
    at = run.imu_time + known.estimator.clock_offset
    twist = kinematic_deviation(known.estimator, run)
    moved = np.stack([np.interp(log.time, at, column) for column in twist.T], axis=1)
    return fk_path(first) + moved
