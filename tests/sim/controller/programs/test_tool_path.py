"""The tool path of a program, and a correction put into its targets."""

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from armside.sim.controller.programs import (
    automatic_spacing,
    corrected,
    new_program,
    read_program,
    rows_of,
)
from armside.sim.controller.programs.new_program import ENDINGS, fitted
from armside.sim.controller.programs.scanner import Text
from armside.sim.controller.programs.tool_path import Row, arc, arcs_of
from armside.sim.controller.programs.virtual_run import where
from armside.sim.motion.instructions import ProgramError
from armside.sim.motion.path import Plane
from armside.sim.motion.timing import PathLimits, rest_to_rest
from armside.sim.part.arcs import arc as chain_arc
from armside.sim.part.curve import Kind
from armside.sim.part.motion import CutLeg, PartMotion

UM = 1e-6
TURN = Rotation.from_euler("ZYX", [0.3, 1.1, -0.4])
R = TURN.as_matrix()


def row(targets, zone):
    zones = np.full(len(targets), zone)
    return Row(moves=tuple(range(len(targets))), targets=np.array(targets), zones=zones)


def circle(s, radius=0.005, centre=(1.2, 0.1, 0.9)):
    angle = np.asarray(s) / radius
    flat = radius * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)
    return flat + np.array(centre)


TURNS = 1.2
LENGTH = TURNS * 2 * np.pi * 0.005


def test_zones_of_half_the_spacing_make_a_uniform_quadratic_spline():
    """On any targets at even distances: of a helix, to rounding."""
    angle = 0.3 * np.arange(12)
    targets = np.stack([np.cos(angle), np.sin(angle), 0.2 * angle], axis=1)
    made = row(targets, zone=9.0)
    spline = BSpline(np.arange(len(targets) + 3), targets, 2)
    x = np.linspace(0.0, 1.0, 11)[:-1]
    for i in range(1, len(targets) - 1):  # the parabola about target i
        np.testing.assert_allclose(made.path(2 * i - 1 + x), spline(i + 1 + x), atol=1e-14)


def test_a_small_zone_is_a_parabola_that_joins_both_lines():
    made = row([[0.0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0]], zone=0.01)
    first, middle, last = made.path([1.0, 1.5, 2.0])
    np.testing.assert_allclose([first, last], [[0.09, 0, 0], [0.1, 0.01, 0]], atol=1e-15)
    np.testing.assert_allclose(middle, [0.0975, 0.0025, 0.0], atol=1e-15)
    slope = np.diff(made.path([1.0, 1.0 + 1e-7]), axis=0)[0]
    assert abs(slope[1]) < 1e-6 * slope[0]


def test_an_arc_is_the_circle_through_its_three_points():
    points = arc(*circle([0.0, 0.004, 0.021]))
    np.testing.assert_allclose(np.linalg.norm(points - [1.2, 0.1, 0.9], axis=1), 0.005)
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).sum() == pytest.approx(0.021, rel=1e-3)
    p = [f"{{X {x:.1f},Y 0,Z 0,A 0,B 0,C 0}}" for x in range(3)]
    text = f"DEF m( )\n$VEL.CP=1\nLIN {p[0]}\nCIRC {p[1]},{p[2]}\nEND"
    with pytest.raises(ProgramError, match="line 4, column 1: three points"):
        arcs_of(read_program(Text("m.src", text)))


def motion(speed=0.04):
    """A part with two holes of 5 mm radius that are 30 mm apart, one turn and a fifth each."""
    legs = []
    for i, x in enumerate((0.0, 0.03)):
        path = chain_arc((x, 0.0), 0.005, 0.0, 2 * np.pi * TURNS)
        timing = rest_to_rest(path.length, speed, PathLimits())
        about = {"path": path, "timing": timing, "start": 0.3 + 4.0 * i, "lead": 0.0}
        legs.append(CutLeg(**about, name=f"hole é\n{i}", kind=Kind.HOLE, asked_speed=speed))
    return PartMotion(
        legs=tuple(legs),
        plane=Plane(np.array([1.2, 0.1, 0.9])),
        middle=(0.0, 0.0),
        tool_quaternion=tuple(TURN.as_quat(scalar_first=True)),
        n_samples=2000,
    )


