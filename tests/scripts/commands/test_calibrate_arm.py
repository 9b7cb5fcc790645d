"""What `armside calibrate-arm` fits where it is not told, and how far its options go."""

import pytest

from armside.kinematics.calibration import CalibrationCfg
from armside.scripts.commands.calibrate_arm import LIMITS, CalibrateArmCfg


def test_it_fits_half_of_the_poses_at_random():
    cfg, library = CalibrateArmCfg(robot="ur10"), CalibrationCfg()
    assert (cfg.fraction, cfg.in_order) == (0.5, False)
    assert library.in_order == cfg.in_order


def test_harmonics_are_from_none_to_two_hundred():
    LIMITS["harmonics"].check("harmonics", (0, 200))
    for order in (-1, 201):
        with pytest.raises(ValueError, match="harmonics must be 0 to 200"):
            LIMITS["harmonics"].check("harmonics", order)
