"""An IMU with a fault is named, and nothing is learned from it."""

from dataclasses import replace

import numpy as np
import pytest

from armside.sim.estimation.commissioning import Commissioning, OnFault
from armside.sim.estimation.imu_health import Fault, ImuError

from .one_cut import commissioned, kept


def spoiled(name, rows, value):
    """Samples with another value in some rows of a signal."""

    def spoil(imu):
        values = getattr(imu, name).copy()
        values[rows] = value
        return replace(imu, **{name: values})

    return spoil


FAULTS = {
    Fault.OUT_OF_ORDER: lambda imu: spoiled("time", np.s_[50:52], imu.time[[51, 50]])(imu),
    Fault.DEAD: spoiled("angular_velocity", np.s_[:, 2], 0.01),
    Fault.CLIPPED: spoiled("acceleration_clipped", np.s_[::3], True),
    Fault.NOT_FINITE: spoiled("acceleration", 7, np.nan),
    Fault.LOST: lambda imu: kept(imu, np.arange(len(imu.time)) % 3 > 0),
    Fault.TOO_SHORT: lambda imu: kept(imu, np.arange(len(imu.time)) < 20),
    Fault.UNEVEN: lambda imu: replace(imu, time=imu.time * 1.02),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_faulty_imu_is_named_and_learning_refuses_to_start(fault, first):
    bad = replace(first, imu=FAULTS[fault](first.imu))
    with pytest.raises(ImuError, match=fault.value) as raised:
        commissioned(bad)
    assert raised.value.fault is fault


def test_or_it_goes_on_without_the_imu_if_told_so(first):
    bad = replace(first, imu=FAULTS[Fault.DEAD](first.imu))
    known = commissioned(bad, Commissioning(on_fault=OnFault.GO_ON))
    assert known.fault is not None
    assert known.fault.fault is Fault.DEAD
    assert known.identified is None


TURNS = [0, 0, 0, 1.2, 0.8, 2.0], [0, 0.3, -0.3, 0, 0.3, 0], [0, 0, 0, 0, 0, 0.5]


@pytest.mark.parametrize("turn", TURNS)
def test_a_model_of_another_robot_is_refused(turn, first):
    """The same arm in another posture, or with its flange turned: another robot to the IMU."""
    turned = first.recording.motor_angle + np.array(turn)
    other = replace(first, recording=replace(first.recording, motor_angle=turned))
    with pytest.raises(ImuError, match=Fault.MODEL.value):
        commissioned(other)
