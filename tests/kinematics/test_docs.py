"""docs/toolbox.md: every block runs, every name exists, every stated number is right."""

import re
from pathlib import Path

import pytest

from armside.kinematics import IRB1400, Link, Robot
from armside.kinematics.equations import forward_kinematics
from armside.kinematics.expressions.symbols import symbol
from armside.kinematics.symbolic import procedures

PAGE = (Path(__file__).parents[2] / "docs" / "toolbox.md").read_text(encoding="utf-8")


def test_functions_of_the_table_exist():
    names = re.findall(r"`procedures\.(\w+)`", PAGE)
    assert len(names) >= 16
    for name in names:
        assert callable(getattr(procedures, name))


@pytest.mark.parametrize(
    ("program", "robot", "stated"),
    [
        (forward_kinematics.jacobian, "symbols", "are 293 by"),
        (forward_kinematics.jacobian_rate, "symbols", "derivative takes 671"),
        (forward_kinematics.jacobian, "irb1400", "numbers 121 and"),
        (forward_kinematics.jacobian_rate, "irb1400", "and 286."),
    ],
)
def test_stated_operation_counts_are_those_of_the_programs(program, robot, stated):
    six = [Link(0, symbol("d", i), symbol("a", i), symbol("alpha", i)) for i in range(1, 7)]
    chosen = Robot(six) if robot == "symbols" else IRB1400
    assert stated in PAGE.replace("\n", " ")
    assert re.search(rf"\b{program(chosen).operations}\b", stated)
