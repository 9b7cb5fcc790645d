"""Checks of chapter 5: numbers of ours beside those of the thesis, and their bands.

The thesis shows curves with few numbers. Where it has one, the band lies around it; bands of errors
come from an earlier prototype of the robot: wide enough for another seed, too narrow for another
robot. Poses of the IRB1400 are compared with those of other toolboxes. Thesis 5.4.1.
"""

from collections.abc import Mapping
from contextlib import suppress

import numpy as np

from armside import kinematics
from armside.arrays import Array
from armside.kinematics import IRB1400
from armside.sim.cell import CELLS
from armside.sim.evaluation.check import Check
from armside.sim.imu.phases import FAST_CIRCLE, SLOW_CIRCLE
from armside.sim.imu.vibration import lines
from armside.sim.robot.kinematics_check import site_poses
from armside.sim.robot.model import load_model

from ..jobs.store import Result
from .peers import pinocchio_model, toolbox_robot

MUJOCO, PINOCCHIO, TOOLBOX = (
    "MuJoCo, the closed chain",
    "Pinocchio",
    "Robotics Toolbox, used in the thesis",
)


def motor_angles() -> Array:
    """(60, 6) [rad]: one motor at a time, 1 to 3 by 0.4 and 4 to 6 by 0.5. Thesis (5.13)."""
    moved = [(i, tenths) for i in range(6) for tenths in range(-4 - (i > 2), 5 + (i > 2))]
    angles = np.zeros((len(moved), 6))
    for row, (i, tenths) in zip(angles, moved, strict=True):
        row[i] = tenths / 10
    return angles


def differences() -> dict[str, float | None]:
    """Largest difference of an entry of the pose from ours, by toolbox; None: not installed."""
    phi = motor_angles()
    ours = kinematics.compile(IRB1400).pose(phi)
    by_mujoco, _ = site_poses(load_model(CELLS["irb1400"].xml), phi)
    q = IRB1400.joint_variables(phi)
    found: dict[str, float | None] = {MUJOCO: _largest(by_mujoco - ours)}
    found |= dict.fromkeys((PINOCCHIO, TOOLBOX))
    with suppress(ImportError):
        found[PINOCCHIO] = _largest(_by_pinocchio(q) - ours)
    with suppress(ImportError):
        peer = toolbox_robot(IRB1400)
        offset = [float(link.theta) for link in IRB1400.links]
        found[TOOLBOX] = _largest(np.array([peer.fkine(each - offset).A for each in q]) - ours)
    return found


def _by_pinocchio(q: Array) -> Array:
    """Raises ImportError where it is not installed."""
    import pinocchio as pin  # pyright: ignore[reportMissingImports]

    model, tool = pinocchio_model(IRB1400)
    data = model.createData()
    found = []
    for each in q:
        pin.framesForwardKinematics(model, data, each)
        found.append(data.oMf[tool].homogeneous)
    return np.array(found)


FROM_TCP0 = (32.0, -26.0, 90.0)  # [mm], of the IMU in the zero pose, base axes, thesis (5.1)
COUNT = 2.0 * np.pi / (2**12 - 1)  # [rad] of the encoder, motor side, thesis 5.3.1
COUNT_AT_TOOL = 1e3 * COUNT / 50.0 * 1.5  # [mm] at 1.5 m, by the smallest gear ratio
SAME_POSE = 1e-14  # [m]: rounding of a product of six transforms
ROUNDING = 1e-9  # [rad], of motor-side angles
ELASTICITY = (
    "gears and structure are elastic, and deflect most where the rectangle's second side "
    "accelerates the tool sideways: the table has the same motion with elastic gears alone, and "
    "with a rigid robot, whose error is below a count of the encoders. The prototype of the band "
    "had 0.8 mm"
)
RIGID = "all motors at once, rigid"
TILT = "the tilt of the mounting, which this processing leaves in, shows in some seeds"
AIDED = "a servo that anticipates torques moves idle motors less than that of the thesis"
SMALL_PEAK = 0.5
"""Height over the highest line up to which a peak counts as small, ESTIMATE."""
WELL = "coincide very well"
CENTRE = "in the centre, with rapid changes"


