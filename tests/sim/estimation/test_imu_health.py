"""Faults of an IMU at the edges of what is repaired, on made-up samples."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from armside.sim.estimation.imu_health import Fault, ImuError, repaired
from armside.sim.instruments.imu import ImuCfg, ImuSamples

from .one_cut import kept

CFG = ImuCfg()


def readings(n=200):
    rng = np.random.default_rng(0)
    clear = np.zeros((n, 3), dtype=bool)
    return ImuSamples(
        time=np.arange(n) / CFG.rate,
        acceleration=rng.standard_normal((n, 3)),
        angular_velocity=rng.standard_normal((n, 3)),
        acceleration_clipped=clear,
        angular_velocity_clipped=clear,
    )


def test_sound_samples_stay_as_they_are():
    found = repaired(readings(), CFG)
    assert np.array_equal(found.acceleration, readings().acceleration)
    assert found.time == pytest.approx(readings().time)


def checked(samples, fault):
    """The samples repaired, or None where they are refused with that fault."""
    if fault is None:
        return repaired(samples, CFG)
    with pytest.raises(ImuError) as error:
        repaired(samples, CFG)
    assert error.value.fault is fault
    return None


@pytest.mark.parametrize(("n", "fault"), [(40, None), (41, Fault.LOST)])
def test_a_fifth_of_the_samples_may_be_lost(n, fault):
    lost = np.linspace(1, 198, n).astype(int)
    if found := checked(kept(readings(), np.delete(np.arange(200), lost)), fault):
        assert np.isnan(found.acceleration[lost]).all()
        assert len(found.time) == 200
        assert np.isfinite(np.delete(found.acceleration, lost, axis=0)).all()


@pytest.mark.parametrize(("n", "fault"), [(40, None), (41, Fault.CLIPPED)])
@pytest.mark.parametrize("which", ["acceleration_clipped", "angular_velocity_clipped"])
def test_a_fifth_of_the_samples_may_be_clipped_and_none_of_them_is_used(n, fault, which):
    at = np.linspace(1, 198, n).astype(int)
    mask = np.zeros((200, 3), dtype=bool)
    mask[at, 1] = True
    if found := checked(replace(readings(), **{which: mask}), fault):
        assert np.isnan(found.acceleration[at]).all()
        assert np.isnan(found.angular_velocity[at]).all()


@pytest.mark.parametrize(("off", "fault"), [(0.24, None), (0.26, Fault.UNEVEN)])
def test_a_sample_may_be_a_quarter_of_a_period_off_its_place(off, fault):
    time = readings().time.copy()
    time[77] += off / CFG.rate
    if found := checked(replace(readings(), time=time), fault):
        assert found.time == pytest.approx(readings().time)


def test_a_fault_is_sent_between_processes():
    sent = pickle.loads(pickle.dumps(ImuError(Fault.MODEL, "it does not fit")))
    assert (sent.fault, str(sent)) == (Fault.MODEL, str(ImuError(Fault.MODEL, "it does not fit")))
