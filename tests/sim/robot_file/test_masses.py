"""Estimated inertias of links."""

import mujoco
import numpy as np
import pytest

from armside.sim.robot_file.masses import DENSITY, cylinder, matrix, of_cylinder

CYLINDER = """
<mujoco><worldbody><body><freejoint/>
  <geom type="cylinder" fromto="{ends}" size="{radius}" density="{density}"/>
</body></worldbody></mujoco>
"""


@pytest.mark.parametrize("along", [(0.0, 0.0, 0.5), (0.3, -0.2, 0.6)])
def test_a_link_has_the_inertia_of_a_cylinder_of_mujoco(along):
    length, radius = cylinder(20.0, np.array(along))
    assert length == pytest.approx(np.linalg.norm(along))
    ends = " ".join(map(repr, (0.0, 0.0, 0.0, *along)))
    mj = mujoco.MjModel.from_xml_string(CYLINDER.format(ends=ends, radius=radius, density=DENSITY))
    assert mj.body_mass[1] == pytest.approx(20.0)
    R = np.empty(9)
    mujoco.mju_quat2Mat(R, mj.body_iquat[1])
    R = R.reshape(3, 3)
    expected = R @ np.diag(mj.body_inertia[1]) @ R.T
    np.testing.assert_allclose(matrix(of_cylinder(20.0, np.array(along))), expected, atol=1e-9)