def noise(result: Result) -> list[Check]:
    """Vibration at rest."""
    off, on, level = (result[name] for name in ("off_rms", "on_rms", "on_level"))
    found = lines(result["frequency"], result["on_spectrum"][:, 1])
    near_27 = [(height, frequency) for frequency, height in found if 20.0 < frequency < 35.0]
    height, frequency = max(near_27, default=(0.0, np.nan))
    ratio, (y, z) = float((on / off)[1:].min()), map(float, level[1:])
    rms = "motors off: RMS of x, y, z, the largest [m/s²]"
    rise = "motors on over off: RMS of y and z, the smaller ratio"
    exceeded = "motors on: level that {} exceeds 0.3 % of the time [m/s²]"
    peak = "highest line of y between 20 and 35 Hz [Hz]"
    relative = "its height over that of the highest line of y"
    return [
        Check("E02.1", rms, "small", _largest(off), low=0.009, high=0.014),
        Check("E02.2", rise, "increases", ratio, low=3.0),
        Check("E02.3", exceeded.format("y"), "0.2 to 0.4", y, 0.15, 0.45),
        Check("E02.4", exceeded.format("z"), "0.2 to 0.4", z, 0.15, 0.45),
        Check("E02.5", peak, "about 27", frequency, low=25.0, high=30.0),
        Check("E02.6", relative, "a small peak", height, low=0.2, high=SMALL_PEAK),
    ]


def mounted(T_base_tool: Array, T_base_imu: Array, site: Array) -> list[Check]:
    """Zero pose: frames by the links, and the site (3,) [m] of the virtual robot."""
    offset = _largest(1e3 * (T_base_imu - T_base_tool)[:3, 3] - FROM_TCP0)
    apart = 1e3 * _largest(T_base_imu[:3, 3] - site)
    away = "IMU from TCP0, by the links: away from (32, -26, 90) mm [mm]"
    axes = "orientation by the links: largest entry away from that of the base"
    virtual = "IMU by the links, away from the site of the virtual robot [mm]"
    return [
        Check("E01.1", away, "equal", offset, high=1e-9),
        Check("E01.2", axes, "aligned", _largest(T_base_imu[:3, :3] - np.eye(3)), high=1e-12),
        Check("E01.3", virtual, "by hand, to 1 mm", apart, high=1e-3),
    ]


def _largest(values: Array) -> float:
    return float(np.abs(values).max())


def clocks(result: Result) -> list[Check]:
    """Errors of the synchronisation."""
    error, others = 1e3 * _largest(result["clock_offset_error"]), 1e3 * result["clock_errors"]
    own = "error of the offset in the experiment [ms]"
    deviation = f"standard deviation of the errors of {len(others)} others [ms]"
    return [
        Check("E04.1", own, "by hand, samples of 10 ms", error, high=1.0),
        Check("E04.2", deviation, "", float(others.std()), high=0.3),
        Check("E04.3", "the largest of them [ms]", "", _largest(others), high=1.0),
    ]


def one_at_a_time(arm: Result, wrist: Result, aided: Array, unaided: Array) -> list[Check]:
    """Sequential motion; peaks (6,) [1e-4 rad] of idle motors with and without feedforward."""
    peak = "largest peak of an idle motor, torque feedforward [1e-4 rad]"
    without = "the same without feedforward"
    return [
        _amplitude("E05.1", arm, slice(0, 3), 0.4),
        _amplitude("E05.2", wrist, slice(3, 6), 0.5),
        Check("E05.3", peak, "about 5", _largest(aided), low=2.5, high=10.0, reason=AIDED),
        Check("E05.4", without, "about 5", _largest(unaided), low=2.5, high=10.0),
    ]


def _amplitude(id: str, result: Result, motors: slice, amplitude: float) -> Check:
    """Turning point of some motors that is farthest from the programmed amplitude [rad]."""
    angle = result["motor_angle"][:, motors]
    extremes = np.concatenate([angle.max(axis=0), -angle.min(axis=0)])
    farthest = float(extremes[np.abs(extremes - amplitude).argmax()])
    which, asked = f"motors {motors.start + 1} to {motors.stop}", f"{amplitude:g}"
    statement = f"{which}: turning point farthest from ±{asked} rad [rad]"
    return Check(id, statement, asked, farthest, amplitude - 1e-3, amplitude + 1e-3)


def all_at_once(result: Result) -> list[Check]:
    """Simultaneous motion: encoder, speeds reached, return to the zero pose."""
    angle = result["motor_angle"]
    steps = np.abs(np.diff(angle * np.abs(result["gear"]), axis=0))
    count = 1e3 * float(steps[steps > ROUNDING].min())
    step, thesis = "smallest step in the log, motor side [mrad]", "2π/(2¹² − 1), which is 1.5344"
    zero = "largest motor angle at the first and the last instant [rad]"
    return [
        Check("E03.1", step, thesis, count, low=1e3 * COUNT - 1e-4, high=1e3 * COUNT + 1e-4),
        _speed("E06.1", "slow", result, SLOW_CIRCLE),
        _speed("E06.2", "fast", result, FAST_CIRCLE),
        Check("E06.3", zero, "zero pose", _largest(angle[[0, -1]]), high=1e-3),
    ]