@pytest.mark.parametrize("language", ENDINGS)
def test_a_new_program_reads_back_as_its_contours(language):
    """Its path is on the contours but for the error that it states, rounded to 1 µm."""
    made = motion()
    new = new_program(made, language, 0.002, rapid=0.2)
    read = read_program(new.text)
    path = np.concatenate([r.path(r.samples(2e-5)) for r in rows_of(read)])
    if language == "urscript":  # blends must not overlap
        (r,) = rows_of(read)
        assert (2.0 * r.zones < np.r_[np.inf, r.spacing]).all()
    for leg in made.cuts:
        contour = made.to_base(leg.path.point(np.linspace(0.0, leg.path.length, 500)))
        away = KDTree(path).query(contour)[0].max()
        assert away < new.chord_error + 12 * UM  # samples 20 um apart
    assert 0.0 < new.chord_error < 60 * UM
    cut = [i for i in read.program.instructions if i.speed.path == 0.04]
    assert len(cut) == new.targets - 2
    for place in read.places:
        turned = Rotation.from_quat(place.aim.target.quaternion, scalar_first=True)
        assert (turned * TURN.inv()).magnitude() < 1e-8
    assert "SET" in new.text.content
    assert "beam on: hole ??0" in new.text.content
    assert new.text.content.isascii()


def test_a_place_of_a_part_is_named_in_its_drawing():
    made = motion()
    assert where(made, made.to_base(np.array([0.03, 0.0125]))) == "(30, 12.5) mm"


def test_automatic_spacing_follows_speed_and_radius():
    assert automatic_spacing(motion(0.04), 10.0) == pytest.approx(0.002)
    assert automatic_spacing(motion(0.4), 10.0) == pytest.approx(0.0025)


KRL = "DEF m( )\n$TOOL=$NULLFRAME\n$BASE=$NULLFRAME\n$VEL.CP=1\n{}\nEND"
TOOL = (np.array([0.01, -0.02, 0.15]), Rotation.from_euler("y", 0.7))
WORK = (np.array([0.8, -0.1, 0.5]), Rotation.from_euler("Z", 1.2))


def pose_of(language, at, turn):
    if language == "rapid":
        form, turned = "[[{:.4f},{:.4f},{:.4f}],[{:.12f},{:.12f},{:.12f},{:.12f}]]", turn.as_quat
        return form.format(*(1e3 * at), *turned(scalar_first=True))
    if language == "krl":
        form = "{{X {:.4f},Y {:.4f},Z {:.4f},A {:.10f},B {:.10f},C {:.10f}}}"
        return form.format(*(1e3 * at), *turn.as_euler("ZYX", degrees=True))
    form = "p[{:.7f}, {:.7f}, {:.7f}, {:.11f}, {:.11f}, {:.11f}]"
    return form.format(*at, *turn.as_rotvec())


def text_of(language, targets, zone=0.001, change=None, turned=TURN):
    """A program for targets of TCP0 in base axes (M, 3), with a tool in a work object."""
    turn = WORK[1].inv() * turned * TOOL[1]
    at = WORK[1].inv().apply(targets + turned.apply(TOOL[0]) - WORK[0])
    poses = [pose_of(language, p, turn) for p in at]
    tool, work = pose_of(language, *TOOL), pose_of(language, *WORK)
    if language == "rapid":
        lines = ["MODULE m", f"PERS tooldata t:=[TRUE,{tool},[1,[0,0,1],", "[1,0,0,0],0,0,0]];"]
        lines += ['PERS wobjdata w:=[FALSE,TRUE,"",', f"{work},[[0,0,0],[1,0,0,0]]];"]
        lines += [f"CONST zonedata z:=[FALSE,{1e3 * zone},", "1,1,1,1,1];", "PROC main()"]
        axes = f"[0,0,0,0],[{','.join(['9E9'] * 6)}]"
        lines += [f"MoveL {p[:-1]},{axes}],v40,z,t\\WObj:=w; ! {i}" for i, p in enumerate(poses)]
        lines += ["ENDPROC", "ENDMODULE"]
    elif language == "krl":
        lines = ["DEF m( )", f"$TOOL={tool}", f"$BASE={work}", "$VEL.CP=0.04"]
        lines += [f"$APO.CDIS={1e3 * zone}", *(f"LIN {p} C_DIS" for p in poses), "END"]
    else:
        lines = [f"set_tcp({tool})", f"w = {work}"]
        lines += [f"movel(pose_trans(w, {p}), v=0.04, r={zone})" for p in poses]
    content = "\n".join([*lines, ""])
    return Text(f"m{ENDINGS[language]}", content.replace(*change) if change else content)


