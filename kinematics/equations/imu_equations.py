"""What sensors on a robot read, as functions of its motion: the equations of a filter. Row F01.

y = (motor angles, angular velocity, specific force): the encoder of each motor, and a gyro and an
accelerometer at the last frame, in that frame's axes. The accelerometer reads R^T (a - gravity).
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from ..dh import Robot
from ..expressions.exact import exact
from .chain import ZERO, Vector, joint_variables
from .derivative import jacobian
from .dynamics import coupled
from .forward_kinematics import motor_symbols, notes, parameter_block
from .inertial_model import NO_BODY, RobotModel
from .program import Block, Program, Tape
from .recursion import State, forward, steps, swept, times, tree


def measurement(
    robot: Robot, gravity: Sequence[Any] = (0, 0, -9.82), frame: int | None = None
) -> Program:
    """y(phi, phi_dot, phi_ddot), shape (n + 6,).

    Args:
        gravity: [m/s^2] in base axes.
        frame: the sensor sits in this link's frame; the last one by default.
    """
    frame = len(robot.links) if frame is None else frame
    if not 0 < frame <= len(robot.links):
        raise ValueError(f"frame must be 1 to {len(robot.links)}, got {frame}")
    tape = Tape()
    inputs = [
        Block(name, (robot.n_joints,), motor_symbols(robot, suffix))
        for name, suffix in (("phi", ""), ("phi_dot", "d"), ("phi_ddot", "dd"))
    ]
    state = sensor_motion(tape, robot, frame, inputs, gravity)
    y = (*inputs[0].elements, *state.omega, *state.a)
    told = (
        *notes(robot),
        f"sensor: in the axes of frame {frame}; gravity {tuple(map(str, gravity))} m/s^2",
        "y: motor angles [rad], angular velocity [rad/s], specific force [m/s^2]",
    )
    out = Block("y", (len(y),), y)
    return tape.program("measurement", [*inputs, *parameter_block(robot)], [out], told)


def sensor_motion(
    tape: Tape, robot: Robot, frame: int, inputs: Sequence[Block], gravity: Sequence[Any]
) -> State:
    """omega, alpha and specific force of a link's frame in its own axes."""
    model = RobotModel(robot, (NO_BODY,) * len(robot.links))
    part = Robot(robot.links[:frame], convention=robot.convention)
    carried = tree(part)
    k = part.n_joints
    q = joint_variables(robot, inputs[0].elements)[:k]
    rates = coupled(model, tape, inputs[1].elements)[:k]
    accelerations = coupled(model, tape, inputs[2].elements)[:k]
    up: Vector = tuple(-exact(value) for value in gravity)
    chain = steps(carried, q, tape)
    states = forward(tape, chain, rates, accelerations, up)
    last = states[-1] if states else State(ZERO, ZERO, up)
    arm = swept(tape, last.omega, last.alpha, tuple(carried.tool_shift))
    a: Vector = tuple(tape(u + v) for u, v in zip(last.a, arm, strict=True))
    turn = carried.tool_turn.T
    return State(times(tape, turn, last.omega), times(tape, turn, last.alpha), times(tape, turn, a))


def measurement_jacobian(
    robot: Robot, gravity: Sequence[Any] = (0, 0, -9.82), frame: int | None = None
) -> Program:
    """H = dy / d(phi, phi_dot, phi_ddot), shape (n + 6, 3 n), derived from `measurement`."""
    program = jacobian(measurement(robot, gravity, frame), ("phi", "phi_dot", "phi_ddot"))
    return replace(program, name="measurement_jacobian")
