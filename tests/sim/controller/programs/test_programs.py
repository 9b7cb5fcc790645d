"""Programs are read as their makers define them, and refused where they are not understood."""

import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armside.sim.controller.programs import read_program, rows_of
from armside.sim.controller.programs.scanner import Text
from armside.sim.motion.instructions import MoveC, MoveJ, MoveL, ProgramError, Wait

from .generated import HAND_WRITTEN, LANGUAGES, draw

DRAWN = 200
FIRST = {".mod": [".mod"], ".src": [".src", ".dat"], ".script": [".script"]}


def by_hand(ending):
    return [Text(f"part{end}", HAND_WRITTEN[end]) for end in FIRST[ending]]


@pytest.mark.parametrize("language", LANGUAGES)
def test_drawn_programs_mean_what_an_independent_computation_says(language):
    """Positions to rounding; rotations to the 12 decimals that are written."""
    for seed in range(DRAWN):
        drawn = draw(language, seed)
        read = read_program(Text(drawn.name, drawn.content))
        assert len(read.program.instructions) == len(drawn.moves)
        for move, expected in zip(read.program.instructions, drawn.moves, strict=True):
            kind, position, rotation, speed, zone = expected
            assert type(move).__name__ == kind
            np.testing.assert_allclose(move.to.position, position, rtol=0, atol=1e-12)
            turned = Rotation.from_quat(move.to.quaternion, scalar_first=True) * rotation.inv()
            assert turned.magnitude() < 1e-10
            assert move.speed.path == (None if speed is None else pytest.approx(speed, rel=1e-6))
            assert move.zone == pytest.approx(zone, rel=1e-6)


@pytest.mark.parametrize("language", LANGUAGES)
def test_only_numbers_that_change_are_written(language):
    """Points that are moved read back within half a micrometre an axis, all other text is equal."""
    for seed in range(DRAWN):
        drawn, rng = draw(language, seed), np.random.default_rng(seed)
        read = read_program(Text(drawn.name, drawn.content))
        points = [place.aim.point for place in read.places]
        assert read.edited({}) == read.texts
        assert read.edited(dict.fromkeys(points, np.zeros(3))) == read.texts
        moved = points[int(rng.integers(len(points)))]
        by = rng.uniform(-2e-3, 2e-3, 3)
        (text,) = read.edited({moved: by})
        again = read_program(text)
        for place, after in zip(read.places, again.places, strict=True):
            step = by if place.aim.point == moved else np.zeros(3)
            wanted = np.array(place.aim.target.position) + step
            np.testing.assert_allclose(after.aim.target.position, wanted, rtol=0, atol=0.501e-6)
        ends = (moved[0].start, len(drawn.content) - moved[2].end)
        assert text.content[: ends[0]] == drawn.content[: ends[0]]
        assert text.content[len(text.content) - ends[1] :] == drawn.content[-ends[1] :]


@pytest.mark.parametrize("ending", FIRST)
def test_written_by_hand_with_routines_offsets_frames_and_external_axes(ending):
    read = read_program(*by_hand(ending))
    assert "".join(t.content for t in read.texts) == "".join(HAND_WRITTEN[e] for e in FIRST[ending])
    kinds = [type(i) for i in read.program.instructions]
    assert kinds.count(Wait) == 1
    assert kinds.count(MoveC) == 1
    cut = [i for i in read.program.instructions if isinstance(i, MoveL) and i.speed.path == 0.04]
    assert len(cut) >= 2
    assert cut[0].to.position == pytest.approx((0.002, 0.0005, 0.0), abs=1e-12)
    linear = read.places[read.program.instructions.index(cut[0])]
    base = linear.base.pose
    np.testing.assert_allclose(base[:3, :2], [[0, -1], [1, 0], [0, 0]], atol=1e-12)
    assert base[0, 3] == pytest.approx(0.8)
    if ending != ".script":
        assert linear.aim.external[0] == 1200.5
    assert isinstance(read.program.instructions[0], MoveJ)


