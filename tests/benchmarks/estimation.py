"""Benchmarks of the arm side: filters over one run, set-up, identification, whole experiments."""

from collections.abc import Sequence
from dataclasses import replace

from tests.sim.estimation.extended_arm import ExtendedArm

from armside import kinematics
from armside.sim.estimation.elasticity import nominal_elasticity
from armside.sim.estimation.estimator import ToolEstimator
from armside.sim.estimation.identification import identify
from armside.sim.estimation.imu_health import repaired
from armside.sim.estimation.rigid_motion import rigid_motion
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.comparison import COMPARED, Case
from armside.sim.laser.loop import first_run

from ._timing import Row, timed


def measured() -> Sequence[Row]:
    """One cut at p1, 40 mm/s, 100 Hz IMU; experiments of six runs."""
    case, imu = Case(), ImuCfg()
    experiment = case.experiment()
    arm, first = COMPARED.assumed(experiment), first_run(experiment)
    log = first.recording
    assert first.imu is not None
    samples = repaired(first.imu, imu)
    motion, nominal = (
        rigid_motion(arm, log.time, log.motor_angle),
        nominal_elasticity(experiment.nominal, arm),
    )
    found = identify(motion, nominal, samples, imu).parameters
    known = ToolEstimator(arm, found, imu, motion)
    gears = replace(COMPARED, structure=False)
    full = ExtendedArm(
        gears.commissioned(experiment, gears.assumed(experiment), first).known.estimator,
        kinematics.LARGE_ROBOT,
    )

    def set_up() -> object:
        fresh = ToolEstimator(arm, found, imu, motion)
        return fresh(log.time, log.motor_angle, samples)

    with_identification = "estimate-based experiment, six runs, identification included"
    parts = {
        "estimate of one run, after set-up": lambda: known(log.time, log.motor_angle, samples),
        "the same with the set-up of filter and smoother": set_up,
        "full extended filter and smoother": lambda: full(log.time, log.motor_angle, samples),
        "identification": lambda: identify(motion, nominal, samples, imu),
        with_identification: lambda: list(case.from_tool(5)[1]),
        "the same with stored springs": lambda: list(case.from_tool(5, parameters=found)[1]),
    }
    return timed(parts, repeats=5)
