"""The hinges across a link of a twin have the compliance and the place that they stand for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from armside.assets import LARGE_ROBOT_XML
from armside.sim.robot.individual import joints, with_hinges
from armside.sim.robot.model import load_model
from armside.sim.twin.simulation import DIRECTIONS, LINKS, MEAN, MIDDLE, bent, hinges, with_bending

compliances = arrays(np.float64, len(DIRECTIONS), elements=st.floats(0.3, 5.0))


@given(compliance=compliances, place=st.floats(0.2, 0.8), link=st.sampled_from(LINKS))
def test_two_hinges_have_the_compliance_of_the_four_directions(compliance, place, link):
    across = np.array(link.across)
    axes = np.outer(np.cos(DIRECTIONS), across[0]) + np.outer(np.sin(DIRECTIONS), across[1])
    asked = np.einsum("i,ij,ik->jk", compliance, axes, axes) / link.stiffness
    found = sum(
        np.outer(hinge.axis, hinge.axis) / hinge.stiffness
        for hinge in link.hinges(compliance, place)
    )
    assert found == pytest.approx(asked, rel=1e-9, abs=1e-9 / link.stiffness)


def test_a_link_that_bends_about_one_direction_is_stiff_about_the_other():
    compliance = np.array([0.0, 3.0, 0.0, 0.0])
    stiff, soft = sorted(LINKS[0].hinges(compliance, MIDDLE), key=lambda hinge: -hinge.stiffness)
    assert np.abs(np.dot(soft.axis, (1.0, 1.0, 0.0))) == pytest.approx(np.sqrt(2.0))
    assert soft.stiffness == pytest.approx(LINKS[0].stiffness / 3.0)
    assert stiff.stiffness > 10.0 * soft.stiffness


def test_numbers_written_into_a_bending_design_are_those_of_a_new_one():
    plain = load_model(LARGE_ROBOT_XML)
    rng = np.random.default_rng(0)
    others = hinges(rng.uniform(-MEAN, 3.0, (3, 4)), rng.uniform(-0.2, 0.2, 3))
    design = with_bending(plain)
    assert bent(design, ()) is design  # where nothing is said of its links
    written, compiled = bent(design, others).mj, with_hinges(plain, others).mj
    own = joints(compiled, "hidden_")
    assert own == joints(written, "hidden_")
    assert len(own) == len(others)
    for name in ("jnt_axis", "jnt_pos", "jnt_stiffness", "dof_damping", "dof_invweight0"):
        value = getattr(compiled, name)
        assert getattr(written, name) == pytest.approx(value, rel=1e-9), name


def test_the_hinges_are_damped_as_those_of_the_file():
    plain = load_model(LARGE_ROBOT_XML)
    own = joints(plain.mj, "struct_")
    time = plain.mj.dof_damping[plain.mj.jnt_dofadr[own]] / plain.mj.jnt_stiffness[own]
    for hinge in hinges(np.zeros((3, 4)), np.zeros(3)):
        assert time.min() < hinge.damping / hinge.stiffness < time.max()
