"""Program files are read in degrees and millimetres; errors name the line."""

import numpy as np
import pytest

from armside.sim.motion.instructions import MoveC, MoveJ, MoveL, ProgramError, Wait
from armside.sim.motion.program_file import parse_program

GOOD = """
start = [0, 0, 0, 0, -30, 0]

[dynamics]
joint_acceleration = [1, 2, 3, 4, 5, 6]
path_acceleration = 8.0
jerk_time = 40

[targets.corner]
position = [968, -127, 1030]
orientation = [0.7071, 0, 0.7071, 0]
near = [0, 0, 0, 0, -10, 0]

[[program]]
do = "MoveJ"
to = "corner"
speed = "80 %"
zone = 10

[[program]]
do = "MoveL"
to = { position = [968, 127, 1030] }
speed = 500

[[program]]
do = "MoveC"
via = { position = [1000, 0, 1030] }
to = "corner"
speed = 250.5

[[program]]
do = "Wait"
seconds = 0.5
"""


def test_units_are_converted_to_si():
    program = parse_program(GOOD, source="good.toml")
    joint, line, circle, wait = program.instructions
    assert isinstance(joint, MoveJ)
    assert isinstance(line, MoveL)
    assert isinstance(circle, MoveC)
    assert isinstance(wait, Wait)
    assert program.start == pytest.approx((0, 0, 0, 0, -np.pi / 6, 0))
    assert joint.to.position == pytest.approx((0.968, -0.127, 1.030))
    assert joint.to.quaternion == (0.7071, 0, 0.7071, 0)
    assert joint.to.near == pytest.approx((0, 0, 0, 0, -np.pi / 18, 0))
    assert (joint.speed.share, joint.speed.path) == (0.8, None)
    assert joint.zone == pytest.approx(0.010)
    assert line.speed.path == pytest.approx(0.5)
    assert line.zone == 0.0
    assert circle.via == pytest.approx((1.0, 0.0, 1.03))
    assert wait.seconds == 0.5
    assert program.dynamics.joint_acceleration == (1, 2, 3, 4, 5, 6)
    assert program.dynamics.jerk_time == pytest.approx(0.040)


def test_a_target_of_motor_angles_is_in_degrees():
    text = '[[program]]\ndo = "MoveJ"\nto = { motors = [10, 0, -20, 0, 30, 180] }\nspeed = "80 %"\n'
    (joint,) = parse_program(text, source="joint.toml").instructions
    assert isinstance(joint, MoveJ)
    assert joint.to.motors == pytest.approx(np.radians((10, 0, -20, 0, 30, 180)))


def test_each_instruction_knows_its_line():
    program = parse_program(GOOD, source="good.toml")
    starts = [i + 1 for i, text in enumerate(GOOD.splitlines()) if text == "[[program]]"]
    assert list(program.lines) == starts
    assert program.place(1) == f"good.toml, line {starts[1]} (MoveL)"


@pytest.mark.parametrize(
    ("change", "line", "reason"),
    [
        (
            ('"MoveL"', '"MoveX"'),
            'do = "MoveX"',
            "unknown instruction 'MoveX'. Known: MoveJ, MoveL",
        ),
        (("speed = 500", "speed = 0"), "speed = 0", "speed must be > 0"),
        (("speed = 500", "speed = -5"), "speed = -5", "speed must be > 0"),
        (("speed = 500", "speed = nan"), "speed = nan", "speed must be a finite number"),
        (('"80 %"', '"fast"'), 'speed = "fast"', "must be mm/s or a percentage"),
        (('"80 %"', '"120 %"'), 'speed = "120 %"', "at most 100 %"),
        (("speed = 500", 'speed = "50 %"'), "[[program]]", "MoveL needs a speed along its path"),
        (("zone = 10", "zone = -1"), "zone = -1", "zone must be >= 0"),
        (("zone = 10", "blend = 10"), "blend = 10", "blend is not known here. Known: do, speed"),
        (("seconds = 0.5", "seconds = 0"), "seconds = 0", "seconds must be > 0"),
        (("seconds = 0.5", ""), "[[program]]", "seconds is missing"),
        (
            ('to = "corner"\nspeed = "80', 'to = "edge"\nspeed = "80'),
            'to = "edge"',
            "Targets: corner",
        ),
        (
            ("[968, -127, 1030]", "[968, -127]"),
            "position = [968, -127]",
            "position must be 3 numbers",
        ),
        (
            ("= [0.7071, 0, 0.7071, 0]", "= [0, 0, 0, 0]"),
            "orientation = [0",
            "orientation must not",
        ),
        (("start = [0, 0", 'start = ["a", 0'), 'start = ["a"', "start must be a finite number"),
        (("jerk_time = 40", "jerk_time = true"), "jerk_time = true", "jerk_time must be a finite"),
        (("jerk_time = 40", "jerk_time = 0"), "[dynamics]", "must be > 0"),
    ],
)
def test_what_is_wrong_is_named_with_file_line_and_reason(change, line, reason):
    old, new = change
    assert old in GOOD
    text = GOOD.replace(old, new, 1)
    with pytest.raises(ProgramError) as error:
        parse_program(text, source="bad.toml")
    message = str(error.value)
    assert reason in message
    number = int(message.removeprefix("bad.toml, line ").split(":")[0])
    assert text.splitlines()[number - 1].startswith(line)


def test_a_file_that_is_no_toml_says_where():
    with pytest.raises(ProgramError, match=r"bad\.toml: .*line 2"):
        parse_program("\nstart = = 3", source="bad.toml")


def test_an_empty_program_is_refused():
    with pytest.raises(ProgramError, match="at least one move"):
        parse_program('[[program]]\ndo = "Wait"\nseconds = 1.0', source="bad.toml")


def test_unknown_sections_are_refused():
    with pytest.raises(ProgramError, match="speeds is not known here"):
        parse_program(GOOD + "\n[speeds]\nslow = 1\n", source="bad.toml")