def test_an_own_work_object_is_the_product_of_its_two_frames():
    read = read_program(*by_hand(".mod"))
    place = read.places[1]
    user = Rotation.from_quat([0, 0, np.sqrt(0.5), np.sqrt(0.5)])
    origin = np.add([0.8, 0, 0.5], user.apply([0.005, 0, 0]))
    np.testing.assert_allclose(place.base.pose[:3, 3], origin)
    np.testing.assert_allclose(place.tool.pose[:3, 3], [0.01, -0.02, 0.15])
    np.testing.assert_allclose(place.tool.pose[:3, 2], [1, 0, 0], atol=1e-12)
    turned = HAND_WRITTEN[".mod"].replace('[FALSE,TRUE,""', '[FALSE,FALSE,"STN1"')
    assert read_program(Text("m.mod", turned)).places[1].base.pose is None


@pytest.mark.parametrize("ending", FIRST)
def test_damaged_programs_end_in_a_line_with_its_column(ending):
    """Cut off, with characters changed, doubled or lost: a valid program, or one line."""
    rng, texts, lines = np.random.default_rng(7), by_hand(ending), list[str]()
    letters = list("\"'[](){};:,=+-*/\\.0123456789eEpqXY \n\r\t!#&%$é\0")
    for i in range(200):
        text = texts[i % len(texts)]
        damaged = text.content if i % 4 else text.content[: int(rng.integers(len(text.content)))]
        for _ in range(int(rng.integers(1, 6)) if i % 4 else 0):
            at = int(rng.integers(len(damaged)))
            to = at + int(rng.integers(0, 3))
            damaged = damaged[:at] + str(rng.choice(letters)) + damaged[to:]
        given = [Text(t.name, damaged if t is text else t.content) for t in texts]
        try:
            rows_of(read_program(*given))
        except ProgramError as error:
            lines.append(str(error))
    assert len(lines) > 80
    placed = re.compile(r"part\.\w+, line \d+, column \d+: .+|part\.\w+: .* one move")
    assert [line for line in lines if not placed.fullmatch(line)] == []


RAPID = "MODULE m\nPROC main()\n{}\nENDPROC\nENDMODULE"
AT = "[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
POSE = "{X 1,Y 2,Z 3,A 0,B 0,C 0}"
KRL = "DEF m( )\n$VEL.CP=0.1\n{}\nEND"
UR = "def m():\n  v = 1\n{}\nend"
REFUSED = [
    ("m.mod", RAPID, "FOR i FROM 1 TO 3 DO", "FOR", "for"),
    ("m.mod", RAPID, "  IF n = 1 main;", "IF", "if"),
    ("m.mod", RAPID, f"MoveL Offs({AT},n,0,0), v40, z1, tool0;", "n,", "declared"),
    ("m.mod", RAPID, f"MoveL RelTool({AT},1,0,0), v40, z1, tool0;", "RelTool", "Offs"),
    ("m.mod", RAPID, f"MoveL {AT}, v40\\V:=50, z1, tool0;", "\\V", ","),
    ("m.mod", RAPID, f"MoveL {AT}, v41, z1, tool0;", "v41", "v41"),
    ("m.mod", RAPID, f"MoveL {AT}, v40, zMine, tool0;", "zMine", "zmine"),
    ("m.mod", RAPID, f"MoveL {AT}, v40, z1, tool0\\Corr;", "Corr", "wobj"),
    ("m.mod", RAPID, f"MoveL {AT.replace('[1,', '[2,')}, v40, z1, tool0;", "2,", "length 1"),
    ("m.mod", RAPID, "p1 := p2;", "p1", "p1"),
    ("m.mod", RAPID, "main;", "main", "30 deep"),
    ("m.mod", RAPID, "other;", "other", "Routines: main"),
    ("m.mod", RAPID, "ENDPROC PROC Reset()", "Reset", "already"),
    ("m.mod", RAPID, "SetDO doLaser, 1 MoveL p1, v40, fine, tool0;", "MoveL", "setdo"),
    ("m.src", KRL, "LOOP", "LOOP", "loop"),
    ("m.src", KRL, "IF $IN[1] THEN", "IF", "if"),
    ("m.src", KRL, "LIN P1", "P1", "p1"),
    ("m.src", KRL, "LIN {X 1,Y 2,Z 3}", "{", "A, B, C"),
    ("m.src", KRL, f"LIN {POSE} C_VEL", "C_VEL", "c_vel"),
    ("m.src", KRL, "LIN_REL {X 1}", "LIN_REL", "lin_rel"),
    ("m.src", KRL, "$OV_PRO=50", "$OV_PRO", "$ov_pro"),
    ("m.src", KRL, "BAS(#CP_DAT)", "#CP_DAT", "#cp_dat"),
    ("m.src", KRL, "INTERRUPT DECL 4 WHEN $IN[1]==TRUE DO m( )", "INTERRUPT", "IR_STOPM"),
    ("m.src", "DEF m( )\nWAIT SEC 1\n{}\nEND", f"LIN {POSE}", "LIN", "$VEL.CP"),
    ("m.src", KRL, f"CIRC {POSE},{POSE},CA 90", ",CA", ","),
    ("m.script", UR, "  while True:", "while", "while"),
    ("m.script", UR, "  movel(p[0,0,0,0,0,0], t=3)", "movel", "time"),
    ("m.script", UR, "  movel(p[0,0,0,0,0], v=1)", "[", "6 numbers"),
    ("m.script", UR, "  movel(pHere, v=1)", "pHere", "pHere"),
    ("m.script", UR, "  set_tcp(pose_trans(p[0,0,0,0,0,0],p[0,0,0,0,0,0]))", "set", "feature"),
    ("m.script", UR, "  movej(get_inverse_kin(pHere), v=1)", "pHere", "pHere"),
    ("m.script", UR, "  movel(p[0,0,0,0,0,0], v=1, w=2)", "w=", "each once"),
    ("m.script", UR, "  movel(get_actual_tcp_pose(), v=1)", "get_actual", "get_actual_tcp_pose"),
    ("m.script", UR, "  x = 1 + 2", "+", "+"),
    ("m.script", UR, "  servoj([0,0,0,0,0,0])", "servoj", "servoj"),
]