def _speed(id: str, circle: str, result: Result, speed: float) -> Check:
    reached = result["move_reached"][result["move_speed"] == speed].min()
    statement = f"{circle} circle: speed that the tool reaches, slower half [m/s]"
    return Check(id, statement, f"{speed:g}", reached, low=0.99 * speed, high=1.01 * speed)


def distances(results: Mapping[str, Result]) -> list[Check]:
    """Tool against D-H of the motor angles: three motions, and a rigid robot, by name."""
    found = []
    for i, name in enumerate([*list(results)[:3], RIGID], start=1):
        ours, reason = 1e3 * results[name]["tool_distance"], ELASTICITY if i == 3 else ""
        statement = f"{name}: tool to D-H of the motor angles, largest [mm]"
        band = (None, COUNT_AT_TOOL) if name == RIGID else (0.2, 1.5)
        found.append(Check(f"E07.{i}", statement, WELL, float(ours), *band, reason=reason))
    return found


def toolbox_poses(peers: Mapping[str, float | None]) -> Check:
    """Poses by other toolboxes against ours, those that are installed."""
    largest = max(e for e in peers.values() if e is not None)
    statement = "poses by other toolboxes on the angles of (5.13): largest difference [m]"
    return Check("E07.5", statement, "magnitude of 1e-15", largest, high=SAME_POSE)


def rates(result: Result) -> list[Check]:
    """Error of the predicted angular velocity."""
    rms, largest = (_largest(result[f"angular_velocity_{name}"]) for name in ("rms", "max"))
    error = "measured minus predicted: {} [rad/s]"
    return [
        Check("E08.1", error.format("RMS of the worst axis"), WELL, rms, high=0.025),
        Check("E08.2", error.format("largest"), WELL, largest, high=0.15),
    ]


def accelerations(result: Result) -> list[Check]:
    """Error of the predicted acceleration, and size of the measured one."""
    worst, peak = _largest(result["acceleration_rms"]), result["acceleration_peak"]
    z, clipped = float(peak[2] / peak[:2].min()), float(result["clipped_share"])
    error = "measured minus predicted: RMS of the worst axis [m/s²]"
    size, axes = "largest measured acceleration", "between 5 and 10, by its axis"
    end = "fraction of samples at the end of the accelerometer's range"
    return [
        Check("E09.1", error, "agree well", worst, high=0.15),
        Check("E09.2", f"{size} [m/s²]", axes, _largest(peak), low=5.0, high=10.0),
        Check("E09.3", f"{size}: z over the smaller of x and y", "lower in z", z, high=1.0),
        Check("E09.4", end, "its range is ±1.7 g", clipped, high=1e-3),
    ]


def windows(result: Result) -> list[Check]:
    """Moving RMS of the acceleration error, by default and processed as in the thesis."""
    default = result["acceleration_window_max"]
    thesis = result["as_thesis_acceleration_window_max"]
    x, y, z = map(float, thesis)
    smaller, counted = "smaller in z", "of x and y, how many have their largest in the rectangle"
    inside, inside_as_thesis = (
        float(result[f"{prefix}largest_in_rectangle"][:2].sum()) for prefix in ("", "as_thesis_")
    )
    ratio, fast = float(default[2] / default[:2].min()), float(result["fast_over_slow"])
    of_xy = "z over the smaller of x and y"
    over = "RMS in the rectangle over that in the slow circle"
    as_thesis, axis = "processed as in the thesis: ", "below 0.8, by its axis"
    largest = f"{as_thesis}largest RMS of {{}} [m/s²]"
    return [
        Check("E10.1", "largest RMS of the worst axis [m/s²]", axis, _largest(default), high=0.8),
        Check("E10.2", f"largest RMS: {of_xy}", smaller, ratio, high=1.0),
        Check("E10.3", counted, CENTRE, inside, low=2),
        Check("E10.4", over, "high where changes are rapid", fast, low=3.0),
        Check("E10.5", largest.format("x"), axis, x, low=0.15, high=0.8),
        Check("E10.6", largest.format("y"), axis, y, low=0.15, high=0.8),
        Check("E10.7", largest.format("z"), axis, z, high=0.35),
        Check("E10.8", f"{as_thesis}{of_xy}", smaller, z / min(x, y), high=1.0),
        Check("E10.9", as_thesis + counted, CENTRE, inside_as_thesis, low=2, reason=TILT),
    ]
