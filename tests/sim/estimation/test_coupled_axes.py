"""Axes that an elastic structure couples, and the springs of arms of 1 to 9 axes."""

import mujoco
import numpy as np
import pytest

from armside.assets import IRB1400_XML, LARGE_ROBOT_XML
from armside.sim.estimation.arm_springs import SpringPrior, arm_and_wrist, springs_at
from armside.sim.estimation.coupled_axes import coupled_axes
from armside.sim.estimation.nominal import nominal_arm
from armside.sim.robot.model import load_model

PARENT = LARGE_ROBOT_XML.parent
IN_PLANE_AND_OUT = ((1, 2), (1, 4), (2, 4), (0, 3), (0, 5), (3, 5))
"""Axes 2, 3, 5 and axes 1, 4, 6 of the robots of the thesis, counted from 0."""


def chain(*axes):
    """Joints j1.. of a serial arm: "x", "y", "z" turn, capitals slide."""
    bodies = "".join(
        f"<body pos='0 0 0.3'><inertial mass='1' pos='0 0 0' diaginertia='1 1 1'/>"
        f"<joint name='j{i}' type='{'slide' if a.isupper() else 'hinge'}' "
        f"axis='{' '.join('1' if c == a.lower() else '0' for c in 'xyz')}'/>"
        for i, a in enumerate(axes, 1)
    )
    xml = f"<mujoco><worldbody>{bodies}{'</body>' * len(axes)}</worldbody></mujoco>"
    return mujoco.MjModel.from_xml_string(xml), [f"j{i}" for i in range(1, len(axes) + 1)]


@pytest.mark.parametrize("file", [LARGE_ROBOT_XML, IRB1400_XML])
def test_the_robots_of_the_thesis_couple_within_their_plane_and_out_of_it(file):
    assert nominal_arm(load_model(file)).coupled == IN_PLANE_AND_OUT


@pytest.mark.parametrize(
    ("axes", "pairs"),
    [
        ("z", ()),
        ("zz", ((0, 1),)),
        ("zzZz", ((0, 1), (0, 3), (1, 3))),  # SCARA: the quill alone leaves the plane
        ("zyyyzy", ((1, 2), (1, 3), (1, 5), (2, 3), (2, 5), (3, 5), (0, 4))),  # UR
        ("zyXyz", ((1, 2), (1, 3), (2, 3), (0, 4))),  # a slide along x keeps the plane
        ("zyzyzyz", ((1, 3), (1, 5), (3, 5), (0, 2), (0, 4), (0, 6), (2, 4), (2, 6), (4, 6))),
    ],
)
def test_axes_of_equal_parity_are_coupled(axes, pairs):
    assert coupled_axes(*chain(*axes)) == pairs


@pytest.mark.parametrize(
    ("n", "split"), [(1, (1, 0)), (2, (2, 0)), (4, (3, 1)), (6, (3, 3)), (7, (4, 3)), (9, (6, 3))]
)
def test_a_wrist_has_three_axes_at_most(n, split):
    assert arm_and_wrist(n) == split


def test_parameters_of_a_planar_arm_are_named_and_make_symmetric_springs():
    arm, prior = nominal_arm(load_model(PARENT / "two_link.xml")), SpringPrior()
    names = prior.names(arm)
    assert names[:2] == ("stiffness 1", "stiffness 2")
    assert names[-1] == "coupling 1-2"
    assert len(names) == len(prior.standard_deviation(arm)) == 9
    theta = np.zeros(9)
    theta[[0, -1]] = 0.5, 0.3
    found = springs_at(arm, prior, theta, 0.05).stiffness
    own = np.diag(arm.stiffness) * np.exp([0.5, 0.0])
    off = 0.3 * np.sqrt(own.prod())
    assert found == pytest.approx(np.array([[own[0], off], [off, own[1]]]))


def test_springs_of_gears_alone_have_no_couplings():
    arm, prior = nominal_arm(load_model(PARENT / "two_link.xml")), SpringPrior(coupling=0.0)
    assert prior.pairs(arm) == ()
    assert len(prior.names(arm)) == 8