@pytest.mark.parametrize(("name", "frame", "line", "at", "word"), REFUSED)
def test_what_is_not_understood_is_refused_by_line_and_column(name, frame, line, at, word):
    with pytest.raises(ProgramError) as caught:
        read_program(Text(name, frame.format(line)))
    place = f"{name}, line 3, column {line.index(at) + 1}: "
    assert str(caught.value).startswith(place)
    assert word in str(caught.value)


def test_columns_count_characters_not_bytes():
    line = '  TPWrite "é"; FOR'.encode().decode("latin-1")
    with pytest.raises(ProgramError, match="line 3, column 16"):
        read_program(Text("m.mod", RAPID.format(line)))


def test_what_is_set_counts_from_there_on():
    """KRL is modal: speed, zone, tool and base of a move are those set by then."""
    lines = [f"LIN {POSE}", "$VEL.CP=0.2", "$APO.CDIS=2", "$BASE=BASE_DATA[3]"]
    lines += [f"LIN {POSE} C_DIS"]
    read = read_program(Text("m.src", KRL.format("\n".join(lines))))
    first, second = read.program.instructions
    assert (first.speed.path, first.zone) == (0.1, 0.0)
    assert (second.speed.path, second.zone) == (0.2, 0.002)
    assert (read.places[1].base.name, read.places[1].base.pose) == ("base_data[3]", None)


def test_tool_and_base_that_a_krl_program_does_not_set_are_not_known():
    """They are what the last program left, or INITMOV's: not the flange. $WORLD is all zero."""
    lines = [f"LIN {POSE}", "BAS(#INITMOV,0)", "$VEL.CP=1", f"LIN {POSE}", "$BASE=$WORLD"]
    read = read_program(Text("m.src", KRL.format("\n".join([*lines, f"LIN {POSE}"]))))
    left, initial, last = read.places
    assert (left.tool.pose, left.base.pose) == (None, None)
    assert (initial.tool.name, initial.tool.pose) == ("tool_data[1]", None)
    np.testing.assert_array_equal([initial.base.pose, last.base.pose], [np.eye(4)] * 2)


def test_a_number_that_loses_its_sign_stays_apart_from_its_axis():
    content = KRL.format("LIN {X-0.5,Y+5,Z-9,A+0,B+0,C+0}")
    read = read_program(Text("m.src", content))
    (text,) = read.edited({read.places[0].aim.point: np.full(3, 1e-3)})
    assert text.content == content.replace("X-0.5,Y+5,Z-9", "X 0.5000,Y 6.0000,Z-8.0000")
    assert read_program(text).program.move(0).to.position == pytest.approx((5e-4, 6e-3, -8e-3))
