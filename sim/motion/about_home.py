"""Motions about a robot's home pose, for robots without motion programs of their own."""

from collections.abc import Callable, Iterable, Mapping

import mujoco
import numpy as np

from armside.arrays import Array
from armside.kinematics import Limits

from ..robot.model import RobotModel
from .instructions import Dynamics, Instruction, MoveJ, Program, Speed, Target, Wait

SWING = 0.5
"""Largest departure of a motor from home [rad] or [m]. Thesis 5.3.2, Fig. 5.4, where it is 0.5 rad.
"""
OF_RANGE = 0.25
"""Largest departure over the range of a motor, and over its distance from a limit 0.8. ESTIMATE."""
OF_DISTANCE = 0.8
RISE = 0.3
"""Time in which a motor reaches its speed limit [s]. ESTIMATE."""
OF_TORQUE = 0.3
"""Fraction of a drive's torque limit that accelerates its axis. ESTIMATE."""
PATH_ACCELERATION = 9.0
"""[m/s^2]; no move of these programs follows a path."""
SHARE = 0.35
"""Fraction of the joints' speed, as in the programs of one motor at a time of the IRB1400."""
SYNCHRONISED, PAUSE = 1.0, 0.5
"""Waits after the synchronisation, and between motors [s]."""


def programs_about(
    home: Array, limits: Limits, model: RobotModel, motion: str
) -> dict[str, Program]:
    """Programs of a motion by name: all motors at once, or one at a time.

    The clocks are synchronised by a swing of all motors before the motion. home: (n,) [rad].

    Raises ValueError for an unknown motion, or a home without room about it.
    """
    if motion not in MOTIONS:
        raise ValueError(f"Unknown motion {motion!r}. It can be: {', '.join(MOTIONS)}")
    low, high = room(home, limits)
    swing = home + (high - home) / 3.0, home + (low - home) / 3.0, home
    moves = [*map(_move, swing), Wait(seconds=SYNCHRONISED), *MOTIONS[motion](home, low, high)]
    dynamics = dynamics_of(home, limits, model)
    start = tuple(home.tolist())
    return {motion: Program(instructions=tuple(moves), start=start, dynamics=dynamics)}


def room(home: Array, limits: Limits) -> tuple[Array, Array]:
    """Lowest and highest motor angles (n,) [rad] of a motion about home.

    Any combination of them is within the ranges, of single motors and of their sums.

    Raises ValueError where a motor cannot move at all.
    """
    lower, upper = np.array(limits.lower), np.array(limits.upper)
    most = np.minimum(SWING, OF_RANGE * (upper - lower))
    down = np.minimum(most, OF_DISTANCE * (home - lower))
    up = np.minimum(most, OF_DISTANCE * (upper - home))
    for bound in limits.coupled:
        c = np.array(bound.coefficients)
        there = float(c @ home)
        largest = float(np.maximum(c * up, -c * down).sum())
        smallest = float(np.maximum(-c * up, c * down).sum())
        left = OF_DISTANCE * np.array([bound.upper - there, there - bound.lower])
        over = float(max(np.array([largest, smallest]) / np.maximum(left, 1e-12)))
        if over > 1.0:
            used = c != 0.0
            down[used], up[used] = down[used] / over, up[used] / over
    if len(stuck := np.flatnonzero(down + up < 1e-3)):
        motor = f"motor {int(stuck[0]) + 1}"
        raise ValueError(f"{motor} has no room about home: give another home, or a motion program")
    return home - down, home + up


def dynamics_of(home: Array, limits: Limits, model: RobotModel) -> Dynamics:
    """Limits of acceleration: by the speed limits, and by torque over inertia at home."""
    mj = model.mj
    data, M = mujoco.MjData(mj), np.zeros((mj.nv, mj.nv))
    data.qpos[:] = mj.qpos0 + model.posture @ home
    mujoco.mj_forward(mj, data)
    mujoco.mj_fullM(mj, data, M)
    inertia = np.diag(M)[model.motor]
    by_torque = OF_TORQUE * model.drives.torque_limit * model.drives.gear / inertia
    acceleration = np.minimum(np.array(limits.speed) / RISE, np.abs(by_torque))
    return Dynamics(
        joint_acceleration=tuple(acceleration.tolist()), path_acceleration=PATH_ACCELERATION
    )


def _move(angles: Array) -> MoveJ:
    return MoveJ(to=Target(motors=tuple(angles.tolist())), speed=Speed(share=SHARE))


def _together(home: Array, low: Array, high: Array) -> Iterable[Instruction]:
    """Every motor to both its ends, in corners of which neighbours differ."""
    odd = np.arange(len(home)) % 2 == 1
    pairs = np.arange(len(home)) // 2 % 2 == 1
    for up in (~odd, odd, pairs, ~pairs, np.ones_like(odd), np.zeros_like(odd)):
        yield _move(np.where(up, high, low))
    yield _move(home)


def _one_by_one(home: Array, low: Array, high: Array) -> Iterable[Instruction]:
    """Each motor to both its ends and back, the others at home."""
    for own in np.eye(len(home), dtype=bool):
        yield from (_move(np.where(own, end, home)) for end in (high, low, home))
        yield Wait(seconds=PAUSE)


MOTIONS: Mapping[str, Callable[[Array, Array, Array], Iterable[Instruction]]] = {
    "simultaneous": _together,
    "sequential": _one_by_one,
}
