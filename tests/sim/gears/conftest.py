import importlib.util
import sys
from pathlib import Path

import pytest

from armside.sim.gears import GearsCfg, analyse

SPEC = importlib.util.spec_from_file_location("synthetic", Path(__file__).parent / "synthetic.py")
assert SPEC
assert SPEC.loader
synthetic = importlib.util.module_from_spec(SPEC)
sys.modules["synthetic"] = synthetic
SPEC.loader.exec_module(synthetic)

CFG = GearsCfg(largest_order=200.0)


@pytest.fixture(scope="session")
def scenes():
    """Module of the synthetic recordings."""
    return synthetic


@pytest.fixture(scope="session")
def recordings():
    """Two recordings of one arm, with other motions and clocks."""
    first = synthetic.Scene(1)
    second = synthetic.Scene(2, imu_offset=0.15, tracker_offset=800.0, tracker_rate=-1e-3)
    return [synthetic.recording(scene) for scene in (first, second)]


@pytest.fixture(scope="session")
def analysis(recordings):
    """What the IMU of the two recordings teaches."""
    return analyse(synthetic.ARM, recordings, CFG)
