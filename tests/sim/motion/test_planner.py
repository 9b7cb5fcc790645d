"""Programs become motions that keep the limits, follow their paths and say what slowed them."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from armside import kinematics
from armside.assets import IRB1400_XML
from armside.kinematics import IRB1400, IRB1400_LIMITS, LARGE_ROBOT, LARGE_ROBOT_LIMITS
from armside.kinematics.rigid import transform
from armside.kinematics.rotation import from_quaternion, slerp
from armside.sim.motion.curves import move_curve, zone_fraction
from armside.sim.motion.instructions import (
    Dynamics,
    MoveC,
    MoveJ,
    MoveL,
    Program,
    ProgramError,
    Speed,
    Target,
    Wait,
)
from armside.sim.motion.planner import plan_program, straight_timing
from armside.sim.motion.program_file import read_program

PROGRAMS = sorted((IRB1400_XML.parent / "programs").glob("*.toml"))
ROBOTS = {"irb1400": (IRB1400, IRB1400_LIMITS), "large": (LARGE_ROBOT, LARGE_ROBOT_LIMITS)}
ROBOT = kinematics.compile(IRB1400)
STEP = 0.004
FORWARD = (np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0)
A, B, C = (0.95, -0.15, 1.0), (0.95, 0.15, 1.0), (1.05, 0.15, 1.1)
START = tuple(
    kinematics.inverse_nearest(
        IRB1400,
        transform(from_quaternion(FORWARD), A),
        [0, 0, 0, 0, -0.3, 0],
        IRB1400_LIMITS,
    )
)


def plan(*instructions, start=START, dynamics=None, **options):
    program = Program(instructions=instructions, start=start, dynamics=dynamics or Dynamics())
    return plan_program(program, IRB1400, IRB1400_LIMITS, **options)


def line(to, speed=0.2, **options):
    return MoveL(to=Target(position=to), speed=Speed(path=speed), **options)


def joints(*motors, fraction=0.5, **options):
    return MoveJ(to=Target(motors=motors), speed=Speed(share=fraction), **options)


def tool(motion):
    T = ROBOT.pose(motion.phi)
    return T[:, :3, 3], T[:, :3, :3]


def rates(motion):
    rate = np.gradient(motion.phi, STEP, axis=0)
    return rate, np.gradient(rate, STEP, axis=0)


@cache
def shipped(name):
    program = read_program(IRB1400_XML.parent / "programs" / name)
    return program, plan_program(program, *ROBOTS[name.split("_")[0]])


def test_a_line_is_straight_and_run_at_its_speed():
    motion = plan(line(B))
    p, R = tool(motion)
    np.testing.assert_allclose(p[0], A, rtol=0, atol=1e-12)
    np.testing.assert_allclose(p[-1], B, rtol=0, atol=1e-9)
    # The spline through solutions 2 mm apart leaves the line by less than 10 nm.
    np.testing.assert_allclose(p[:, [0, 2]], np.tile([0.95, 1.0], (len(p), 1)), rtol=0, atol=1e-8)
    np.testing.assert_allclose(R, np.tile(R[0], (len(R), 1, 1)), rtol=0, atol=1e-7)
    speed = np.linalg.norm(np.gradient(p, STEP, axis=0), axis=1)
    assert speed.max() == pytest.approx(0.2, rel=1e-4)
    (report,) = motion.reports
    assert report.reached == pytest.approx(0.2, rel=1e-4)
    assert report.limited_by == ""


def test_a_circle_goes_through_its_three_points_in_order():
    through = MoveC(via=C, to=Target(position=B), speed=Speed(path=0.2))
    p, _ = tool(plan(through))
    for point in (A, B, C):
        # Between samples the tool moves 0.8 mm.
        assert np.linalg.norm(p - point, axis=1).min() < 0.5e-3
    at_c = np.argmin(np.linalg.norm(p - C, axis=1))
    assert 0 < at_c < len(p) - 1
    a, b, c = map(np.array, (A, B, C))
    n = np.cross(b - a, c - a)
    # The centre lies in the plane of the points and on the bisectors of two chords.
    M = np.stack([b - a, c - a, n])
    centre = np.linalg.solve(M, [(b @ b - a @ a) / 2, (c @ c - a @ a) / 2, n @ a])
    radius = np.linalg.norm(p - centre, axis=1)
    # The spline through solutions 2 mm apart leaves the circle by 20 nm where the wrist turns fast.
    np.testing.assert_allclose(radius, np.linalg.norm(a - centre), rtol=0, atol=1e-7)


def test_a_circle_may_go_three_quarters_around():
    centre, radius = np.array([0.95, 0.0, 1.0]), 0.15
    over = (0.95, -radius * np.cos(0.3), 1.0 + radius * np.sin(0.3))
    down = (0.95, 0.0, 1.0 - radius)
    p, _ = tool(plan(MoveC(via=over, to=Target(position=down), speed=Speed(path=0.2))))
    way = np.linalg.norm(np.diff(p, axis=0), axis=1).sum()
    assert way == pytest.approx(1.5 * np.pi * radius, rel=1e-4)
    np.testing.assert_allclose(np.linalg.norm(p - centre, axis=1), radius, rtol=0, atol=1e-6)
    np.testing.assert_allclose(p[-1], down, rtol=0, atol=1e-9)


def test_circles_keep_the_path_acceleration_while_they_speed_up():
    dynamics = Dynamics(path_acceleration=1.0)
    move = MoveC(via=C, to=Target(position=B), speed=Speed(path=0.35))
    p, _ = tool(plan(move, dynamics=dynamics))
    a = np.linalg.norm(np.gradient(np.gradient(p, STEP, axis=0), STEP, axis=0), axis=1)
    assert 0.9 < a.max() < 1.0 + 1e-3


def test_circles_keep_the_joint_accelerations_while_they_speed_up():
    slow = (0.5, 0.5, 0.5, 1.0, 1.0, 1.0)
    dynamics = Dynamics(joint_acceleration=slow, path_acceleration=100.0)
    motion = plan(MoveC(via=C, to=Target(position=B), speed=Speed(path=1.0)), dynamics=dynamics)
    use = np.abs(rates(motion)[1]).max(axis=0) / slow
    assert 0.8 < use.max() < 1.0 + 1e-2


def test_a_pose_is_reached_in_the_configuration_asked_for():
    def wrist(near):
        to = Target(position=A, quaternion=FORWARD, near=near)
        return plan(MoveJ(to=to, speed=Speed(share=1.0)), start=(0.0,) * 6).phi[-1, 4]

    assert wrist((0.0, 0.0, 0.0, 0.0, -0.3, 0.0)) < 0.0
    assert wrist((0.0, 0.0, 0.0, 2.5, 0.3, -2.5)) > 0.0


def test_a_zone_is_measured_at_the_tool_from_either_end():
    move = joints(0.8, -0.3, 0.2, 0.0, -0.5, 0.0)
    curve = move_curve(move, np.array(START), ROBOT, IRB1400_LIMITS)
    ends = ROBOT.pose(np.ascontiguousarray(curve.at([0.0, 1.0])))[:, :3, 3]
    for at_end in (False, True):
        fraction = zone_fraction(curve, 0.05, ROBOT, at_end=at_end)
        edge = ROBOT.pose(curve.at(1.0 - fraction if at_end else fraction))[:3, 3]
        assert np.linalg.norm(edge - ends[int(at_end)]) == pytest.approx(0.05, rel=1e-3)


def test_a_joint_move_is_straight_in_the_motor_angles():
    motion = plan(joints(0.3, -0.2, 0.1, 0.4, -0.5, 0.6))
    way = motion.phi - motion.phi[0]
    full = way[-1]
    fraction = way @ full / (full @ full)
    np.testing.assert_allclose(way, np.outer(fraction, full), rtol=0, atol=1e-12)
    np.testing.assert_allclose(motion.phi[-1], [0.3, -0.2, 0.1, 0.4, -0.5, 0.6], rtol=0, atol=1e-12)


def test_orientation_rotates_evenly_with_arc_length():
    q_end = tuple(np.array([0.75, 0.05, 0.65, 0.1]) / np.linalg.norm([0.75, 0.05, 0.65, 0.1]))
    move = MoveL(to=Target(position=B, quaternion=q_end), speed=Speed(path=0.1))
    p, R = tool(plan(move))
    fraction = np.clip((p[:, 1] + 0.15) / 0.3, 0.0, 1.0)
    expected = from_quaternion(slerp(FORWARD, q_end, fraction))
    np.testing.assert_allclose(R, expected, rtol=0, atol=1e-6)


def test_stop_points_are_stopped_at_and_zones_are_not():
    def slowest_near_b(zone):
        motion = plan(line(B, 0.3, zone=zone), line(C, 0.3))
        p, _ = tool(motion)
        speed = np.linalg.norm(np.gradient(p, STEP, axis=0), axis=1)
        middle = slice(len(p) // 4, 3 * len(p) // 4)
        return speed[middle].min(), np.linalg.norm(p - B, axis=1).min()

    stop_speed, stop_distance = slowest_near_b(0.0)
    zone_speed, zone_distance = slowest_near_b(0.02)
    assert stop_speed < 0.01
    assert stop_distance < 1e-6
    assert zone_speed > 0.1
    assert 1e-3 < zone_distance < 0.02


def test_a_corner_stays_within_its_zone_and_leaves_the_rest_of_the_lines():
    p, _ = tool(plan(line(B, 0.3, zone=0.02), line(C, 0.3)))
    outside = np.linalg.norm(p - B, axis=1) > 0.0201
    direction = (np.array(C) - B) / np.linalg.norm(np.array(C) - B)
    on_first = np.linalg.norm((p - B)[:, [0, 2]], axis=1) < 1e-7
    on_second = np.linalg.norm((p - B) - np.outer((p - B) @ direction, direction), axis=1) < 1e-7
    assert np.all((on_first | on_second)[outside])
    assert not np.all((on_first | on_second)[~outside])


@pytest.mark.parametrize("speeds", [(0.03, 0.3), (0.3, 0.03)])
def test_a_corner_is_taken_at_the_slower_of_its_two_speeds(speeds):
    p, _ = tool(plan(line(B, speeds[0], zone=0.02), line(C, speeds[1])))
    speed = np.linalg.norm(np.diff(p, axis=0), axis=1) / STEP
    near = np.linalg.norm(p[1:] - B, axis=1) < 0.015
    assert near.any()
    assert speed[near].max() < 1.02 * min(speeds)


def test_through_a_corner_acceleration_is_continuous():
    motion = plan(line(B, 0.3, zone=0.02), joints(*START, fraction=0.3))
    _, acceleration = rates(motion)
    jumps = np.abs(np.diff(acceleration, axis=0)).max(axis=0)
    # Full acceleration is built up in 50 ms: in one sample of 4 ms at most a twelfth of it along
    # the path; bends add as much again.
    assert np.all(jumps < 0.2 * np.array(Dynamics().joint_acceleration))


@pytest.mark.parametrize("file", PROGRAMS, ids=lambda p: p.stem)
def test_shipped_programs_keep_every_limit_and_come_home(file):
    program, motion = shipped(file.name)
    rate, acceleration = rates(motion)
    _, limits = ROBOTS[file.name.split("_")[0]]
    assert np.all(np.abs(rate).max(axis=0) <= np.array(limits.speed) * (1 + 1e-3))
    allowed = np.array(program.dynamics.joint_acceleration)
    assert np.all(np.abs(acceleration).max(axis=0) <= allowed * (1 + 1e-2))
    assert limits.contain(motion.phi).all()
    np.testing.assert_allclose(motion.phi[[0, -1]], 0.0, rtol=0, atol=1e-12)
    moves = [i for i in program.instructions if not isinstance(i, Wait)]
    assert len(motion.reports) == len(moves)


def test_the_simultaneous_program_is_the_experiment_of_the_thesis():
    program, motion = shipped("irb1400_simultaneous.toml")
    of = {report.instruction: report for report in motion.reports}
    circles = [i for i, step in enumerate(program.instructions) if isinstance(step, MoveC)]
    assert [of[i].reached for i in circles] == pytest.approx([0.5, 0.5, 1.0, 1.0], rel=1e-3)
    lines = [i for i, step in enumerate(program.instructions) if isinstance(step, MoveL)]
    assert all(of[i].programmed.path == 5.0 and of[i].limited_by for i in lines)
    # Within the axes of Fig. 5.5: every motor moves, none beyond 1.15 rad.
    assert np.all(np.ptp(motion.phi, axis=0) > 0.25)
    assert np.abs(motion.phi).max() < 1.15
    # MoveL and MoveC keep the path acceleration.
    p, _ = tool(motion)
    a = np.linalg.norm(np.gradient(np.gradient(p, STEP, axis=0), STEP, axis=0), axis=1)
    on_path = np.isin(motion.instruction, circles + lines)
    assert a[on_path].max() < program.dynamics.path_acceleration * 1.02


def test_the_sequential_programs_move_one_motor_at_a_time():
    for name, motors, size in (("arm", (0, 1, 2), 0.4), ("wrist", (3, 4, 5), 0.5)):
        _, motion = shipped(f"irb1400_sequential_{name}.toml")
        moving = np.abs(np.diff(motion.phi, axis=0)) > 0.0
        assert moving.sum(axis=1).max() == 1
        np.testing.assert_allclose(np.abs(motion.phi).max(axis=0)[list(motors)], size, atol=1e-3)


def test_a_move_too_short_for_its_speed_says_so():
    (report,) = plan(line((0.95, -0.149, 1.0), speed=1.0)).reports
    assert report.limited_by == "length of the move"
    assert report.reached < 0.5


def test_a_move_too_fast_for_a_joint_names_it():
    (report,) = plan(line(B, speed=3.0), dynamics=Dynamics(path_acceleration=100.0)).reports
    assert "motor" in report.limited_by
    assert report.reached < 3.0


def test_a_fraction_of_full_speed_slows_the_whole_move_down():
    target = (0.8, -0.2, 0.1, 0.4, -0.5, 0.6)
    full, half = plan(joints(*target, fraction=1.0)), plan(joints(*target, fraction=0.5))
    (fast,), (slow,) = full.reports, half.reports
    assert fast.reached == pytest.approx(1.0)
    assert slow.reached == pytest.approx(0.5)
    # Speed halves and acceleration quarters: twice the time, but for the jerk's own 50 ms.
    assert slow.end - slow.start == pytest.approx(2 * (fast.end - fast.start), abs=0.06)


def test_the_robot_rests_during_waits_and_rests():
    move = joints(0.3, 0, 0, 0, 0, 0)
    motion = plan(
        move,
        Wait(seconds=0.4),
        joints(*[0.0] * 6),
        start=(0.0,) * 6,
        rest_before=0.2,
    )
    still = np.all(np.diff(motion.phi, axis=0) == 0.0, axis=1)
    waiting = (motion.instruction == 1)[:-1]
    assert waiting.sum() * STEP == pytest.approx(0.4, abs=2 * STEP)
    assert still[waiting][1:-1].all()
    assert still[: round(0.2 / STEP) - 1].all()
    assert still[-round(0.5 / STEP) + 1 :].all()


def test_no_circle_goes_through_points_on_a_line():
    middle = tuple(0.5 * (np.array(A) + np.array(B)))
    with pytest.raises(ProgramError, match=r"instruction 1 \(MoveC\): .*on one line"):
        plan(MoveC(via=middle, to=Target(position=B), speed=Speed(path=0.1)))


def test_a_target_out_of_reach_says_where_and_by_how_much():
    with pytest.raises(ProgramError, match=r"MoveL\): \d+ % of the way the wrist.* mm outside"):
        plan(line((2.5, 0.0, 1.0)))
    with pytest.raises(ProgramError, match=r"MoveJ\): at its target .* mm outside the workspace"):
        plan(MoveJ(to=Target(position=(2.5, 0.0, 1.0)), speed=Speed(share=1.0)))


def test_a_joint_limit_on_the_path_names_the_motor_and_the_place():
    message = r"motor 2 leaves its range of -70 to 70 deg 8\d % of the way and reaches 80\.0 deg"
    with pytest.raises(ProgramError, match=message):
        plan(joints(0.0, np.radians(80.0), np.radians(30.0), 0.0, 0.0, 0.0), start=(0.0,) * 6)


def test_the_parallelogram_is_kept_away_from_its_singularity():
    message = "motor 3 - motor 2 leaves its range of -70 to 70 deg"
    with pytest.raises(ProgramError, match=message):
        plan(joints(0.0, np.radians(-45.0), np.radians(40.0), 0.0, 0.0, 0.0), start=(0.0,) * 6)


def test_a_move_that_goes_nowhere_is_refused():
    with pytest.raises(ProgramError, match="ends where it starts"):
        plan(line(A))


def test_slower_dynamics_never_make_a_program_faster():
    quick = plan(line(B, 0.5, zone=0.02), line(C, 0.5))
    slow = plan(
        line(B, 0.5, zone=0.02),
        line(C, 0.5),
        dynamics=replace(Dynamics(), path_acceleration=2.0, jerk_time=0.1),
    )
    assert slow.time[-1] > quick.time[-1]


def test_a_line_is_timed_as_the_fraction_of_its_way():
    """0.3 m at 0.2 m/s: from 0 to 1, never back, at most 2/3 a second; speed is its derivative."""
    program = Program(instructions=(line(B),), start=START, dynamics=Dynamics())
    timing = straight_timing(program, IRB1400, IRB1400_LIMITS)
    time = np.linspace(0.0, timing.duration, 2001)
    fraction, speed, _ = timing.at(time)
    assert (fraction[0], fraction[-1]) == pytest.approx((0.0, 1.0), abs=1e-9)
    assert speed.max() == pytest.approx(0.2 / 0.3, rel=1e-4)
    np.testing.assert_allclose(np.gradient(fraction, time)[1:-1], speed[1:-1], atol=2e-3)
