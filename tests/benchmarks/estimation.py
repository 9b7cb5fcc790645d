"""Benchmarks of the arm side: filters over one run, set-up, identification, whole experiments."""

from collections.abc import Sequence

from armside import kinematics
from armside.sim.estimation.arm_estimator import estimator
from armside.sim.estimation.arm_identification import identify, prepared
from armside.sim.estimation.extended_arm import ExtendedArm
from armside.sim.estimation.imu_health import repaired
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.comparison import COMPARED, Case
from armside.sim.laser.learning import first_run

from ._timing import Row, interleaved


def measured() -> Sequence[Row]:
    """One cut at p1, 40 mm/s, 100 Hz IMU; experiments of six runs."""
    case, imu = Case(), ImuCfg()
    experiment = case.experiment()
    arm, first = COMPARED.assumed(experiment), first_run(experiment)
    log = first.recording
    assert first.imu is not None
    samples = repaired(first.imu, imu)
    run, rest = prepared(arm, log.time, log.motor_angle, samples), log.motor_angle[0]
    springs = identify(arm, run, rest, imu).springs
    known = estimator(arm, springs, rest, imu)
    full = ExtendedArm(known, kinematics.LARGE_ROBOT)

    with_identification = "estimate-based experiment, six runs, identification included"
    timed = {
        "filter and smoother, deviation form, after set-up": lambda: known.deviations(run),
        "the same with the observer": lambda: known(log.time, log.motor_angle, samples),
        "set-up of filter and smoother": lambda: estimator(arm, springs, rest, imu).deviations(run),
        "full extended filter and smoother": lambda: full(log.time, log.motor_angle, samples),
        "identification, six starts": lambda: identify(arm, run, rest, imu),
        with_identification: lambda: list(case.from_tool(5)[1]),
        "the same with stored springs": lambda: list(case.from_tool(5, springs=springs)[1]),
    }
    return list(map(Row, timed, interleaved(list(timed.values()), repeats=5)))