@pytest.mark.parametrize("language", ENDINGS)
def test_targets_take_a_correction_that_they_can_follow(language):
    """In a work object, with a tool: 1.2 turns, whose overlap has two corrections."""
    made, _ = fitted(circle, LENGTH, 0.002)
    across = (made.targets - [1.2, 0.1, 0.9]) / 0.005
    k = np.arange(len(across))[:, np.newaxis]
    by = 4e-4 * np.cos(0.4 * k) * across + 7e-4 * np.sin(0.3 * k) * [0.0, 0.0, 1.0]
    w = made.samples(2e-5)
    run, goal = made.path(w), made.basis(w) @ (made.targets + by)
    text = text_of(language, made.targets)
    found = corrected(read_program(text), [(run, goal)], R)
    assert found.covered == 1.0
    assert (found.targets, found.changed) == (len(across),) * 2
    assert found.largest_offset == pytest.approx(np.linalg.norm(by, axis=1).max(), rel=0.05)
    wanted = KDTree(made.basis(made.samples(5e-6)) @ (made.targets + by))
    (after,) = rows_of(read_program(*found.texts))
    place = WORK[1].apply(after.path(w)) + WORK[0] - TURN.apply(TOOL[0])
    assert np.sqrt(np.mean(wanted.query(place)[0] ** 2)) < 10 * UM
    lines = zip(text.content.splitlines(), found.texts[0].content.splitlines(), strict=True)
    assert sum(a != b for a, b in lines) == len(across)


def test_what_targets_cannot_follow_is_left_and_what_they_do_not_reach_is_not_covered():
    """Waves of 0.7 mm, a third of the spacing, and as much of a path 30 mm beside the program."""
    made, _ = fitted(circle, LENGTH, 0.002)
    run = made.path(made.samples(2e-5))
    s = np.concatenate([[0.0], np.linalg.norm(np.diff(run, axis=0), axis=1).cumsum()])
    wave = 1e-4 * np.sin(2 * np.pi * s / 7e-4)[:, np.newaxis] * [0.0, 0.0, 1.0]
    beside = np.add(run, [0.03, 0.0, 0.0])
    text = text_of("rapid", made.targets)
    found = corrected(read_program(text), [(run, run + wave), (beside, beside)], R)
    assert found.covered == pytest.approx(0.5, abs=0.01)
    assert found.residual == pytest.approx(1e-4 / np.sqrt(2.0), rel=0.05)


@pytest.mark.parametrize("language", ENDINGS)
def test_a_run_without_a_correction_leaves_every_byte(language):
    made, _ = fitted(circle, LENGTH, 0.002)
    text = text_of(language, made.targets.round(9))
    (read,) = rows_of(read_program(text))
    w = read.samples(2e-5)
    run = WORK[1].apply(read.path(w)) + WORK[0] - TURN.apply(TOOL[0])
    assert corrected(read_program(text), [(run, run)], R).texts == (text,)


FOURTH = "]],v40,z,t\\WObj:=w; ! 4"
UNFIT = [
    ("rapid", ("tooldata t:", "tooldata u:"), "line 10, column 1: the pose of t is not in the fi"),
    ("rapid", (f"9E9{FOURTH}", f"12{FOURTH}"), "line 13, column 1: external axes move"),
    ("krl", ("$BASE={X 800", "$BASE={X 900"), "no linear moves within 1 mm"),
    ("urscript", ("set_tcp", "textmsg"), "line 4, column 1: the pose of the installation's TCP"),
]


@pytest.mark.parametrize(("language", "change", "reason"), UNFIT)
def test_a_program_that_does_not_fit_is_refused(language, change, reason):
    made, _ = fitted(circle, LENGTH, 0.002)
    run = made.path(made.samples())
    text = text_of(language, made.targets, change=change)
    with pytest.raises(ValueError, match=reason):
        corrected(read_program(text), [(run, run)], R)


def test_offsets_orientations_and_arcs_that_do_not_fit_are_refused():
    made, _ = fitted(circle, LENGTH, 0.002)
    run = made.path(made.samples())
    text = text_of("krl", made.targets)
    with pytest.raises(ValueError, match=r"move by 6 mm, at most 5 mm"):
        corrected(read_program(text), [(run, np.add(run, [0, 0, 6e-3]))], R)
    turned = R @ Rotation.from_euler("x", 2, degrees=True).as_matrix()
    with pytest.raises(ProgramError, match=r"line 6, column 1: the orientation is 2 deg"):
        corrected(read_program(text), [(run, run)], turned)
    far = "\n".join(f"LIN {{X 0,Y {90000 * (i % 2)},Z 0,A 0,B 0,C 0}}" for i in range(4))
    with pytest.raises(ValueError, match=r"270(\.\d)? m of linear moves, at most 200 m"):
        corrected(read_program(Text("m.src", KRL.format(far))), [(run, run)], R)
    lines = text.content.splitlines()
    third = [lines[5], f"CIRC {lines[7][4:-6]},{lines[9][4:]}", *lines[10:]]
    arcs = Text("m.src", "\n".join([*lines[:5], *third]))
    with pytest.raises(ProgramError, match=r"line 7, column 1: an arc cannot take a correction"):
        corrected(read_program(arcs), [(run, run)], R)
