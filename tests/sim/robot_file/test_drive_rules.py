"""What a robot file leaves out is estimated after the large robot."""

import mujoco
import numpy as np
import pytest

from armside.assets import LARGE_ROBOT_XML
from armside.sim.robot_file.drive_rules import _CONTROLLER


@pytest.mark.parametrize("name", ["correction_delay", "correction_lag", "torque_noise"])
def test_a_controller_is_estimated_as_that_of_the_large_robot(name):
    mj = mujoco.MjModel.from_xml_path(str(LARGE_ROBOT_XML))
    np.testing.assert_array_equal(np.ravel(_CONTROLLER[name]), mj.numeric(name).data)
