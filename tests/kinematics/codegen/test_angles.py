"""Angles that math.h of some compilers has a macro for are numbers in every language."""

import re

import numpy as np
import pytest

from armside.kinematics import Link, Robot
from armside.kinematics.codegen import Language, write
from armside.kinematics.codegen.languages import interpreted
from armside.kinematics.equations import forward_kinematics

AT_45_DEG = Robot([Link(theta=np.pi / 4, a=1), Link(theta=np.pi / 3, a=1, alpha=np.pi / 4)])


@pytest.mark.parametrize("language", [each for each in Language if each is not Language.LATEX])
def test_no_macro_of_math_h_is_printed(language):
    for text in write(forward_kinematics.pose(AT_45_DEG), language).values():
        assert not re.search(r"\bM_\w", text)


def test_a_joint_at_45_degrees_has_its_pose():
    T = interpreted(forward_kinematics.pose(AT_45_DEG))([0.1, 0.2])
    first, second = np.pi / 4 + 0.1, np.pi / 4 + np.pi / 3 + 0.3
    expected = [np.cos(first) + np.cos(second), np.sin(first) + np.sin(second), 0.0]
    np.testing.assert_allclose(T[:3, 3], expected, rtol=0, atol=1e-15)
