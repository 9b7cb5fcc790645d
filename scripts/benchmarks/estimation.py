"""Benchmarks of the arm side: filters over one run, set-up, identification, whole experiments."""

from collections.abc import Sequence

import numpy as np

from armside import kinematics
from armside.sim.estimation.arm_estimator import estimator
from armside.sim.estimation.arm_identification import identify, prepared
from armside.sim.estimation.arm_learning import ArmLearningCfg
from armside.sim.estimation.extended_arm import ExtendedArm
from armside.sim.estimation.imu_health import mended

from ..arm_side import Case
from .timing import Row, interleaved


def estimation() -> Sequence[Row]:
    """One cut at p1, 40 mm/s, 100 Hz IMU; experiments of six runs."""
    case, cfg = Case(), ArmLearningCfg()
    experiment, arm = case.experiment(), case.arm()
    first = experiment.plant.run(np.zeros_like(experiment.loaded.reference))
    log = first.recording
    assert first.imu is not None
    samples = mended(first.imu, case.imu)
    run, rest = prepared(arm, log.time, log.motor_angle, samples), log.motor_angle[0]
    springs = identify(arm, run, rest, case.imu).springs
    known = estimator(arm, springs, rest, case.imu)
    full = ExtendedArm(known, kinematics.LARGE_ROBOT)

    def set_up() -> None:
        estimator(arm, springs, rest, case.imu).deviations(run)

    timed = interleaved(
        [
            lambda: known.deviations(run),
            lambda: known(log.time, log.motor_angle, samples),
            set_up,
            lambda: full(log.time, log.motor_angle, samples),
            lambda: identify(arm, run, rest, case.imu),
            lambda: list(case.on_arm_side(cfg, 5)[1]),
            lambda: list(case.on_arm_side(cfg, 5, springs)[1]),
        ],
        repeats=5,
    )
    names = (
        "filter and smoother, deviation form, after set-up",
        "the same with the observer",
        "set-up of filter and smoother",
        "full extended filter and smoother",
        "identification, six starts",
        "estimate-based experiment, six runs, identification included",
        "the same with stored springs",
    )
    return [Row(name, seconds) for name, seconds in zip(names, timed, strict=True)]
