import pytest

from armside.sim.gears import GearsCfg, analyse_gears

CFG = GearsCfg(largest_order=200.0)


@pytest.fixture(scope="session")
def recordings(scenes):
    """Two recordings of one arm, with other motions and clocks."""
    first = scenes.Scene(1)
    second = scenes.Scene(2, imu_offset=0.15, tracker_offset=800.0, tracker_rate=-1e-3)
    return [scenes.recording(scene) for scene in (first, second)]


@pytest.fixture(scope="session")
def analysis(recordings, scenes):
    """What the IMU of the two recordings teaches."""
    return analyse_gears(scenes.ARM, recordings, CFG)
